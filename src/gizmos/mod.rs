//! Lines over the scene, to look inside a cloth: threads coloured by their strain, what holds it, what it
//! touches, where it has passed through itself, what blows on it, and the fields that it meets.

mod contacts;
mod slice;
mod threads;
mod wind;

use bevy::gizmos::{AppGizmoBuilder, GizmoPlugin};
use bevy::prelude::*;

pub use crate::gizmos::slice::SdfSlice;

use crate::schedule::ClothSystems;

/// Draws [`ClothGizmos`] of all cloths, and every [`SdfSlice`]. Nothing is drawn, and nothing costs, without
/// it; and of what is switched off nothing is worked out.
///
/// Lines are where the last tick took the particles: a part of a tick ahead of a mesh whose
/// [`ClothInterpolation`](crate::ClothInterpolation) blends.
///
/// Bevy's `GizmoConfigStore` holds the choice of what is drawn:
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothGizmos, ClothGizmosPlugin};
/// fn show_contacts_alone(mut store: ResMut<GizmoConfigStore>) {
///     let (_, gizmos) = store.config_mut::<ClothGizmos>();
///     *gizmos = ClothGizmos { contacts: true, ..ClothGizmos::NOTHING };
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothGizmosPlugin;

/// The choice of gizmos, each switched on by itself.
#[derive(Clone, Copy, Debug, PartialEq, Reflect, GizmoConfigGroup)]
pub struct ClothGizmos {
    /// Threads: grey at rest, red stretched, blue compressed.
    pub threads: bool,
    /// Held particles: yellow crosses, orange where they are held by springs, with a line to where their
    /// anchor has them; green where they are grabbed.
    pub pins: bool,
    /// Particles that touch a collider, with its normal there.
    pub contacts: bool,
    /// Edges that pierce faces of their own cloth: red. To find them takes milliseconds a cloth.
    pub crossings: bool,
    /// The wind at some particles of each cloth that feels it, and the outlines of its zones.
    pub wind: bool,
    /// The box around each cloth: cyan, grey where it sleeps.
    pub bounds: bool,
    /// Strain that has the full colour \[1\]. Lower shows less strain.
    pub full_strain: f32,
    /// Length of a contact's normal \[m\]. Higher is longer.
    pub normal_length: f32,
    /// Length of an arrow of wind over its speed \[s\]. Higher is longer.
    pub wind_scale: f32,
}

impl ClothGizmos {
    /// All switched off.
    pub const NOTHING: Self = Self {
        threads: false,
        pins: false,
        contacts: false,
        crossings: false,
        wind: false,
        bounds: false,
        full_strain: 0.02,
        normal_length: 0.05,
        wind_scale: 0.03,
    };

    /// All switched on.
    pub const ALL: Self = Self {
        threads: true,
        pins: true,
        contacts: true,
        crossings: true,
        wind: true,
        bounds: true,
        ..Self::NOTHING
    };
}

/// Threads and pins.
impl Default for ClothGizmos {
    fn default() -> Self {
        Self { threads: true, pins: true, ..Self::NOTHING }
    }
}

impl Plugin for ClothGizmosPlugin {
    fn build(&self, app: &mut App) {
        if app.is_plugin_added::<GizmoPlugin>() {
            add_gizmos(app);
        }
    }

    fn finish(&self, app: &mut App) {
        // Bevy's own plugin draws them; the default plugins have it, and may have come later.
        if !app.is_plugin_added::<GizmoPlugin>() {
            tracing::warn!(
                "ClothGizmosPlugin draws nothing without Bevy's GizmoPlugin: add DefaultPlugins"
            );
        } else if !app.world().contains_resource::<Added>() {
            add_gizmos(app);
        }
    }
}

/// The systems are there.
#[derive(Resource)]
struct Added;

fn add_gizmos(app: &mut App) {
    let config = GizmoConfig {
        // Some centimetres in front of the cloth's own mesh a few metres away, which would hide them.
        depth_bias: -0.002,
        line: GizmoLineConfig { width: 1.0, ..default() },
        ..default()
    };
    app.insert_resource(Added).insert_gizmo_config(ClothGizmos::default(), config).add_systems(
        PostUpdate,
        (
            threads::draw_threads.run_if(wanted(|gizmos| gizmos.threads)),
            threads::draw_pins.run_if(wanted(|gizmos| gizmos.pins)),
            threads::draw_bounds.run_if(wanted(|gizmos| gizmos.bounds)),
            contacts::draw_contacts.run_if(wanted(|gizmos| gizmos.contacts)),
            threads::draw_crossings.run_if(wanted(|gizmos| gizmos.crossings)),
            wind::draw_wind.run_if(wanted(|gizmos| gizmos.wind)),
            slice::draw_slices.run_if(any_with_component::<SdfSlice>.and_then(wanted(|_| true))),
        )
            .after(ClothSystems::WriteMeshes),
    );
}

/// Whether the gizmos are drawn at all, and this of them.
fn wanted(which: fn(&ClothGizmos) -> bool) -> impl Fn(Res<GizmoConfigStore>) -> bool {
    move |store| {
        let (config, gizmos) = store.config::<ClothGizmos>();
        config.enabled && which(gizmos)
    }
}
