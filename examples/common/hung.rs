//! A curtain that starts hung, beside one that starts flat.

use super::{
    scene::{BRASS, INDIGO, TEAL, linen, metal, spawn_thing},
    slide::Slide,
};
use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Substeps};

const ROD_HEIGHT: f32 = 2.3;
/// Side of both cloths \[m\].
const SIDE: f32 = 1.6;
/// Distance of a ring from the middle of its curtain \[m\], where that hangs.
const HALF_SPAN: f32 = 0.68;

/// Adds both curtains; the one that starts hung is the first.
pub fn add_hung(world: &mut World, particles: u32) {
    add_curtain(world, particles, -1.0, TEAL, HALF_SPAN).insert(HangOnStart::default());
    add_curtain(world, particles, 1.0, INDIGO, 0.5 * SIDE);
}

/// A curtain whose rings slide from `half_span` to where it hangs.
fn add_curtain(
    world: &mut World,
    particles: u32,
    middle: f32,
    color: Srgba,
    half_span: f32,
) -> EntityWorldMut<'_> {
    let mut ring = |side: f32| {
        let place = |half: f32| Vec3::new(middle + side * half, ROD_HEIGHT, 0.0);
        let ring = spawn_thing(world, Sphere::new(0.03).mesh(), place(half_span), metal(BRASS));
        let slide = Slide { from: place(half_span), to: place(HALF_SPAN), seconds: 1.0 };
        world.entity_mut(ring).insert(slide).id()
    };
    let (left, right) = (ring(-1.0), ring(1.0));
    world.spawn((
        Cloth::sheet(Vec2::splat(SIDE), UVec2::splat(particles)),
        // All of its weight pulls at two threads: more substeps than usual hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 30 }, ..default() },
        ClothPins::vertices([0])
            .anchored_to(left)
            .and(ClothPins::vertices([particles - 1]).anchored_to(right)),
        Transform::from_xyz(middle, ROD_HEIGHT, 0.5 * SIDE),
        linen(color),
    ))
}
