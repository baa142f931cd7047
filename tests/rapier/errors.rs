//! What cannot be used is told, on its own entity alone.

use crate::falls::physics_app;
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothCollider, ClothErrorKind, EngineProblem,
    prelude::*,
    sdf::{BakeError, shapes::HeightFieldError},
};
use bevy_rapier3d::parry::shape::SharedShape;
use bevy_rapier3d::prelude::*;

/// The problem with an entity's collider.
fn problem(app: &App, entity: Entity) -> Option<EngineProblem> {
    match failure(app, entity)?.kind {
        ClothErrorKind::Engine(problem) => Some(problem),
        other => panic!("{other}"),
    }
}

/// The problem of a collider, which is no solid.
fn refused(collider: Collider, wish: ClothCollider) -> EngineProblem {
    let mut app = physics_app();
    let ball =
        spawn(&mut app, (Collider::ball(0.2), Transform::default(), ClothCollider::default()));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.3, 0.0)));
    let entity = spawn(&mut app, (collider, Transform::default(), wish));
    wait(&mut app, |app| failure(app, entity).is_some());
    updates(&mut app, 20);
    assert!(app.world().get::<SdfCollider>(entity).is_none());
    // The others go on.
    assert_eq!((failure(&app, ball), failure(&app, cloth)), (None, None));
    assert!(positions(&app, cloth).iter().all(|p| p.length() > 0.2));
    let told = failure(&app, entity).unwrap().to_string();
    assert!(told.contains(&entity.to_string()), "{told}");
    let problem = problem(&app, entity).unwrap();
    // It is mended by another shape, and by taking the mark off.
    app.world_mut().entity_mut(entity).insert((Collider::ball(0.1), ClothCollider::default()));
    app.update();
    assert_eq!(failure(&app, entity), None);
    problem
}

fn triangle() -> [Vec3; 3] {
    [Vec3::ZERO, Vec3::X, Vec3::Z]
}

#[test]
fn what_has_no_inside_is_refused() {
    let [a, b, c] = triangle();
    for (collider, name) in [
        (Collider::segment(a, b), "segment"),
        (Collider::triangle(a, b, c), "triangle"),
        (Collider::polyline(vec![a, b, c], None), "polyline"),
    ] {
        let expected = EngineProblem::NoInside { shape: name };
        assert_eq!(refused(collider, ClothCollider::default()), expected);
    }
}

#[test]
fn open_meshes_are_refused() {
    let open = Collider::trimesh(triangle().to_vec(), vec![[0, 1, 2]]).unwrap();
    let problem = refused(open, ClothCollider::default());
    assert_eq!(problem, EngineProblem::OpenMesh { shape: "triangle mesh", open_edges: 3 });
    let twice = Collider::trimesh(triangle().to_vec(), vec![[0, 1, 2], [0, 2, 1]]).unwrap();
    let expected = EngineProblem::Bake { shape: "triangle mesh", problem: BakeError::NoVolume };
    assert_eq!(refused(twice, ClothCollider::default()), expected);
}

#[test]
fn too_long_lines_are_not_thickened() {
    let points: Vec<Vec3> = (0..70_001).map(|i| Vec3::X * i as f32).collect();
    let problem =
        refused(Collider::polyline(points, None), ClothCollider { thickness: 0.1, ..default() });
    let expected = EngineProblem::TooMany { shape: "polyline", count: 70_000, most: 65_536 };
    assert_eq!(problem, expected);
}

#[test]
fn numbers_that_are_none_are_refused() {
    let parameter = |problem: &EngineProblem| matches!(problem, EngineProblem::Shape(_));
    for radius in [f32::NAN, -1.0, 0.0, f32::INFINITY] {
        let problem = refused(SharedShape::ball(radius).into(), ClothCollider::default());
        assert!(parameter(&problem), "{radius}: {problem}");
    }
    let nan = Vec3::splat(f32::NAN);
    let plane = SharedShape::halfspace(nan).into();
    assert!(parameter(&refused(plane, ClothCollider::default())));
    let problem = refused(
        SharedShape::triangle(nan, Vec3::X, Vec3::Y).into(),
        ClothCollider { thickness: 0.1, ..default() },
    );
    let is_of_triangles = matches!(problem, EngineProblem::Shell { shape: "triangle", .. });
    assert!(is_of_triangles, "{problem}");
    let heights = vec![0.0, f32::NAN, 0.0, 0.0];
    let problem =
        refused(Collider::heightfield(heights, 2, 2, Vec3::ONE), ClothCollider::default());
    let is_height = matches!(
        problem,
        EngineProblem::HeightField(HeightFieldError::Height { height, .. }) if height.is_nan()
    );
    assert!(is_height, "{problem}");
}

#[test]
fn numbers_of_the_marker_are_checked() {
    for thickness in [f32::NAN, -1.0, f32::INFINITY] {
        let wish = ClothCollider { thickness, ..default() };
        let problem = refused(Collider::ball(0.3), wish);
        assert!(matches!(problem, EngineProblem::Parameter(_)), "{problem}");
    }
    let wish = ClothCollider { friction: Some(f32::NAN), ..default() };
    let problem = refused(Collider::ball(0.3), wish);
    assert!(problem.to_string().contains("friction"), "{problem}");
}

#[test]
fn a_pose_that_is_none_leaves_the_others_alone() {
    let mut app = physics_app();
    let ball =
        spawn(&mut app, (Collider::ball(0.2), Transform::default(), ClothCollider::default()));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.3, 0.0)));
    let lost =
        spawn(&mut app, (Collider::ball(0.2), Transform::default(), ClothCollider::default()));
    app.update();
    transform(&mut app, lost).translation.x = f32::NAN;
    updates(&mut app, 30);
    let told = failure(&app, lost).expect("it is told");
    assert!(matches!(told.kind, ClothErrorKind::Scale(_)), "{told}");
    assert_eq!((failure(&app, ball), failure(&app, cloth)), (None, None));
    assert!(positions(&app, cloth).iter().all(|p| p.length() > 0.2));
}
