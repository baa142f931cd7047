//! Lines over the scene, to look inside a cloth: threads coloured by their strain, and pins.

use bevy::{
    color::palettes::css,
    gizmos::{AppGizmoBuilder, GizmoPlugin},
    prelude::*,
};

use crate::cloth::ClothSimulation;

/// Draws [`ClothGizmos`] of all cloths. Nothing is drawn, and nothing costs, without it.
///
/// Lines are where the last tick took the particles: a part of a tick ahead of a mesh whose
/// [`ClothInterpolation`](crate::ClothInterpolation) blends.
///
/// What is drawn is chosen in Bevy's `GizmoConfigStore`:
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothGizmos, ClothGizmosPlugin};
/// fn show_no_threads(mut store: ResMut<GizmoConfigStore>) {
///     store.config_mut::<ClothGizmos>().1.threads = false;
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothGizmosPlugin;

/// What the gizmos show.
#[derive(Clone, Copy, Debug, Reflect, GizmoConfigGroup)]
pub struct ClothGizmos {
    /// Threads: grey at rest, red stretched, blue compressed.
    pub threads: bool,
    /// Held particles.
    pub pins: bool,
    /// Strain that has the full colour \[1\]. Lower shows less strain.
    pub full_strain: f32,
}

impl Default for ClothGizmos {
    fn default() -> Self {
        Self { threads: true, pins: true, full_strain: 0.02 }
    }
}

impl Plugin for ClothGizmosPlugin {
    fn build(&self, app: &mut App) {
        let config = GizmoConfig {
            // Some centimetres in front of the cloth's own mesh a few metres away, which would hide them.
            depth_bias: -0.002,
            line: GizmoLineConfig { width: 1.0, ..default() },
            ..default()
        };
        app.insert_gizmo_config(ClothGizmos::default(), config)
            .add_systems(PostUpdate, draw_gizmos);
    }

    fn finish(&self, app: &mut App) {
        // Bevy's own plugin draws them; the default plugins have it.
        if !app.is_plugin_added::<GizmoPlugin>() {
            tracing::warn!(
                "ClothGizmosPlugin draws nothing without Bevy's GizmoPlugin: add DefaultPlugins"
            );
        }
    }
}

fn draw_gizmos(cloths: Query<&ClothSimulation>, mut gizmos: Gizmos<ClothGizmos>) {
    let ClothGizmos { threads, pins, full_strain } = *gizmos.config_ext;
    for cloth in &cloths {
        if threads {
            draw_threads(cloth, full_strain, &mut gizmos);
        }
        if pins {
            draw_pins(cloth, &mut gizmos);
        }
    }
}

fn draw_threads(cloth: &ClothSimulation, full_strain: f32, gizmos: &mut Gizmos<ClothGizmos>) {
    for (first, second, rest) in cloth.topology().structural_springs() {
        let (a, b) = (cloth.solver.position(first), cloth.solver.position(second));
        let strain = a.distance(b) / rest - 1.0;
        let towards = if strain > 0.0 { css::RED } else { css::BLUE };
        let part = (strain.abs() / full_strain.max(f32::MIN_POSITIVE)).min(1.0);
        gizmos.line(a, b, css::GRAY.mix(&towards, part));
    }
}

fn draw_pins(cloth: &ClothSimulation, gizmos: &mut Gizmos<ClothGizmos>) {
    let (low, high) = cloth.solver.bounds();
    let half_size = 0.01 * low.distance(high);
    for &pin in cloth.pinned() {
        gizmos.cross(cloth.solver.position(pin as usize), half_size, css::YELLOW);
    }
}
