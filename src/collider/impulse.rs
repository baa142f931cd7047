//! The momentum that cloths give to colliders.

use bevy::prelude::*;

use crate::solver::Impulse;

/// Momentum that all cloths gave a collider in the last tick, in world axes.
///
/// Add it to a collider to have it measured. A cloth that did not run in the tick gave nothing. Divided by the tick's length it
/// is the mean force on the collider. What is to move a body of the game has a [`ColliderMass`](crate::ColliderMass) too, and goes by
/// [`BodyImpulse`](crate::BodyImpulse).
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ColliderImpulse {
    /// Momentum \[kg m/s\].
    pub linear: Vec3,
    /// Angular momentum about the centre of mass that its [`ColliderMass`](crate::ColliderMass) says, else about the entity's
    /// place \[kg m2/s\].
    pub angular: Vec3,
}

impl From<Impulse> for ColliderImpulse {
    fn from(Impulse { linear, angular }: Impulse) -> Self {
        Self { linear, angular }
    }
}
