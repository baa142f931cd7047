//! The panel: what a cloth is made of, how it is solved and what blows on it, changed while it moves.
//!
//! `cargo run --example panel --features demo,panel`
//!
//! One more plugin in any game shows it.

use bevy::prelude::*;
use bevy_drape::{prelude::*, solver::Gusts};
use examples_common::{
    BRASS, CORAL, Example, INDIGO, IVORY, Particles, View, clay, ground, linen, metal,
};
use std::f32::consts::FRAC_PI_2;

/// What is told of the example, and where its cloths are at the end.
pub const PANEL: Example = Example {
    name: "panel",
    about: "Cloths to be tuned by the panel",
    scene,
    view: View { from: Vec3::new(0.1, 1.55, 5.7), at: Vec3::new(0.05, 0.85, 0.0) },
    bounds: [[-2.0, 0.0, -1.5], [2.0, 2.0, 2.0]],
};

// `headless` runs the scene without the feature.
#[cfg(feature = "panel")]
fn main() -> AppExit {
    PANEL.show_with(|app| {
        app.add_plugins(bevy_drape::ClothPanelPlugin);
    })
}

fn scene(app: &mut App) {
    let gusts = Gusts { strength: 1.5, ..default() };
    app.insert_resource(ClothWind::steady(Vec3::Z * 2.0).with_gusts(gusts))
        .add_systems(Startup, spawn);
}

fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let ball = Sphere::new(0.35);
    let at = Vec3::new(0.7, 0.35, 1.0);
    commands.spawn((
        SdfCollider::from(ball),
        Mesh3d(meshes.add(ball.mesh().uv(96, 48))),
        Transform::from_translation(at),
        clay(IVORY),
    ));
    commands.spawn((
        // The panel lists cloths by their names.
        Name::new("on the ball"),
        Cloth::sheet(Vec2::splat(1.2), UVec2::splat(particles.0)),
        Transform::from_translation(at + Vec3::Y * 0.5),
        linen(CORAL),
    ));

    let across = Quat::from_rotation_z(FRAC_PI_2);
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.015, 1.2).mesh().build().rotated_by(across))),
        Transform::from_xyz(-0.45, 1.75, 0.0),
        metal(BRASS),
    ));
    commands.spawn((
        Name::new("in the breeze"),
        Cloth::sheet(Vec2::new(1.0, 1.4), UVec2::splat(particles.0)),
        ClothMaterial { drag: 0.5, ..default() },
        ClothPins::from(PinSelection::FirstRow),
        ClothAir::default(),
        Transform::from_xyz(-0.45, 1.05, 0.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        linen(INDIGO),
    ));
}
