//! Cloths that fall onto colliders.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothCollider, RapierClothPlugin, prelude::*};
use bevy_rapier3d::prelude::*;

/// The engine, stepped in each tick.
pub fn physics() -> RapierPhysicsPlugin<NoUserData> {
    RapierPhysicsPlugin::default().in_fixed_schedule()
}

pub fn physics_app() -> App {
    app_with((physics(), ClothPlugin::default(), RapierClothPlugin::default()))
}

#[test]
fn a_cloth_rests_on_a_ball_of_either_schedule() {
    let by_frame = RapierPhysicsPlugin::<NoUserData>::default();
    let by_frame = app_with((by_frame, ClothPlugin::default(), RapierClothPlugin::default()));
    for mut app in [physics_app(), by_frame] {
        spawn(&mut app, (Collider::ball(0.3), Transform::default(), ClothCollider::default()));
        let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.4, 0.0)));
        updates(&mut app, 64);
        let least = positions(&app, cloth).iter().map(|p| p.length()).fold(f32::MAX, f32::min);
        assert!((0.2999..0.33).contains(&least), "{least}");
    }
}

#[test]
fn a_falling_ball_is_fallen_onto() {
    let by_frame = RapierPhysicsPlugin::<NoUserData>::default();
    let by_frame = app_with((by_frame, ClothPlugin::default(), RapierClothPlugin::default()));
    for mut app in [physics_app(), by_frame] {
        spawn(&mut app, (Collider::cuboid(5.0, 0.5, 5.0), Transform::from_xyz(0.0, -1.5, 0.0)));
        let ball = spawn(
            &mut app,
            (
                RigidBody::Dynamic,
                Collider::ball(0.3),
                ClothCollider::default(),
                Transform::from_xyz(0.0, 0.2, 0.0),
            ),
        );
        let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.6, 0.0)));
        for _ in 0..128 {
            app.update();
            // The cloth is where the ball was in the tick, or will be drawn.
            let centre = app.world().get::<Transform>(ball).unwrap().translation;
            let least =
                positions(&app, cloth).iter().map(|p| p.distance(centre)).fold(f32::MAX, f32::min);
            assert!(least > 0.2, "{least}");
        }
        let centre = app.world().get::<Transform>(ball).unwrap().translation;
        assert!((centre.y + 0.7).abs() < 0.02, "the ball lies on the ground, at {centre}");
        let least =
            positions(&app, cloth).iter().map(|p| p.distance(centre)).fold(f32::MAX, f32::min);
        assert!((0.2999..0.33).contains(&least), "{least}");
    }
}
