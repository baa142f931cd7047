//! Cloth that collides with itself.

use bevy::prelude::*;

use crate::solver::SelfCollision;

/// Lets a cloth collide with itself: its layers lie on each other in folds and heaps. Without it they pass through each other.
/// May be added, changed and removed at any time.
///
/// Particles are kept from each other as balls are, so that layers are as far apart as particles are: about
/// `distance`, and closer only with a finer cloth. What is near each other at rest is left alone. Where
/// layers touch, a tick takes 1.2 to 2.3 times as long, and an automatic number of substeps rises to what layers
/// need, which the [`plan`](crate::ClothSimulation::plan) tells; fewer [fixed](crate::solver::Substeps::Fixed) ones may let layers pass.
///
/// A cloth that is tangled when it is given this is told of once in the log. It stays calm, and comes apart where it can.
/// [`ClothSimulation::crossings`](crate::ClothSimulation::crossings) counts what has passed through.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothSelfCollision, prelude::*};
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((
///     Cloth::sheet(Vec2::splat(1.0), UVec2::splat(64)),
///     ClothSelfCollision::default(),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothSelfCollision {
    /// Distance that particles keep from each other \[m\], at most that of neighbours at rest; `None` is the least at which no
    /// layer passes through another, 0.92 of the particle spacing on a square sheet. Smaller is thinner and lets layers pass.
    pub distance: Option<f32>,
    /// Coulomb's coefficient between layers \[1\]. Higher slides less.
    pub friction: f32,
}

impl Default for ClothSelfCollision {
    fn default() -> Self {
        SelfCollision::default().into()
    }
}

impl From<SelfCollision> for ClothSelfCollision {
    fn from(SelfCollision { distance, friction }: SelfCollision) -> Self {
        Self { distance, friction }
    }
}

impl From<ClothSelfCollision> for SelfCollision {
    fn from(ClothSelfCollision { distance, friction }: ClothSelfCollision) -> Self {
        Self { distance, friction }
    }
}
