//! What runs after what.

use crate::support::app::*;
use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_drape::{AvianClothPlugin, ClothCollider, prelude::*};

/// Pairs of systems whose order is left to chance.
fn ambiguities(app: &mut App) -> usize {
    updates(app, 2);
    let schedules = app.world().resource::<Schedules>();
    schedules.get(FixedPostUpdate).map_or(0, |it| it.graph().conflicting_systems().len())
}

#[test]
fn no_order_is_left_to_chance() {
    let mut alone = app_with(PhysicsPlugins::default());
    let mut both =
        app_with((AvianClothPlugin::all(), ClothPlugin::default(), PhysicsPlugins::default()));
    let cloth = spawn(&mut both, sheet());
    // Avian has one of its own.
    assert_eq!(ambiguities(&mut both), ambiguities(&mut alone));
    assert_eq!(simulation(&both, cloth).tick_count(), 2);
}

#[test]
fn a_tick_sees_the_pose_of_the_tick() {
    let mut app =
        app_with((ClothPlugin::default(), AvianClothPlugin::default(), PhysicsPlugins::default()));
    let ground = spawn(
        &mut app,
        (
            RigidBody::Kinematic,
            Collider::half_space(Vec3::Y),
            ClothCollider::default(),
            Transform::from_xyz(0.0, -0.05, 0.0),
        ),
    );
    let cloth = spawn(&mut app, (sheet(), ClothMaterial { thickness: 0.0, ..default() }));
    app.update();
    // In one tick the ground comes up from below the cloth to above it.
    app.world_mut().entity_mut(ground).insert(LinearVelocity(Vec3::Y * 20.0));
    app.update();
    let height = app.world().get::<Position>(ground).unwrap().y;
    assert!(height > 0.2);
    for position in positions(&app, cloth) {
        assert!(position.y >= height - 1e-4, "{position} is below {height}");
    }
}
