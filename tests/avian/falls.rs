//! Cloths that fall onto colliders.

use crate::support::app::*;
use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_drape::{AvianClothPlugin, ClothCollider, prelude::*};

pub fn physics_app() -> App {
    app_with((PhysicsPlugins::default(), ClothPlugin::default(), AvianClothPlugin::default()))
}

#[test]
fn a_cloth_rests_on_a_ball() {
    let mut app = physics_app();
    spawn(&mut app, (Collider::sphere(0.3), RigidBody::Static, ClothCollider::default()));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.4, 0.0)));
    updates(&mut app, 64);
    let least = positions(&app, cloth).iter().map(|p| p.length()).fold(f32::MAX, f32::min);
    assert!((0.2999..0.33).contains(&least), "{least}");
    let lowest = positions(&app, cloth).iter().map(|p| p.y).fold(f32::MAX, f32::min);
    assert!((-1.0..0.1).contains(&lowest), "{lowest}");
}

#[test]
fn a_falling_ball_is_fallen_onto() {
    let mut app = physics_app();
    spawn(
        &mut app,
        (RigidBody::Static, Collider::cuboid(10.0, 1.0, 10.0), Transform::from_xyz(0.0, -1.5, 0.0)),
    );
    let ball = spawn(
        &mut app,
        (
            RigidBody::Dynamic,
            Collider::sphere(0.3),
            ClothCollider::default(),
            Transform::from_xyz(0.0, 0.2, 0.0),
        ),
    );
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.6, 0.0)));
    for _ in 0..128 {
        app.update();
        let centre = app.world().get::<Position>(ball).unwrap().0;
        let least =
            positions(&app, cloth).iter().map(|p| p.distance(centre)).fold(f32::MAX, f32::min);
        // Avian learns at its next step where the cloth has moved the ball.
        assert!(least > 0.297, "{least}");
    }
    let centre = app.world().get::<Position>(ball).unwrap().0;
    assert!((centre.y + 0.7).abs() < 0.02, "the ball lies on the ground, at {centre}");
    let least = positions(&app, cloth).iter().map(|p| p.distance(centre)).fold(f32::MAX, f32::min);
    assert!(least < 0.33, "{least}");
}
