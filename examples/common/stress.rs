//! A hundred thousand particles in many cloths.

use super::scene::{CORAL, INDIGO, IVORY, TEAL, clay, spawn_sheet, spawn_solid};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// Particles of all cloths together, at least.
const PARTICLES: u32 = 100_000;
/// Distance from cloth to cloth, side of a cloth, radius of a ball \[m\].
const SPACING: f32 = 0.62;
const SIDE: f32 = 0.5;
const RADIUS: f32 = 0.13;

/// Adds as many balls and cloths as it takes, in a square; a cloth has half as many particles a side as other
/// scenes' cloths.
pub fn add_stress(world: &mut World, particles: u32) {
    let side = (particles / 2).max(2);
    let rows = (PARTICLES as f32 / (side * side) as f32).sqrt().ceil() as u32;
    for number in 0..rows * rows {
        let (column, row) = (number % rows, number / rows);
        let along = |i: u32| SPACING * (i as f32 - 0.5 * (rows - 1) as f32);
        let place = Vec3::new(along(column), 0.0, along(row));
        let ball = Sphere::new(RADIUS);
        let mesh = ball.mesh().uv(32, 16);
        spawn_solid(world, mesh, place + Vec3::Y * RADIUS, clay(IVORY), ball);
        // Not all at once.
        let height = 2.0 * RADIUS + 0.05 + 0.04 * (number * 7 % 11) as f32;
        let color = [CORAL, TEAL, INDIGO][(number % 3) as usize];
        spawn_sheet(world, side, SIDE, place + Vec3::Y * height, color, ClothMaterial::default());
    }
}
