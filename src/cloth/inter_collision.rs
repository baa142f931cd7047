//! Cloths that collide with each other.

use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::solver::InterCollision;

/// Lets a cloth collide with other cloths that have this component and share a layer. Without it cloths pass through each other.
/// May be added, changed and removed at any time.
///
/// Particles are kept from those of the other cloth as balls are, so that the cloths are about as far apart as particles are, or as
/// `distance` says; closer only with finer cloths. A cloth passes through itself all the same, unless it has
/// [`ClothSelfCollision`](crate::ClothSelfCollision).
///
/// Cloths that come near each other are stepped together, with the substeps of the one that takes most. Where they lie on each other, a
/// tick takes two to four times as long as that of the same cloths apart, and more in high stacks; where none is near, nothing. A cloth
/// that moves wakes the cloth that it touches, and cloths that lie on each other fall asleep together. One that sleeps, or that
/// [`ClothPaused`](crate::ClothPaused) holds, is as a wall to others meanwhile.
///
/// Cloths should not start within each other: those that do are told of once in the log, stay calm, and come apart where they can.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothInterCollision, prelude::*};
/// # fn spawn(mut commands: Commands) {
/// for layer in 0..3 {
///     commands.spawn((
///         Cloth::sheet(Vec2::splat(1.0), UVec2::splat(48)),
///         ClothInterCollision::default(),
///         Transform::from_xyz(0.0, 1.0 + 0.1 * layer as f32, 0.0),
///     ));
/// }
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothInterCollision {
    /// Layers, a bit each. Two cloths collide where they share one. They have nothing to do with the layers of colliders
    /// ([`ClothSettings::layers`](crate::ClothSettings::layers)).
    pub layers: ClothLayers,
    /// Distance that particles keep from those of a cloth like it \[m\], at most that of neighbours at rest; each of two cloths gives
    /// half of its own. `None` is the least at which no layer passes through another, 0.92 of the particle spacing on a
    /// square sheet. Smaller is thinner and lets layers pass.
    pub distance: Option<f32>,
    /// Coulomb's coefficient \[1\]. Between two cloths it is the geometric mean of both. Higher slides less.
    pub friction: f32,
}

impl Default for ClothInterCollision {
    fn default() -> Self {
        InterCollision::default().into()
    }
}

impl From<InterCollision> for ClothInterCollision {
    fn from(InterCollision { layers, distance, friction }: InterCollision) -> Self {
        Self { layers: layers.into(), distance, friction }
    }
}

impl From<ClothInterCollision> for InterCollision {
    fn from(ClothInterCollision { layers, distance, friction }: ClothInterCollision) -> Self {
        Self { layers: layers.0, distance, friction }
    }
}
