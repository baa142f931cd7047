//! Cloths that fall onto colliders.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothCollider, RapierClothPlugin, prelude::*};
use bevy_rapier3d::prelude::*;

pub fn physics_app() -> App {
    let physics = RapierPhysicsPlugin::<NoUserData>::default();
    app_with((physics, ClothPlugin::default(), RapierClothPlugin::default()))
}

#[test]
fn a_cloth_rests_on_a_ball() {
    let mut app = physics_app();
    spawn(&mut app, (Collider::ball(0.3), Transform::default(), ClothCollider::default()));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.4, 0.0)));
    updates(&mut app, 64);
    let least = positions(&app, cloth).iter().map(|p| p.length()).fold(f32::MAX, f32::min);
    assert!((0.2999..0.33).contains(&least), "{least}");
}
