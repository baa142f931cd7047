//! How a cloth is solved and drawn.

use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::solver::{Bending, Integrator, MassLumping, Settings, StretchMethod, Substeps};

/// How a cloth is solved. May be changed at any time; the defaults suit nearly every scene.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothSettings {
    /// Substeps in a tick. More are more accurate, carry stiffer springs, and cost in proportion.
    pub substeps: Substeps,
    /// Springs, whole threads, or whichever carries the material.
    pub stretch_method: StretchMethod,
    /// Passes of Provot's correction in a substep. More hold the strain limit closer. Where threads are solved, up to twenty
    /// times as many end a tick in which springs are still beyond it, unless the cloth lies on a collider and is not worn.
    pub provot_passes: u32,
    /// Whether masses and springs of the border count half. Changing it keeps the cloth where it
    /// is.
    pub masses: MassLumping,
    /// Bending model.
    pub bending: Bending,
    /// How the motion is integrated. All but Verlet are there to be compared with it: they are not stable.
    pub integrator: Integrator,
    /// Whether tethers (long-range attachments) keep particles within reach of the pins.
    pub tethers: bool,
    /// Speed that no particle exceeds [m/s]. Set it just above the fastest real motion in the scene.
    pub max_speed: f32,
    /// Speed at which particles that are inside a collider are pushed out [m/s]. Higher frees a cloth
    /// sooner that was spawned inside one.
    pub max_depenetration_speed: f32,
    /// The layers of colliders that it meets: those of which
    /// [`SdfCollider::layers`](crate::SdfCollider::layers) shares one.
    pub layers: ClothLayers,
    /// Whether edges and faces, not only particles, collide with solids that are thin or sharp relative to the particle
    /// spacing. Free elsewhere.
    pub edges: bool,
}

impl ClothSettings {
    /// The default: up to 20 substeps in 1/60 s, by whichever method carries the material.
    pub const USUAL: Self = Self::from_solver(Settings::USUAL);

    const fn from_solver(settings: Settings) -> Self {
        Self {
            substeps: settings.substeps,
            stretch_method: settings.stretch_method,
            provot_passes: settings.provot_passes,
            masses: settings.lumping,
            bending: settings.bending,
            integrator: settings.integrator,
            tethers: settings.tethers,
            max_speed: settings.max_speed,
            max_depenetration_speed: settings.max_depenetration_speed,
            layers: ClothLayers(settings.layers),
            edges: settings.edges,
        }
    }
}

impl Default for ClothSettings {
    fn default() -> Self {
        Self::USUAL
    }
}

impl From<Settings> for ClothSettings {
    fn from(settings: Settings) -> Self {
        Self::from_solver(settings)
    }
}

impl From<ClothSettings> for Settings {
    fn from(settings: ClothSettings) -> Self {
        Self {
            substeps: settings.substeps,
            stretch_method: settings.stretch_method,
            provot_passes: settings.provot_passes,
            lumping: settings.masses,
            bending: settings.bending,
            integrator: settings.integrator,
            tethers: settings.tethers,
            max_speed: settings.max_speed,
            max_depenetration_speed: settings.max_depenetration_speed,
            layers: settings.layers.0,
            edges: settings.edges,
        }
    }
}

/// How a cloth is drawn between two ticks.
///
/// In both modes, a hard-pinned cloth is drawn shifted and turned rigidly by the motion of its leading anchor since the
/// drawn instant.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub enum ClothInterpolation {
    /// A blend of the last two ticks: smooth at any frame rate, up to a tick late. A blended
    /// particle may dip into a collider between the two.
    #[default]
    Blend,
    /// The last tick as it is: it stutters unless frames and ticks go together. It dips into no collider between two
    /// ticks, unless the collider or the leading anchor has moved since the last one.
    LastTick,
}
