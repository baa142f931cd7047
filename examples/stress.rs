//! A hundred thousand particles in many cloths, with what they cost on screen.
//!
//! `cargo run --release --example stress --features demo,gizmos`
//!
//! The numbers are those of `ClothDiagnosticsPlugin`, read from Bevy's `DiagnosticsStore`.

mod common;

use bevy::prelude::*;
use bevy::{
    diagnostic::{Diagnostic, DiagnosticsStore},
    gizmos::AppGizmoBuilder,
};
use bevy_drape::{ClothDiagnosticsPlugin, prelude::*};
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A hundred thousand particles in many cloths.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.0, 4.4, 7.4), at: Vec3::new(0.0, 0.2, 0.3) };
    window::run_with(Scene::Stress, &Cli::parse().options, "bevy_drape: stress", view, |app| {
        app.add_plugins(ClothDiagnosticsPlugin)
            .init_gizmo_group::<Screen>()
            .add_systems(Startup, put_in_front)
            .add_systems(PostUpdate, write.after(TransformSystems::Propagate));
    })
}

/// Lines that nothing hides.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Screen;

fn put_in_front(mut store: ResMut<GizmoConfigStore>) {
    store.config_mut::<Screen>().0.depth_bias = -1.0;
}

/// Writes what the cloths cost, a metre in front of the camera.
fn write(
    store: Res<DiagnosticsStore>,
    cloths: Query<&ClothSimulation>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut gizmos: Gizmos<Screen>,
) {
    let particles: usize = cloths.iter().map(ClothSimulation::particle_count).sum();
    let value = |path| store.get(&path).and_then(Diagnostic::smoothed).unwrap_or_default();
    let text = [
        format!("{particles} particles in {} cloths", cloths.iter().len()),
        format!("tick      {:6.2} ms", value(ClothDiagnosticsPlugin::TICK)),
        format!("  solve   {:6.2} ms", value(ClothDiagnosticsPlugin::SOLVE)),
        format!("draw      {:6.2} ms", value(ClothDiagnosticsPlugin::DRAW)),
        format!("substeps  {:6.0}", value(ClothDiagnosticsPlugin::SUBSTEPS)),
        format!("strain    {:6.2} %", 100.0 * value(ClothDiagnosticsPlugin::STRAIN_MAX)),
        format!("contacts  {:6.0}", value(ClothDiagnosticsPlugin::CONTACTS)),
        format!("awake     {:6.0}", value(ClothDiagnosticsPlugin::AWAKE)),
    ];
    for (line, text) in text.iter().enumerate() {
        let place = camera.transform_point(Vec3::new(-0.53, 0.28 - 0.018 * line as f32, -1.0));
        let turned = Isometry3d::new(place, camera.rotation());
        gizmos.text(turned, text, 0.013, Vec2::new(-0.5, 0.5), Color::BLACK);
    }
}
