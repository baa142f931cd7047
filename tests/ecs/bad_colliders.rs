//! Every number of a collider, out of its range: it is told so by its name, and left out, and the rest of
//! the world goes on in the same bits as without it.

use crate::support::app::*;
use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_drape::{
    ClothComponent, ClothError, ClothErrorKind, MeshProblem,
    prelude::*,
    sdf::{BakeError, SdfSample, SignedDistance},
};

/// A world where a sheet falls on a ball, and whoever is in the ball's place disturbs it.
fn world() -> (App, Entity) {
    let mut app = app();
    spawn(&mut app, (SdfCollider::from(Sphere::new(0.2)), Transform::from_xyz(0.0, -0.25, 0.0)));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.1, 0.0)));
    (app, cloth)
}

const TICKS: usize = 24;

/// Where the sheet is after a while, with nothing amiss.
fn undisturbed() -> Vec<[u32; 3]> {
    let (mut app, cloth) = world();
    updates(&mut app, TICKS);
    // Free fall would have brought it to -0.59 m.
    assert!(position(&app, cloth, 27).y > -0.15);
    bits(&app, cloth)
}

/// What a collider is told; the sheet has not seen it.
fn refused(bundle: impl Bundle, expected: &[[u32; 3]], what: &str) -> (App, Entity, ClothError) {
    let (mut app, cloth) = world();
    let collider = spawn(&mut app, bundle);
    updates(&mut app, TICKS);
    assert!(bits(&app, cloth) == expected, "{what}: the sheet has seen it");
    assert_eq!(failure(&app, cloth), None, "{what}");
    let Some(error) = failure(&app, collider) else {
        panic!("{what}: not refused");
    };
    assert!(error.to_string().contains(&collider.to_string()), "{error}");
    (app, collider, error)
}

/// Lengths that are none.
const BAD: [f32; 7] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.3, 0.0, 1e-30, 1e30];

#[test]
fn shapes_of_no_size_are_refused() {
    let mut table: Vec<(&str, SdfShape)> = Vec::new();
    let bone = |to, radius| SdfCollider::capsule_between(Vec3::ZERO, to, radius).shape;
    for bad in BAD {
        table.extend([
            ("sphere's radius", SdfShape::from(Sphere { radius: bad })),
            ("half size along x", Cuboid { half_size: Vec3::new(bad, 0.3, 0.3) }.into()),
            ("half size along y", Cuboid { half_size: Vec3::new(0.3, bad, 0.3) }.into()),
            ("half size along z", Cuboid { half_size: Vec3::new(0.3, 0.3, bad) }.into()),
            ("capsule's radius", Capsule3d { radius: bad, half_length: 0.1 }.into()),
            ("cylinder's radius", Cylinder { radius: bad, half_height: 0.3 }.into()),
            ("cylinder's half height", Cylinder { radius: 0.3, half_height: bad }.into()),
            ("minor radius", Torus { minor_radius: bad, major_radius: 0.3 }.into()),
            ("cone's radius", Cone { radius: bad, height: 0.3 }.into()),
            ("cone's height", Cone { radius: 0.3, height: bad }.into()),
            ("capsule's radius", bone(Vec3::Y, bad)),
        ]);
        // An end may be anywhere in the world.
        if bad.is_nan() || bad.abs() > 1e7 {
            table.push(("capsule's second end", bone(Vec3::new(0.0, 0.1, bad), 0.3)));
        }
        // A capsule without a straight part and a torus without a hole are solids.
        if bad.abs() > 1e-6 || bad.is_nan() {
            table.extend([
                ("half length", Capsule3d { radius: 0.3, half_length: bad }.into()),
                ("major radius", Torus { minor_radius: 0.3, major_radius: bad }.into()),
            ]);
        }
    }
    for normal in [Vec3::NAN, Vec3::ZERO, Vec3::Y * 2.0, Vec3::Y * f32::INFINITY] {
        let plane = InfinitePlane3d { normal: Dir3::new_unchecked(normal) };
        table.push(("plane's normal", plane.into()));
    }
    // All in one world.
    let (mut app, cloth) = world();
    let told: Vec<_> = table
        .into_iter()
        .map(|(named, shape)| {
            let what = format!("{shape:?}");
            (named, what, spawn(&mut app, SdfCollider::new(shape)))
        })
        .collect();
    updates(&mut app, TICKS);
    assert!(bits(&app, cloth) == undisturbed(), "the sheet has seen one");
    assert_eq!(failure(&app, cloth), None);
    for (named, what, collider) in told {
        let Some(ClothError {
            entity,
            kind: ClothErrorKind::Parameter { component: ClothComponent::SdfCollider, problem },
        }) = failure(&app, collider)
        else {
            panic!("{what}: {:?}", failure(&app, collider));
        };
        assert_eq!(entity, collider);
        assert!(problem.name.contains(named), "{what}: {problem}");
        give(&mut app, collider, Sphere::new(0.1));
        app.update();
        assert_eq!(failure(&app, collider), None, "{what}");
    }
}

