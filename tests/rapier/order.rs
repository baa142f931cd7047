//! What runs after what.

use crate::falls::physics;
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_rapier3d::prelude::*;

/// Pairs of systems whose order is left to chance.
fn ambiguities(app: &mut App) -> usize {
    updates(app, 2);
    let schedules = app.world().resource::<Schedules>();
    schedules.get(FixedUpdate).map_or(0, |it| it.graph().conflicting_systems().len())
}

#[test]
fn no_order_is_left_to_chance_in_one_schedule() {
    let mut alone = app_with(physics());
    let mut both = app_with((RapierClothPlugin::all(), ClothPlugin::new(FixedUpdate), physics()));
    assert_eq!(ambiguities(&mut both), ambiguities(&mut alone));
}

#[test]
fn a_tick_sees_the_pose_of_the_tick() {
    for schedule in [ClothPlugin::new(FixedUpdate), ClothPlugin::default()] {
        let mut app = app_with((schedule, RapierClothPlugin::default(), physics()));
        let ground = spawn(
            &mut app,
            (
                RigidBody::KinematicVelocityBased,
                Collider::halfspace(Vec3::Y).unwrap(),
                ClothCollider::default(),
                Transform::from_xyz(0.0, -0.05, 0.0),
                Velocity::default(),
            ),
        );
        let cloth = spawn(&mut app, (sheet(), ClothMaterial { thickness: 0.0, ..default() }));
        app.update();
        // In one tick the ground comes up from below the cloth to above it.
        app.world_mut().get_mut::<Velocity>(ground).unwrap().linear = Vec3::Y * 20.0;
        app.update();
        let height = app.world().get::<Transform>(ground).unwrap().translation.y;
        assert!(height > 0.2);
        for position in positions(&app, cloth) {
            assert!(position.y >= height - 1e-4, "{position} is below {height}");
        }
    }
}
