//! A board of a physics engine with its foot on the ground and its head in an upright cloth, which turns it against its weight.

use bevy::prelude::*;
use bevy_drape::{PinSelection, prelude::*};

use super::{simulation, spawn};

/// The board's size \[m\], mass \[kg\], and coefficient of friction on the ground.
pub const SIZE: Vec3 = Vec3::new(0.2, 0.25, 0.05);
pub const MASS: f32 = 0.5;
pub const FRICTION: f32 = 1.5;

/// Adds the cloth and the board, and returns them. The engine makes a ground whose top is at a height of zero, and a board at a place.
pub fn set_up(
    app: &mut App,
    ground: impl FnOnce(&mut App),
    board: impl FnOnce(&mut App, Transform) -> Entity,
) -> (Entity, Entity) {
    ground(app);
    let upright = Transform::from_xyz(0.0, 0.25, 0.0)
        .with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    let held = ClothPins::from(PinSelection::FirstRow).and(PinSelection::LastRow);
    let cloth = Cloth::sheet(Vec2::new(0.5, 0.47), UVec2::splat(25));
    let cloth = spawn(app, (cloth, held, upright));
    let leaning = Quat::from_rotation_x(-0.75);
    (cloth, board(app, Transform::from_xyz(0.0, 0.12, 0.13).with_rotation(leaning)))
}

/// Runs until both sleep, and looks that the board still leans.
pub fn fall_asleep(
    app: &mut App,
    (cloth, board): (Entity, Entity),
    sleeps: impl Fn(&App, Entity) -> bool,
) {
    let mut ticks = 0;
    while !(sleeps(app, board) && simulation(app, cloth).is_asleep()) {
        app.update();
        ticks += 1;
        assert!(ticks < 20 * 64, "board and cloth do not sleep");
    }
    let at = app.world().get::<Transform>(board).expect("it has a place").translation;
    println!("asleep after {} s at {at}", ticks as f32 / 64.0);
    assert!(at.y > 0.05, "it has fallen over: {at}");
}
