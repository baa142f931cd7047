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
    /// Passes of Provot's correction in a substep. More hold the strain limit closer.
    pub provot_passes: u32,
    /// Whether masses and springs of the border count half. Changing it keeps the cloth where it
    /// is.
    pub masses: MassLumping,
    /// Bending model.
    pub bending: Bending,
    /// How the motion is integrated. All but Verlet are there to be compared with it: they are not stable.
    pub integrator: Integrator,
    /// Whether no particle gets further from the pins than the cloth between them allows.
    pub tethers: bool,
    /// Speed that no particle exceeds [m/s]. Higher than any real motion of the scene, and no
    /// higher.
    pub max_speed: f32,
    /// Speed at which particles that are inside a collider are pushed out [m/s]. Higher frees a cloth
    /// sooner that was spawned inside one.
    pub max_depenetration_speed: f32,
    /// The layers of colliders that it meets: those of which
    /// [`SdfCollider::layers`](crate::SdfCollider::layers) shares one.
    pub layers: ClothLayers,
    /// Whether its edges are held out of colliders that are thin or sharp beside the distance of its particles, and not
    /// these alone. Takes no time elsewhere.
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

/// What is drawn of a cloth between two ticks.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub enum ClothInterpolation {
    /// A blend of the last two ticks: smooth at any frame rate, up to a tick late. A blended
    /// particle may dip into a collider between the two.
    ///
    /// Either way, a cloth that is pinned is drawn as much further as what leads it has moved since.
    #[default]
    Blend,
    /// The last tick as it is: never inside a collider, but it stutters unless frames and ticks go
    /// together.
    LastTick,
}
