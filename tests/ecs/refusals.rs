//! What cannot be used is told to its entity, and the other cloths go on.

use crate::support::app::*;
use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_drape::{
    ClothError, ClothErrorKind, MeshProblem,
    prelude::*,
    sdf::{SdfSample, SignedDistance},
    solver::SolverError,
};

/// The entity's error names it; the other cloth runs and has none.
fn check_told(app: &App, entity: Entity, good: Entity) -> ClothError {
    let error = failure(app, entity).expect("it is refused");
    assert!(error.to_string().contains(&entity.to_string()), "{error}");
    assert_eq!(failure(app, good), None);
    assert!(simulation(app, good).tick_count() > 0);
    error
}

#[test]
fn a_refused_mesh_is_tried_again_when_it_is_replaced() {
    let mut app = app();
    let bad = Mesh3d(add_mesh(&mut app, triangle_mesh(vec![[0.0; 3]; 3], vec![0, 1, 2])));
    let entity = spawn(&mut app, (Cloth::of_mesh3d(), bad));
    updates(&mut app, 2);
    assert!(failure(&app, entity).is_some());
    let good = Mesh3d(add_mesh(&mut app, flat_mesh(3, 4)));
    app.world_mut().entity_mut(entity).insert(good);
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    assert_eq!(simulation(&app, entity).particle_count(), 12);
}

#[test]
fn a_cloth_of_no_mesh_is_told_so_until_it_has_one() {
    let mut app = app();
    let entity = spawn(&mut app, Cloth::of_mesh3d());
    updates(&mut app, 2);
    assert!(matches!(
        failure(&app, entity),
        Some(ClothError { kind: ClothErrorKind::Mesh(MeshProblem::NoMesh), .. })
    ));
    let mesh = Mesh3d(add_mesh(&mut app, flat_mesh(3, 4)));
    app.world_mut().entity_mut(entity).insert(mesh);
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    assert_eq!(simulation(&app, entity).particle_count(), 12);
}

#[test]
fn a_parents_scale_counts() {
    let mut app = app();
    let parent = spawn(&mut app, Transform::from_scale(Vec3::new(1.0, 1.0, 3.0)));
    let entity = spawn(&mut app, (sheet(), ChildOf(parent)));
    let good = spawn(&mut app, sheet());
    updates(&mut app, 3);
    assert!(matches!(
        check_told(&app, entity, good),
        ClothError { kind: ClothErrorKind::Scale(_), .. }
    ));
    transform(&mut app, parent).scale = Vec3::ONE;
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
}

/// A broken solid: beyond x = 50 m its normals are no directions.
#[derive(Debug)]
struct Broken;

impl SignedDistance for Broken {
    fn sample(&self, point: Vec3) -> SdfSample {
        let there = point.x > 50.0;
        SdfSample { distance: if there { -1.0 } else { 1.0 }, normal: Vec3::NAN }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }
}

#[test]
fn a_cloth_that_is_no_longer_finite_is_held_and_the_others_go_on() {
    let mut app = app();
    let entity = spawn(&mut app, (sheet(), Transform::from_xyz(100.0, 0.0, 0.0)));
    let good = spawn(&mut app, sheet());
    updates(&mut app, 10);
    let broken = spawn(&mut app, SdfCollider::custom(Broken));
    updates(&mut app, 3);
    let error = check_told(&app, entity, good);
    assert!(matches!(
        error,
        ClothError { kind: ClothErrorKind::Solver(SolverError::Diverged), .. }
    ));
    assert!(simulation(&app, entity).is_quarantined());
    assert_eq!(simulation(&app, entity).tick_count(), 10);
    assert_eq!(simulation(&app, good).tick_count(), 13);
    assert!(positions(&app, entity).iter().all(|p| p.is_finite()));
    assert!(attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION).iter().all(|p| p.is_finite()));
    // Held until it is told otherwise.
    app.world_mut().despawn(broken);
    let held = bits(&app, entity);
    updates(&mut app, 3);
    assert_eq!(bits(&app, entity), held);
    app.world_mut().get_mut::<ClothMaterial>(entity).unwrap().drag = 0.1;
    updates(&mut app, 3);
    assert_eq!(failure(&app, entity), None);
    assert!(!simulation(&app, entity).is_quarantined());
    assert_ne!(bits(&app, entity), held);
}
