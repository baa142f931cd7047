//! Six fabrics side by side, each over the same post.

use super::scene::{BRASS, CORAL, INDIGO, IVORY, TEAL, clay, spawn_sheet, spawn_solid};
use bevy::prelude::*;
use bevy_drape::prelude::*;

/// A colour for each of [`ClothMaterial::FABRICS`].
const COLORS: [Srgba; 6] =
    [CORAL, TEAL, INDIGO, Srgba::rgb(0.16, 0.24, 0.38), BRASS, Srgba::rgb(0.16, 0.16, 0.17)];

/// Radius and height of a post, side of a cloth \[m\].
const POST: (f32, f32) = (0.2, 0.62);
const SIDE: f32 = 0.95;

/// Adds posts and cloths, three in a row.
pub fn add_fabrics(world: &mut World, particles: u32) {
    for (number, (name, fabric)) in ClothMaterial::FABRICS.into_iter().enumerate() {
        let (column, row) = (number % 3, number / 3);
        let place = Vec3::new(1.1 * (column as f32 - 1.0), 0.0, 1.2 * (row as f32 - 0.5));
        let post = Cylinder::new(POST.0, POST.1);
        let middle = place + Vec3::Y * post.half_height;
        // Drawn slightly smaller: its edge is sharper than the cloths are fine, and would show through.
        let drawn = Cylinder::new(POST.0 - 0.004, POST.1 - 0.008).mesh().resolution(96).build();
        spawn_solid(world, drawn, middle, clay(IVORY), post);
        let above = place + Vec3::Y * (POST.1 + 0.08);
        spawn_sheet(world, particles, SIDE, above, COLORS[number], fabric).insert(Name::new(name));
    }
}
