//! Every shape that Avian's constructors make, against parry's own projections at random points.

use crate::support::{
    app::*, checks::check_at_most, distances::largest_difference, sheets::ground_of_a_level,
};
use avian3d::prelude::*;
use bevy::math::bounding::{Aabb3d, BoundingVolume};
use bevy::prelude::*;
use bevy_drape::{ClothCollider, SdfCollider};

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
    let trimesh = |flags| Collider::trimesh_with_config(corners(half), FACES.to_vec(), flags);
    vec![
        ("sphere", Collider::sphere(0.4), Exact),
        ("cuboid", Collider::cuboid(0.8, 0.5, 0.6), Exact),
        ("capsule", Collider::capsule(0.2, 0.7), Exact),
        (
            "capsule between",
            Collider::capsule_endpoints(0.2, Vec3::new(-0.3, 0.1, 0.2), Vec3::new(0.4, 0.3, -0.2)),
            Exact,
        ),
        ("cylinder", Collider::cylinder(0.3, 0.8), Exact),
        ("cone", Collider::cone(0.3, 0.8), Exact),
        ("half-space", Collider::half_space(Vec3::new(1.0, 2.0, -0.5)), Exact),
        ("compound", compound(), Exact),
        ("height field", Collider::heightfield(heights(), Vec3::new(3.0, 1.0, 2.0)), Ground),
        ("convex hull", Collider::convex_hull(tetrahedron()).unwrap(), Baked),
        ("triangle mesh", trimesh(TrimeshFlags::ORIENTED), Baked),
        ("voxels", Collider::voxels(Vec3::new(0.2, 0.1, 0.15), &steps()), Union),
        (
            "convex decomposition",
            Collider::convex_decomposition(corners(half), FACES.to_vec()),
            Outside,
        ),
    ]
}

/// Parts that do not meet: where they do, each of ours goes on inside the other.
fn compound() -> Collider {
    let turned = Quat::from_rotation_z(0.6);
    Collider::compound(vec![
        (Vec3::new(-0.5, 0.0, 0.0), Quat::IDENTITY, Collider::sphere(0.3)),
        (Vec3::new(0.4, 0.2, 0.1), turned, Collider::cuboid(0.5, 0.3, 0.8)),
        (Vec3::new(0.0, 1.0, 0.0), turned, Collider::capsule(0.2, 0.5)),
    ])
}

/// Hills, of 9 rows along z and 13 columns along x.
fn heights() -> Vec<Vec<f32>> {
    let height = |i: usize, j: usize| 0.3 * (0.7 * i as f32).sin() * (0.5 * j as f32).cos();
    (0..9).map(|i| (0..13).map(|j| height(i, j)).collect()).collect()
}

/// Voxels as of a flight of steps.
fn steps() -> Vec<IVec3> {
    let column = |x: i32| (0..=x).flat_map(move |y| (0..3).map(move |z| IVec3::new(x, y, z)));
    (0..4).flat_map(column).collect()
}

/// What parry has for the distance to a collider's surface.
fn signed_distance(collider: &Collider, point: Vec3) -> f32 {
    let (nearest, _) = collider.project_point(Vec3::ZERO, Quat::IDENTITY, point, false);
    let distance = nearest.distance(point);
    // Of meshes, the projection does not say.
    let inside = collider.contains_point(Vec3::ZERO, Quat::IDENTITY, point);
    if inside { -distance } else { distance }
}

/// What the adapter makes of a collider.
fn adapted(app: &mut App, collider: Collider, cloth_collider: ClothCollider) -> SdfCollider {
    let entity = spawn(app, (collider, cloth_collider));
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
    let inner = Collider::cuboid(0.8, 0.5, 0.6);
    let round = Collider::round_cuboid(0.8, 0.5, 0.6, 0.1);
    let made = adapted(&mut app, round, ClothCollider::default());
    let solid = made.shape.get(None).expect("no asset is waited for");
    let truth = |point| Some(signed_distance(&inner, point) - 0.1);
    let around = solid.bounds().unwrap().scale_around_center(Vec3::splat(1.5));
    let (worst, at) = largest_difference(solid, around, truth);
    check_at_most(&format!("round cuboid, at {at}"), worst.into(), 1e-5);
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
        ("open mesh", Collider::trimesh(vec![a, b, c, d], faces)),
        ("level", Collider::trimesh(hills, cells)),
    ] {
        let wish = ClothCollider { thickness: 0.08, ..default() };
        let made = adapted(&mut app, collider.clone(), wish);
        let solid = made.shape.get(None).expect("no asset is waited for");
        let around = solid.bounds().unwrap().scale_around_center(Vec3::splat(1.5));
        let truth = |point| {
            let (nearest, _) = collider.project_point(Vec3::ZERO, Quat::IDENTITY, point, false);
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
