//! A hundred thousand particles in many cloths, with what they cost on screen.
//!
//! `cargo run --release --example stress --features demo,gizmos`
//!
//! The numbers are those of `ClothDiagnosticsPlugin`, read from Bevy's `DiagnosticsStore`.

use bevy::{
    diagnostic::{Diagnostic, DiagnosticsStore},
    prelude::*,
};
use bevy_drape::{ClothDiagnosticsPlugin, prelude::*};
use examples_common::{
    CORAL, Caption, Example, INDIGO, IVORY, Particles, TEAL, View, clay, ground, linen,
};

/// What is told of the example, and where its cloths are at the end.
pub const STRESS: Example = Example {
    name: "stress",
    about: "A hundred thousand particles in many cloths",
    scene,
    view: View { from: Vec3::new(0.0, 4.4, 7.4), at: Vec3::new(0.0, 0.2, 0.3) },
    bounds: [[-4.5, 0.0, -4.5], [4.5, 1.0, 4.5]],
};

fn main() -> AppExit {
    STRESS.show_with(|app| {
        app.add_plugins(ClothDiagnosticsPlugin).add_systems(Update, write_costs);
    })
}

fn scene(app: &mut App) {
    app.add_systems(Startup, spawn);
}

/// Particles of all cloths together, at least.
const PARTICLES: u32 = 100_000;
/// Distance from cloth to cloth, side of a cloth, radius of a ball \[m\].
const SPACING: f32 = 0.62;
const SIDE: f32 = 0.5;
const RADIUS: f32 = 0.13;

/// Spawns as many balls and cloths as it takes, in a square; a cloth has half as many particles a side as in
/// other examples.
fn spawn(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, particles: Res<Particles>) {
    commands.spawn(ground(&mut meshes));
    let side = (particles.0 / 2).max(2);
    let rows = (PARTICLES as f32 / (side * side) as f32).sqrt().ceil() as u32;
    let ball = Sphere::new(RADIUS);
    let mesh = meshes.add(ball.mesh().uv(32, 16));
    for number in 0..rows * rows {
        let (column, row) = (number % rows, number / rows);
        let along = |i: u32| SPACING * (i as f32 - 0.5 * (rows - 1) as f32);
        let place = Vec3::new(along(column), 0.0, along(row));
        commands.spawn((
            SdfCollider::from(ball),
            Mesh3d(mesh.clone()),
            Transform::from_translation(place + Vec3::Y * RADIUS),
            clay(IVORY),
        ));
        // Not all at once.
        let height = 2.0 * RADIUS + 0.05 + 0.04 * (number * 7 % 11) as f32;
        commands.spawn((
            Cloth::sheet(Vec2::splat(SIDE), UVec2::splat(side)),
            Transform::from_translation(place + Vec3::Y * height),
            linen([CORAL, TEAL, INDIGO][(number % 3) as usize]),
        ));
    }
}

/// Writes what the cloths cost.
fn write_costs(
    store: Res<DiagnosticsStore>,
    cloths: Query<&ClothSimulation>,
    mut caption: ResMut<Caption>,
) {
    let particles: usize = cloths.iter().map(ClothSimulation::particle_count).sum();
    let value = |path| store.get(&path).and_then(Diagnostic::smoothed).unwrap_or_default();
    caption.0 = vec![
        format!("{particles} particles in {} cloths", cloths.iter().len()),
        format!("tick      {:6.2} ms", value(ClothDiagnosticsPlugin::TICK)),
        format!("  solve   {:6.2} ms", value(ClothDiagnosticsPlugin::SOLVE)),
        format!("draw      {:6.2} ms", value(ClothDiagnosticsPlugin::DRAW)),
        format!("substeps  {:6.0}", value(ClothDiagnosticsPlugin::SUBSTEPS)),
        format!("strain    {:6.2} %", 100.0 * value(ClothDiagnosticsPlugin::STRAIN_MAX)),
        format!("contacts  {:6.0}", value(ClothDiagnosticsPlugin::CONTACTS)),
        format!("awake     {:6.0}", value(ClothDiagnosticsPlugin::AWAKE)),
    ];
}
