//! A cloth held by two rings that slide together.

use super::{
    scene::{BRASS, INDIGO, linen, metal, spawn_thing},
    slide::Slide,
};
use bevy::prelude::*;
use bevy_drape::prelude::*;

const ROD_HEIGHT: f32 = 2.2;

/// Adds the rings and the cloth.
pub fn add_curtain(world: &mut World, particles: u32) {
    let mut ring = |from: f32, to: f32| {
        let [from, to] = [from, to].map(|x| Vec3::new(x, ROD_HEIGHT, 0.0));
        let ring = spawn_thing(world, Sphere::new(0.03).mesh(), from, metal(BRASS));
        world.entity_mut(ring).insert(Slide { from, to, seconds: 2.0 }).id()
    };
    let (left, right) = (ring(-0.9, -0.62), ring(0.9, 0.62));
    // It starts flat, behind its rings, and swings down.
    let side = Vec2::new(1.8, 1.8);
    world.spawn((
        Cloth::sheet(side, UVec2::splat(particles)),
        ClothMaterial { drag: 1.0, damping: 0.002, ..default() },
        // All of its weight pulls at two threads: more substeps than usual hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 30 }, ..default() },
        ClothPins::vertices([0])
            .anchored_to(left)
            .and(ClothPins::vertices([particles - 1]).anchored_to(right)),
        Transform::from_xyz(0.0, ROD_HEIGHT, 0.5 * side.y),
        linen(INDIGO),
    ));
}
