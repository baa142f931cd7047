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
