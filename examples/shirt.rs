//! An open shirt on a tailor's dummy, in the wind: an irregular mesh with seams, holes and a slit, held by nothing but the arms that
//! it hangs on.
//!
//! `cargo run --example shirt --features demo`

use bevy::prelude::*;
use bevy_drape::{ClothInterpolation, prelude::*, solver::Gusts};
use examples_common::{
    BRASS, Example, IVORY, Particles, TEAL, View, clay, ground, linen, metal, shirt,
};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const SHIRT: Example = Example {
    name: "shirt",
    about: "An open shirt on a tailor's dummy, in the wind: a mesh with seams and holes",
    scene,
    view: View { from: Vec3::new(0.9, 1.5, 2.1), at: Vec3::new(0.0, 1.1, 0.0) },
    bounds: [[-0.9, 0.3, -0.9], [0.9, 1.7, 0.9]],
};

fn main() -> AppExit {
    SHIRT.show()
}

fn scene(app: &mut App) {
    let gusts = Gusts { strength: 1.5, scale: 0.6, period: 0.7, ..default() };
    app.insert_resource(ClothWind::steady(Vec3::new(0.4, 0.0, -0.8)).with_gusts(gusts))
        .add_systems(Startup, spawn);
}

/// Height of the dummy's neck \[m\].
const NECK: f32 = 1.45;

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let upright = Quat::IDENTITY;
    let across = Quat::from_rotation_z(FRAC_PI_2);
    // Torso, shoulders and arms, neck: radius, length, height, and how it is turned.
    for (radius, length, down, turned) in
        [(0.12, 0.32, 0.38, upright), (0.065, 0.95, 0.13, across), (0.05, 0.16, -0.02, upright)]
    {
        let part = Capsule3d::new(radius, length);
        commands.spawn((
            SdfCollider::from(part),
            Mesh3d(meshes.add(part)),
            Transform::from_xyz(0.0, NECK - down, 0.0).with_rotation(turned),
            clay(IVORY),
        ));
    }
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.015, 0.9))),
        Transform::from_xyz(0.0, 0.45, 0.0),
        metal(BRASS),
    ));
    commands.spawn((
        Cloth::of_mesh3d(),
        Mesh3d(meshes.add(shirt(particles.0))),
        ClothMaterial { thickness: 0.006, ..ClothMaterial::COTTON },
        ClothAir::default(),
        ClothInterpolation::LastTick,
        Transform::from_xyz(0.0, NECK, 0.0),
        linen(TEAL),
    ));
}
