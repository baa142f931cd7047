//! Every shape that Rapier's constructors make, against parry's own projections at random points.

use crate::support::{
    app::*, checks::check_at_most, distances::largest_difference, sheets::ground_of_a_level,
};
use bevy::math::bounding::{Aabb3d, BoundingVolume};
use bevy::prelude::*;
use bevy_drape::{ClothCollider, SdfCollider};
use bevy_rapier3d::prelude::*;

use crate::falls::physics_app;

/// How a solid may differ from parry's shape.
#[derive(Clone, Copy)]
enum Kind {
    /// By rounding.
    Exact,
    /// The same above, as parry's has no inside.
    Ground,
    /// By a part of a cell.
    Baked,
    /// By rounding outside: inside, both have walls between the parts, but not the same.
    Union,
    /// By a part of a cell outside: inside, parry takes parts for themselves.
    Outside,
}

/// A box's corners, by the bits of their numbers.
fn corners(half: Vec3) -> Vec<Vec3> {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    (0..8).map(|i| Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2)) * half).collect()
}

const FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// A solid of which one is not as long as the other.
fn tetrahedron() -> Vec<Vec3> {
    vec![
        Vec3::new(-0.5, -0.3, -0.4),
        Vec3::new(0.6, -0.3, -0.3),
        Vec3::new(0.0, -0.3, 0.5),
        Vec3::new(0.1, 0.6, 0.0),
    ]
}

fn cases() -> Vec<(&'static str, Collider, Kind)> {
    use Kind::{Baked, Exact, Ground, Outside, Union};
    let half = Vec3::new(0.4, 0.25, 0.3);
    let trimesh =
        |flags| Collider::trimesh_with_flags(corners(half), FACES.to_vec(), flags).unwrap();
    vec![
        ("ball", Collider::ball(0.4), Exact),
        ("cuboid", Collider::cuboid(0.4, 0.25, 0.3), Exact),
        ("capsule", Collider::capsule(Vec3::ZERO, Vec3::new(0.4, 0.3, -0.2), 0.2), Exact),
        ("capsule along x", Collider::capsule_x(0.3, 0.2), Exact),
        ("capsule along y", Collider::capsule_y(0.3, 0.2), Exact),
        ("capsule along z", Collider::capsule_z(0.3, 0.2), Exact),
        ("cylinder", Collider::cylinder(0.4, 0.3), Exact),
        ("cone", Collider::cone(0.4, 0.3), Exact),
        ("half-space", Collider::halfspace(Vec3::new(1.0, 2.0, -0.5)).unwrap(), Exact),
        ("compound", compound(), Exact),
        ("height field", Collider::heightfield(heights(), 9, 13, Vec3::new(3.0, 1.0, 2.0)), Ground),
        ("convex hull", Collider::convex_hull(&tetrahedron()).unwrap(), Baked),
        ("convex mesh", Collider::convex_mesh(corners(half), &FACES).unwrap(), Baked),
        ("triangle mesh", trimesh(TriMeshFlags::ORIENTED), Baked),
        ("voxels", Collider::voxels(Vec3::new(0.2, 0.1, 0.15), &steps()), Union),
        ("convex decomposition", Collider::convex_decomposition(&corners(half), &FACES), Outside),
    ]
}

/// Parts that do not meet: where they do, each of ours goes on inside the other.
fn compound() -> Collider {
    let turned = Quat::from_rotation_z(0.6);
    Collider::compound(vec![
        (Vec3::new(-0.5, 0.0, 0.0), Quat::IDENTITY, Collider::ball(0.3)),
        (Vec3::new(0.4, 0.2, 0.1), turned, Collider::cuboid(0.25, 0.15, 0.4)),
        (Vec3::new(0.0, 1.0, 0.0), turned, Collider::capsule_y(0.25, 0.2)),
    ])
}

/// Hills, of 9 rows along z and 13 columns along x.
fn heights() -> Vec<f32> {
    let height = |at: usize| 0.3 * (0.7 * (at % 9) as f32).sin() * (0.5 * (at / 9) as f32).cos();
    (0..9 * 13).map(height).collect()
}

/// Voxels as of a flight of steps.
fn steps() -> Vec<IVec3> {
    let column = |x: i32| (0..=x).flat_map(move |y| (0..3).map(move |z| IVec3::new(x, y, z)));
    (0..4).flat_map(column).collect()
}

/// What parry has for the distance to a collider's surface.
fn signed_distance(collider: &Collider, point: Vec3) -> f32 {
    let nearest = collider.project_local_point(point, false).point;
    let distance = nearest.distance(point);
    // Of meshes, the projection does not say.
    let inside = collider.contains_local_point(point);
    if inside { -distance } else { distance }
}

/// What the adapter makes of a collider.
fn adapted(app: &mut App, collider: Collider, cloth_collider: ClothCollider) -> SdfCollider {
    let entity = spawn(app, (collider, Transform::default(), cloth_collider));
    wait(app, |app| {
        assert_eq!(failure(app, entity), None);
        app.world().get::<SdfCollider>(entity).is_some()
    });
    app.world().get::<SdfCollider>(entity).unwrap().clone()
}

