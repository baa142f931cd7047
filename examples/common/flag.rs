//! A flag in a gusty wind.

use super::scene::{BRASS, CORAL, linen, metal, spawn_thing};
use bevy::prelude::*;
use bevy_drape::{
    prelude::*,
    solver::{Gusts, Substeps},
};

/// Adds the mast, the flag and the wind.
pub fn add_flag(world: &mut World, particles: u32) {
    // Gusts about as large as the flag throw it into folds.
    let gusts = Gusts { strength: 7.0, scale: 1.2, period: 0.5, ..default() };
    world.insert_resource(ClothWind::steady(Vec3::new(6.0, 0.0, 0.6)).with_gusts(gusts));

    let (length, height, top) = (1.5, 1.0, 2.25);
    let mast = Cylinder::new(0.018, top + 0.05);
    let luff = -0.5 * length - mast.radius;
    spawn_thing(world, mast.mesh(), Vec3::new(luff, mast.half_height, 0.0), metal(BRASS));
    let knob = Vec3::new(luff, 2.0 * mast.half_height, 0.0);
    spawn_thing(world, Sphere::new(0.035).mesh(), knob, metal(BRASS));
    world.spawn((
        Cloth::sheet(Vec2::new(length, height), UVec2::new(particles, (2 * particles / 3).max(2))),
        ClothPins::from(PinSelection::FirstColumn),
        // Thin polyester, that feels the air.
        ClothMaterial { area_density: 0.15, ..default() },
        ClothAir::default(),
        // It cracks like a whip at its end: twice the usual substeps hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 40 }, ..default() },
        // Its first column along the mast.
        Transform::from_xyz(0.0, top - 0.5 * height, 0.0)
            .with_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
        linen(CORAL),
    ));
}