#[test]
fn frictions_out_of_range_are_refused() {
    let expected = undisturbed();
    for friction in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1e-3, 1e4] {
        let collider = SdfCollider::from(Sphere::new(0.3)).with_friction(friction);
        let (mut app, collider, error) = refused(collider, &expected, &friction.to_string());
        assert!(error.to_string().contains("friction"), "{error}");
        app.world_mut().get_mut::<SdfCollider>(collider).unwrap().friction = 0.0;
        app.update();
        assert_eq!(failure(&app, collider), None);
    }
}

#[test]
fn transforms_that_are_no_poses_are_refused() {
    let scale = |x, y, z| Transform::from_scale(Vec3::new(x, y, z));
    let turned = |rotation| Transform::from_rotation(rotation);
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let expected = undisturbed();
    for transform in [
        scale(0.0, 0.0, 0.0),
        scale(-1.0, -1.0, -1.0),
        scale(-1.0, 1.0, 1.0),
        scale(1.0, 2.0, 1.0),
        scale(1.0, 1.0, 0.0),
        scale(nan, nan, nan),
        scale(1.0, nan, 1.0),
        scale(inf, inf, inf),
        scale(1e-30, 1e-30, 1e-30),
        scale(1e-40, 1e-40, 1e-40),
        scale(1e30, 1e30, 1e30),
        Transform::from_xyz(nan, 0.0, 0.0),
        Transform::from_xyz(0.0, inf, 0.0),
        Transform::from_xyz(0.0, 0.0, f32::NEG_INFINITY),
        turned(Quat::from_xyzw(nan, 0.0, 0.0, 1.0)),
        turned(Quat::from_xyzw(0.0, inf, 0.0, 1.0)),
    ] {
        let what = format!("{transform:?}");
        let bundle = (SdfCollider::from(Sphere::new(0.3)), transform);
        let (mut app, collider, error) = refused(bundle, &expected, &what);
        assert!(
            matches!(error, ClothError { kind: ClothErrorKind::Scale(_), .. }),
            "{what}: {error}"
        );
        *app.world_mut().get_mut::<Transform>(collider).unwrap() = Transform::IDENTITY;
        app.update();
        assert_eq!(failure(&app, collider), None, "{what}");
    }
    // The parent's counts as well.
    let (mut app, cloth) = world();
    let parent = spawn(&mut app, scale(1.0, nan, 1.0));
    let child = spawn(&mut app, (SdfCollider::from(Sphere::new(0.3)), ChildOf(parent)));
    let orphan = spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
    app.world_mut().entity_mut(orphan).remove::<Transform>();
    updates(&mut app, TICKS);
    assert_eq!(bits(&app, cloth), expected);
    assert!(matches!(
        failure(&app, child),
        Some(ClothError { kind: ClothErrorKind::Scale(_), .. })
    ));
    assert_eq!(
        failure(&app, orphan),
        Some(ClothError { entity: orphan, kind: ClothErrorKind::NoTransform })
    );
}

/// Far away, and very large or very small as they may just be: nobody sees them.
#[test]
fn colliders_at_the_ends_of_the_world_disturb_nobody() {
    let expected = undisturbed();
    for (shape, transform) in [
        (SdfShape::from(Sphere::new(0.3)), Transform::from_xyz(1e30, 0.0, 0.0)),
        (Sphere::new(0.3).into(), Transform::from_xyz(f32::MAX, f32::MIN, f32::MAX)),
        (Cuboid::new(1.0, 1.0, 1.0).into(), Transform::from_xyz(0.0, -1e25, 0.0)),
        (InfinitePlane3d::default().into(), Transform::from_xyz(0.0, -1e30, 0.0)),
        (Capsule3d::new(1.0, 1.0).into(), Transform::from_xyz(0.0, 1e38, 1e-40)),
        (Cylinder::new(1.0, 1.0).into(), Transform::from_xyz(0.0, 1e38, 1e-40)),
        (Cone { radius: 1.0, height: 1.0 }.into(), Transform::from_xyz(3e38, 3e38, 0.0)),
        (Torus::new(0.1, 1.0).into(), Transform::from_xyz(3e38, -3e38, 0.0)),
        (Sphere::new(1e7).into(), Transform::from_xyz(0.0, -2e7, 0.0)),
        (Sphere::new(1.0).into(), Transform::from_xyz(0.0, -2e6, 0.0).with_scale(Vec3::splat(1e6))),
    ] {
        let (mut app, cloth) = world();
        let what = format!("{shape:?} {transform:?}");
        let collider = spawn(&mut app, (SdfCollider::new(shape), transform));
        updates(&mut app, TICKS / 2);
        // And moving there.
        self::transform(&mut app, collider).translation *= 0.9;
        updates(&mut app, TICKS - TICKS / 2);
        assert_eq!(failure(&app, collider), None, "{what}");
        assert_eq!(failure(&app, cloth), None, "{what}");
        assert!(bits(&app, cloth) == expected, "{what}: the sheet has seen it");
    }
}