#[test]
fn a_round_shape_is_its_inner_one_swollen() {
    // Parry's own projection onto round shapes is a search, and a tenth of the radius off.
    let mut app = physics_app();
    let half = Vec3::new(0.4, 0.25, 0.3);
    let hull = Collider::convex_hull(&corners(half)).unwrap();
    let round_hull = Collider::round_convex_hull(&corners(half), 0.1).unwrap();
    let [a, b, c] = [Vec3::new(0.5, 0.1, 0.0), Vec3::new(-0.4, 0.3, 0.2), Vec3::new(0.0, 0.0, 0.6)];
    for (name, inner, round, bound) in [
        (
            "cuboid",
            Collider::cuboid(0.4, 0.25, 0.3),
            Collider::round_cuboid(0.4, 0.25, 0.3, 0.1),
            1e-5,
        ),
        ("cylinder", Collider::cylinder(0.4, 0.3), Collider::round_cylinder(0.4, 0.3, 0.1), 1e-5),
        ("cone", Collider::cone(0.4, 0.3), Collider::round_cone(0.4, 0.3, 0.1), 1e-5),
        ("triangle", Collider::triangle(a, b, c), Collider::round_triangle(a, b, c, 0.1), 1e-5),
        ("hull", hull, round_hull, 0.6 * 0.8 / 64.0),
    ] {
        let made = adapted(&mut app, round, ClothCollider::default());
        let solid = made.shape.get(None).expect("no asset is waited for");
        let truth = |point| Some(signed_distance(&inner, point) - 0.1);
        let grown = if name == "hull" { 0.85 } else { 1.5 };
        let around = solid.bounds().unwrap().scale_around_center(Vec3::splat(grown));
        let (worst, at) = largest_difference(solid, around, truth);
        check_at_most(&format!("round {name}, at {at}"), worst.into(), bound);
    }
}

#[test]
fn what_has_no_inside_has_a_thickness() {
    let mut app = physics_app();
    let [a, b, c] = [Vec3::new(0.5, 0.1, 0.0), Vec3::new(-0.4, 0.3, 0.2), Vec3::new(0.0, 0.0, 0.6)];
    let d = Vec3::new(0.1, 0.8, 0.3);
    let faces = vec![[0, 1, 2], [0, 1, 3], [1, 2, 3]];
    let (hills, cells) = ground_of_a_level();
    for (name, collider) in [
        ("segment", Collider::segment(a, b)),
        ("triangle", Collider::triangle(a, b, c)),
        ("polyline", Collider::polyline(vec![a, b, c, d], None)),
        ("open mesh", Collider::trimesh(vec![a, b, c, d], faces).unwrap()),
        ("level", Collider::trimesh(hills, cells).unwrap()),
    ] {
        let wish = ClothCollider { thickness: 0.08, ..default() };
        let made = adapted(&mut app, collider.clone(), wish);
        let solid = made.shape.get(None).expect("no asset is waited for");
        let around = solid.bounds().unwrap().scale_around_center(Vec3::splat(1.5));
        let truth = |point| {
            let nearest = collider.project_local_point(point, false).point;
            Some(nearest.distance(point) - 0.04)
        };
        let (worst, at) = largest_difference(solid, around, truth);
        check_at_most(&format!("{name}, at {at}"), worst.into(), 1e-5);
    }
}

#[test]
fn every_shape_is_where_parry_has_it() {
    let mut app = physics_app();
    for (name, collider, kind) in cases() {
        let made = adapted(&mut app, collider.clone(), ClothCollider::default());
        let solid = made.shape.get(None).expect("no asset is waited for");
        let bounds = solid.bounds().unwrap_or(Aabb3d::new(Vec3::ZERO, Vec3::ONE));
        // Beyond its grid, a field is no more than a bound.
        let grown = if matches!(kind, Kind::Exact) { 1.5 } else { 1.05 };
        let mut around = bounds.scale_around_center(Vec3::splat(grown));
        if matches!(kind, Kind::Ground) {
            (around.min.y, around.max.y) = (-0.4, 1.0);
        }
        // Not beside the walls that a field of ours has, nor below its floor.
        let over = Aabb3d::from_min_max(
            Vec3::from(bounds.min).with_y(-0.4),
            Vec3::from(bounds.max).with_y(f32::MAX),
        );
        let truth = |point: Vec3| {
            let distance = signed_distance(&collider, point);
            let is_above =
                || solid.distance(point) > 0.0 && over.closest_point(point) == point.into();
            let is_known = match kind {
                Kind::Exact | Kind::Baked => true,
                Kind::Union | Kind::Outside => distance > 0.0,
                Kind::Ground => is_above(),
            };
            is_known.then_some(distance)
        };
        let (worst, at) = largest_difference(solid, around, truth);
        let side = Vec3::from(bounds.max - bounds.min).max_element();
        let bound = match kind {
            Kind::Exact | Kind::Union | Kind::Ground => 1e-5,
            Kind::Baked | Kind::Outside => 0.6 * side / 64.0,
        };
        check_at_most(&format!("{name}, at {at}"), worst.into(), bound.into());
    }
}
