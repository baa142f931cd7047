//! A square sail, held at its corners, that fills in a steady wind.

use super::{
    scene::{BRASS, IVORY, TEAL, clay, linen, metal, spawn_solid, spawn_thing},
    slide::Slide,
};
use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Substeps};

/// Side of the sail, height of its middle \[m\].
const SIDE: f32 = 1.8;
const MIDDLE: f32 = 1.35;

/// Side of the patch at a corner \[m\].
const PATCH: f32 = 0.08;

/// Adds mast, yards, sail and wind.
pub fn add_sail(world: &mut World, particles: u32) {
    world.insert_resource(ClothWind::steady(Vec3::new(0.0, 0.0, 6.0)));
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
    let mut pins = ClothPins::none();
    for (x, y) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let way = slide(x, y);
        let ring = spawn_thing(world, Sphere::new(0.04).mesh(), way.from, metal(BRASS));
        world.entity_mut(ring).insert(way);
        // A patch at the corner, as a sailmaker sews on: one thread could not carry the wind. The sheet
        // lies in its own xz plane, with its first row up.
        let corner = far * Vec3::new(x, 0.0, -y);
        let patch = ClothPins::within(corner - PATCH, corner + PATCH);
        pins = pins.and(patch.anchored_to(ring));
    }
    world.spawn((
        Cloth::sheet(Vec2::splat(SIDE), UVec2::splat(particles)),
        // Canvas.
        ClothMaterial {
            area_density: 0.4,
            thread_stiffness: 20_000.0,
            shear_stiffness: 500.0,
            flexural_rigidity: 1e-4,
            ..default()
        },
        // The wind pulls at four corners alone: twice the usual substeps hold the strain there.
        ClothSettings { substeps: Substeps::Automatic { budget: 40 }, ..default() },
        pins,
        ClothAir::default(),
        Transform::from_xyz(0.0, MIDDLE, 0.0)
            .with_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
        linen(TEAL),
    ));
}