/// A ball that says of itself what it is told to.
#[derive(Debug)]
struct Boaster {
    overestimate: f32,
    half: f32,
}

impl SignedDistance for Boaster {
    fn sample(&self, point: Vec3) -> SdfSample {
        Sphere::new(0.3).sample(point)
    }

    fn bounds(&self) -> Option<Aabb3d> {
        Some(Aabb3d { min: Vec3::splat(-self.half).into(), max: Vec3::splat(self.half).into() })
    }

    fn overestimate(&self) -> f32 {
        self.overestimate
    }
}

#[test]
fn solids_of_ones_own_that_cannot_be_trusted_are_refused() {
    let expected = undisturbed();
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    for (named, overestimate, half) in [
        ("overestimate", nan, 0.3),
        ("overestimate", inf, 0.3),
        ("overestimate", -0.1, 0.3),
        ("bounds", 0.0, nan),
        ("bounds", 0.0, inf),
        ("bounds", 0.0, -0.3),
    ] {
        let shape = Boaster { overestimate, half };
        let what = format!("{shape:?}");
        let (_, _, error) = refused(SdfCollider::custom(shape), &expected, &what);
        assert!(error.to_string().contains(named), "{what}: {error}");
    }
}

/// What a collider did while it was refused is not made up for afterwards.
#[test]
fn a_mended_collider_has_not_moved() {
    let after = |way: f32| {
        let mut app = app();
        let floor = SdfCollider::from(InfinitePlane3d::default()).with_friction(1.0);
        let floor = spawn(&mut app, floor);
        let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.006, 0.0)));
        updates(&mut app, 10);
        for friction in [f32::NAN, 1.0] {
            app.world_mut().get_mut::<SdfCollider>(floor).unwrap().friction = friction;
            transform(&mut app, floor).translation.x += way;
            app.update();
        }
        assert_eq!(failure(&app, floor), None);
        bits(&app, cloth)
    };
    assert!(after(1.0) == after(0.0), "it was dragged along");
}

/// The error goes with what it was about.
#[test]
fn an_error_does_not_outlive_its_collider() {
    let mut app = app();
    let collider = SdfCollider::from(Sphere { radius: f32::NAN });
    let collider = spawn(&mut app, collider);
    updates(&mut app, 2);
    assert!(failure(&app, collider).is_some());
    app.world_mut().entity_mut(collider).remove::<SdfCollider>();
    app.update();
    assert_eq!(failure(&app, collider), None);

    let open = Mesh3d(add_mesh(&mut app, broken_box(|_, indices| indices.truncate(33))));
    let open = spawn(&mut app, (BakeSdf::with_cells(4), open));
    let sound = Mesh3d(add_mesh(&mut app, box_mesh(0.3)));
    let cancelled = spawn(&mut app, (BakeSdf::with_cells(96), sound.clone()));
    app.update();
    // It may be done already, where this thread was kept waiting.
    let done = app.world().get::<SdfCollider>(cancelled).is_some();
    app.world_mut().entity_mut(cancelled).remove::<BakeSdf>();
    wait(&mut app, |app| failure(app, open).is_some());
    app.world_mut().entity_mut(open).remove::<BakeSdf>();
    let other = spawn(&mut app, (BakeSdf::with_cells(32), sound));
    wait(&mut app, |app| app.world().get::<SdfCollider>(other).is_some());
    assert_eq!(failure(&app, open), None);
    assert_eq!(app.world().get::<SdfCollider>(cancelled).is_some(), done);
}

fn give(app: &mut App, collider: Entity, shape: impl Into<SdfShape>) {
    app.world_mut().get_mut::<SdfCollider>(collider).unwrap().shape = shape.into();
}

