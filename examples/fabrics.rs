//! The six fabrics that have names, each over the same post: at the back silk, cotton and wool, in front
//! denim, canvas and rubber.
//!
//! `cargo run --example fabrics --features demo`

use bevy::prelude::*;
use bevy_drape::prelude::*;
use examples_common::{
    BRASS, CORAL, Example, INDIGO, IVORY, Particles, TEAL, View, clay, ground, linen,
};

/// What is told of the example, and where its cloths are at the end.
pub const FABRICS: Example = Example {
    name: "fabrics",
    about: "Six fabrics, each over the same post",
    scene,
    view: View { from: Vec3::new(0.0, 1.9, 3.5), at: Vec3::new(0.0, 0.3, 0.12) },
    bounds: [[-2.2, 0.0, -1.7], [2.2, 1.0, 1.7]],
};

fn main() -> AppExit {
    FABRICS.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

/// The fabrics, and a color for each.
const CLOTHS: [(&str, ClothMaterial, Srgba); 6] = [
    ("silk", ClothMaterial::SILK, CORAL),
    ("cotton", ClothMaterial::COTTON, TEAL),
    ("wool", ClothMaterial::WOOL, INDIGO),
    ("denim", ClothMaterial::DENIM, Srgba::rgb(0.16, 0.24, 0.38)),
    ("canvas", ClothMaterial::CANVAS, BRASS),
    ("rubber", ClothMaterial::RUBBER, Srgba::rgb(0.16, 0.16, 0.17)),
];

/// Radius and height of a post \[m\].
const RADIUS: f32 = 0.2;
const HEIGHT: f32 = 0.62;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    // Drawn slightly smaller: its edge is sharper than the cloths are fine, and would show through.
    let drawn = Cylinder::new(RADIUS - 0.004, HEIGHT - 0.008).mesh().resolution(96);
    let drawn = meshes.add(drawn);
    for (number, (name, fabric, color)) in CLOTHS.into_iter().enumerate() {
        let (column, row) = (number % 3, number / 3);
        let place = Vec3::new(1.1 * (column as f32 - 1.0), 0.0, 1.2 * (row as f32 - 0.5));
        let post = Cylinder::new(RADIUS, HEIGHT);
        commands.spawn((
            SdfCollider::from(post),
            Mesh3d(drawn.clone()),
            Transform::from_translation(place + Vec3::Y * post.half_height),
            clay(IVORY),
        ));
        commands.spawn((
            Name::new(name),
            Cloth::sheet(Vec2::splat(0.95), UVec2::splat(particles.0)),
            fabric,
            Transform::from_translation(place + Vec3::Y * (HEIGHT + 0.08)),
            linen(color),
        ));
    }
}
