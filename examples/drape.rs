//! The main job: one cloth comes down on three spheres, another on a mesh, the Stanford bunny, whose
//! distance field is baked at the start.
//!
//! `cargo run --example drape --features demo`

use bevy::prelude::*;
use bevy_drape::prelude::*;
use examples_common::{
    CORAL, Example, IVORY, Particles, TEAL, View, clay, ground, linen, load_bunny,
};

/// What is told of the example, and where its cloths are at the end.
pub const DRAPE: Example = Example {
    name: "drape",
    about: "A cloth comes down on three spheres, and beside it one on the Stanford bunny",
    scene,
    view: View { from: Vec3::new(0.0, 1.75, 4.6), at: Vec3::new(0.0, 0.5, 0.0) },
    bounds: [[-2.6, 0.0, -1.4], [2.6, 1.6, 1.4]],
};

fn main() -> AppExit {
    DRAPE.show()
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    spawn_spheres(&mut commands, &mut meshes, particles.0, Vec3::new(-1.1, 0.0, 0.0));
    spawn_covered_bunny(&mut commands, &mut meshes, particles.0, Vec3::new(1.1, 0.0, 0.0));
}

/// Three spheres on the ground, and a cloth above.
fn spawn_spheres(commands: &mut Commands, meshes: &mut Assets<Mesh>, particles: u32, center: Vec3) {
    for (x, z, radius) in [(-0.38, -0.20, 0.45), (0.46, -0.12, 0.33), (0.06, 0.46, 0.24)] {
        let sphere = Sphere::new(radius);
        commands.spawn((
            SdfCollider::from(sphere),
            Mesh3d(meshes.add(sphere.mesh().uv(96, 48))),
            Transform::from_translation(center + Vec3::new(x, radius, z)),
            clay(IVORY),
        ));
    }
    // A sheet lies flat.
    commands.spawn((
        Cloth::sheet(Vec2::splat(2.0), UVec2::splat(particles)),
        Transform::from_translation(center + 1.1 * Vec3::Y),
        linen(CORAL),
    ));
}

/// The bunny, and a cloth above.
fn spawn_covered_bunny(
    commands: &mut Commands,
    meshes: &mut Assets<Mesh>,
    particles: u32,
    center: Vec3,
) {
    // One more component makes a collider of a closed mesh, as soon as its field is baked in the background.
    commands.spawn((
        BakeSdf::with_cells(96),
        Mesh3d(meshes.add(load_bunny())),
        Transform::from_translation(center).with_scale(Vec3::splat(1.3)),
        clay(IVORY),
    ));
    commands.spawn((
        Cloth::sheet(Vec2::splat(2.0), UVec2::splat(particles)),
        // The ears are hardly thicker than the spacing of the particles: the cloth keeps off a little.
        ClothMaterial { thickness: 0.02, ..default() },
        Transform::from_translation(center + 1.32 * Vec3::Y),
        linen(TEAL),
    ));
}

/// The spheres and their cloth alone, without a bake: for `headless` and the tests.
pub const SPHERES: Example = Example {
    name: "spheres",
    about: "Only the spheres and their cloth",
    scene: |app| {
        app.add_systems(Startup, spawn_only_spheres);
    },
    bounds: [[-1.4, 0.0, -1.4], [1.4, 1.6, 1.4]],
    ..DRAPE
};

fn spawn_only_spheres(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    particles: Res<Particles>,
) {
    commands.spawn(ground(&mut meshes));
    spawn_spheres(&mut commands, &mut meshes, particles.0, Vec3::ZERO);
}