#[test]
fn colliders_that_go_while_they_are_touched_leave_the_cloth_falling() {
    let ways: [fn(&mut App, Entity); 7] = [
        |app, ball| assert!(app.world_mut().despawn(ball)),
        |app, ball| {
            app.world_mut().entity_mut(ball).remove::<SdfCollider>();
        },
        |app, ball| {
            app.world_mut().entity_mut(ball).remove::<Transform>();
        },
        |app, ball| transform(app, ball).scale = Vec3::NAN,
        |app, ball| transform(app, ball).translation.x = f32::INFINITY,
        |app, ball| give(app, ball, Sphere { radius: f32::NAN }),
        |app, ball| give(app, ball, Handle::default()),
    ];
    for remove in ways {
        let mut app = app();
        let ball = spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
        let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.31, 0.0)));
        updates(&mut app, 20);
        let before = position(&app, cloth, 27).y;
        // Free fall would have brought it to -0.17 m.
        assert!(before > 0.2, "{before}");
        remove(&mut app, ball);
        updates(&mut app, 20);
        assert_eq!(simulation(&app, cloth).last_tick().unwrap().contact_count, 0);
        assert!(position(&app, cloth, 27).y < before - 0.2);
        assert_eq!(failure(&app, cloth), None);
        assert!(positions(&app, cloth).iter().all(|p| p.is_finite()));
    }
}

/// The flat box of `box_mesh`, changed.
fn broken_box(change: impl Fn(&mut Vec<[f32; 3]>, &mut Vec<u32>)) -> Mesh {
    let sound = box_mesh(0.3);
    let mut positions: Vec<_> =
        attribute(&sound, Mesh::ATTRIBUTE_POSITION).iter().map(Vec3::to_array).collect();
    let mut indices = sound.indices().unwrap().iter().map(|i| i as u32).collect();
    change(&mut positions, &mut indices);
    triangle_mesh(positions, indices)
}

