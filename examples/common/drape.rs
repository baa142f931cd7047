//! Cloths that come down on spheres and on a mesh.

use super::{
    bunny::spawn_bunny,
    scene::{CORAL, IVORY, TEAL, clay, spawn_sheet, spawn_solid},
};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// Three spheres on the ground, and a cloth above.
pub fn add_spheres(world: &mut World, particles: u32, center: Vec3) {
    for (x, z, radius) in [(-0.38, -0.20, 0.45), (0.46, -0.12, 0.33), (0.06, 0.46, 0.24)] {
        let sphere = Sphere::new(radius);
        let mesh = sphere.mesh().uv(96, 48);
        let place = center + Vec3::new(x, radius, z);
        spawn_solid(world, mesh, place, clay(IVORY), sphere);
    }
    let place = center + 1.1 * Vec3::Y;
    spawn_sheet(world, particles, 2.0, place, CORAL, ClothMaterial::default());
}

/// The bunny, to be baked, and a cloth above.
pub fn add_covered_bunny(world: &mut World, particles: u32, center: Vec3) {
    spawn_bunny(world, Transform::from_translation(center));
    // Its ears are hardly thicker than the spacing of the particles: the cloth keeps off a little.
    let material = ClothMaterial { thickness: 0.02, ..default() };
    let place = center + 1.32 * Vec3::Y;
    spawn_sheet(world, particles, 2.0, place, TEAL, material);
}
