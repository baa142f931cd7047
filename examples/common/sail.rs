//! A square sail, held at its corners, that fills in a steady wind.

use super::{
    scene::{BRASS, IVORY, TEAL, clay, linen, metal, spawn_solid, spawn_thing},
    slide::Slide,
};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// Side of the sail, height of its middle \[m\].
const SIDE: f32 = 1.8;
const MIDDLE: f32 = 1.35;

/// Adds mast, yards, sail and wind.
pub fn add_sail(world: &mut World, particles: u32) {
    world.insert_resource(ClothWind::steady(Vec3::new(0.0, 0.0, 8.0)));
    let mast = Cylinder::new(0.035, 2.5);
    let behind = Vec3::new(0.0, mast.half_height, -0.08);
    spawn_solid(world, mast.mesh().build(), behind, clay(IVORY), mast);

    // The corners come together, so that the wind has cloth to fill.
    let (far, near) = (0.5 * SIDE, 0.42 * SIDE);
    let slide = |x: f32, y: f32| {
        let [from, to] = [far, near].map(|by| Vec3::new(x * by, MIDDLE + y * by, 0.0));
        Slide { from, to, seconds: 1.5 }
    };
    for y in [1.0, -1.0] {
        let way = slide(0.0, y);
        let yard = Cylinder::new(0.025, 1.1 * SIDE).mesh().build();
        let yard = yard.rotated_by(Quat::from_rotation_z(90.0_f32.to_radians()));
        let yard = spawn_thing(world, yard, way.from, clay(IVORY));
        world.entity_mut(yard).insert(way);
    }
    let last = particles - 1;
    let mut pins = ClothPins::none();
    for (x, y, vertex) in [
        (-1.0, 1.0, 0),
        (1.0, 1.0, last),
        (-1.0, -1.0, last * particles),
        (1.0, -1.0, last * particles + last),
    ] {
        let way = slide(x, y);
        let ring = spawn_thing(world, Sphere::new(0.04).mesh(), way.from, metal(BRASS));
        world.entity_mut(ring).insert(way);
        pins = pins.and(ClothPins::vertices([vertex]).anchored_to(ring));
    }
    world.spawn((
        Cloth::sheet(Vec2::splat(SIDE), UVec2::splat(particles)),
        // Canvas.
        ClothMaterial { area_density: 0.4, flexural_rigidity: 1e-4, ..default() },
        pins,
        ClothAir::default(),
        Transform::from_xyz(0.0, MIDDLE, 0.0)
            .with_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
        linen(TEAL),
    ));
}