#[test]
fn meshes_and_cells_that_bake_to_nothing_are_told_of() {
    let lines = || {
        Mesh::new(bevy::mesh::PrimitiveTopology::LineList, default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0; 3]; 4])
    };
    let bare = || Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default());
    let soup = || bare().with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0; 3]; 3]);
    let count = BakeSdf::with_cells;
    let size = BakeSdf::with_cell_size;
    let mesh = |problem| {
        move |error: &ClothError| match error {
            ClothError { kind: ClothErrorKind::ColliderMesh(found), .. } => *found == problem,
            _ => false,
        }
    };
    let bake = |is: fn(&BakeError) -> bool| {
        move |error: &ClothError| match error {
            ClothError { kind: ClothErrorKind::Bake(problem), .. } => is(problem),
            _ => false,
        }
    };
    type Expected = Box<dyn Fn(&ClothError) -> bool>;
    let table: Vec<(&str, BakeSdf, Option<Mesh>, Expected)> = vec![
        ("no mesh", count(8), None, Box::new(mesh(MeshProblem::NoMesh))),
        ("lines", count(8), Some(lines()), Box::new(mesh(MeshProblem::NotTriangles))),
        ("no data", count(8), Some(bare()), Box::new(mesh(MeshProblem::NoPositions))),
        (
            "no indices, and no volume",
            count(8),
            Some(soup()),
            Box::new(bake(|e| matches!(e, BakeError::NoVolume))),
        ),
        (
            "NaN",
            count(8),
            Some(broken_box(|p, _| p[3][1] = f32::NAN)),
            Box::new(mesh(MeshProblem::NonFinite(3))),
        ),
        (
            "infinite",
            count(8),
            Some(broken_box(|p, _| p[0][2] = f32::INFINITY)),
            Box::new(mesh(MeshProblem::NonFinite(0))),
        ),
        (
            "no triangles",
            count(8),
            Some(broken_box(|_, i| i.clear())),
            Box::new(bake(|e| *e == BakeError::Empty)),
        ),
        (
            "a partial triangle",
            count(8),
            Some(broken_box(|_, i| i.truncate(35))),
            Box::new(mesh(MeshProblem::LooseIndices(35))),
        ),
        (
            "an index too large",
            count(8),
            Some(broken_box(|_, i| i[7] = 99)),
            Box::new(bake(|e| matches!(e, BakeError::IndexOutOfRange { index: 99, .. }))),
        ),
        (
            "open",
            count(8),
            Some(broken_box(|_, i| i.truncate(33))),
            Box::new(bake(|e| matches!(e, BakeError::NotClosed { open_edges: 3 }))),
        ),
        (
            "flat",
            count(8),
            Some(broken_box(|p, _| p.iter_mut().for_each(|p| p[1] = 0.0))),
            Box::new(bake(|e| matches!(e, BakeError::NoVolume | BakeError::NonManifold { .. }))),
        ),
        (
            "a point",
            count(8),
            Some(broken_box(|p, _| p.fill([0.5; 3]))),
            Box::new(bake(|e| matches!(e, BakeError::NoVolume))),
        ),
        (
            "huge",
            count(8),
            Some(broken_box(|p, _| p.as_flattened_mut().iter_mut().for_each(|x| *x *= 1e38))),
            Box::new(mesh(MeshProblem::NonFinite(0))),
        ),
        (
            "tiny",
            count(8),
            Some(broken_box(|p, _| p.as_flattened_mut().iter_mut().for_each(|x| *x *= 1e-30))),
            Box::new(bake(|e| matches!(e, BakeError::CellSize { .. }))),
        ),
        (
            "too many cells",
            count(u32::MAX),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| {
                matches!(e, BakeError::CellSize { .. } | BakeError::TooLarge { .. })
            })),
        ),
        (
            "cells of NaN",
            size(f32::NAN, 0.1),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| matches!(e, BakeError::CellSize { .. }))),
        ),
        (
            "no cells at all",
            count(0),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| matches!(e, BakeError::NoCells))),
        ),
        (
            "no cells",
            size(0.0, 0.1),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| matches!(e, BakeError::CellSize { .. }))),
        ),
        (
            "a negative margin",
            size(0.1, -0.1),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| matches!(e, BakeError::Margin { .. }))),
        ),
        (
            "a margin of NaN",
            size(0.1, f32::NAN),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| matches!(e, BakeError::Margin { .. }))),
        ),
        (
            "a huge margin",
            size(0.1, 1e9),
            Some(box_mesh(0.3)),
            Box::new(bake(|e| matches!(e, BakeError::TooLarge { .. }))),
        ),
    ];
    let mut app = app();
    let sound = Mesh3d(add_mesh(&mut app, box_mesh(0.3)));
    let sound = spawn(&mut app, (BakeSdf::with_cells(8), sound));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.31, 0.0)));
    let mut told = Vec::new();
    for (what, bake, mesh, expected) in table {
        let collider = spawn(&mut app, bake);
        if let Some(mesh) = mesh {
            let mesh = Mesh3d(add_mesh(&mut app, mesh));
            app.world_mut().entity_mut(collider).insert(mesh);
        }
        told.push((what, collider, expected));
    }
    // One that goes while it is baked.
    let gone = spawn(&mut app, BakeSdf::with_cells(64));
    let mesh = Mesh3d(add_mesh(&mut app, box_mesh(0.3)));
    app.world_mut().entity_mut(gone).insert(mesh);
    app.update();
    app.world_mut().despawn(gone);
    wait(&mut app, |app| told.iter().all(|(_, collider, _)| failure(app, *collider).is_some()));
    wait(&mut app, |app| app.world().get::<SdfCollider>(sound).is_some());
    for (what, collider, expected) in &told {
        let error = failure(&app, *collider).unwrap();
        assert!(expected(&error), "{what}: {error}");
        assert!(error.to_string().contains(&collider.to_string()), "{what}: {error}");
        assert!(app.world().get::<SdfCollider>(*collider).is_none(), "{what}");
    }
    assert_eq!((failure(&app, sound), failure(&app, cloth)), (None, None));
    // Each is tried again when it is given a mesh that will do.
    for (_, collider, _) in &told {
        let mesh = Mesh3d(add_mesh(&mut app, box_mesh(0.3)));
        app.world_mut().entity_mut(*collider).insert((mesh, BakeSdf::with_cells(4)));
    }
    wait(&mut app, |app| {
        told.iter().all(|(_, collider, _)| app.world().get::<SdfCollider>(*collider).is_some())
    });
    assert!(told.iter().all(|(_, collider, _)| failure(&app, *collider).is_none()));
}

#[test]
fn a_mended_pose_is_forgiven_though_a_number_is_bad() {
    let (mut app, _) = world();
    let flat = Transform::from_scale(Vec3::ZERO);
    let collider = spawn(&mut app, (SdfCollider::from(Sphere::new(0.3)), flat));
    app.update();
    assert!(matches!(
        failure(&app, collider),
        Some(ClothError { kind: ClothErrorKind::Scale(_), .. })
    ));
    let bad = SdfCollider::from(Sphere::new(-1.0));
    app.world_mut().entity_mut(collider).insert((Transform::IDENTITY, bad));
    app.update();
    let failure = app.world().get::<ClothFailure>(collider).unwrap();
    assert_eq!(failure.errors().count(), 1, "{failure:?}");
    assert!(matches!(failure.error.kind, ClothErrorKind::Parameter { .. }));
}
