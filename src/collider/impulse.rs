//! The momentum that cloths give to colliders.

use bevy::prelude::*;

/// Momentum that all cloths gave a collider in the last tick \[kg m/s\], in world axes: divided by the
/// tick's length, the mean force on it \[N\].
///
/// Add it to a collider to have it measured. A cloth that did not run in the tick gave nothing.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Deref)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ColliderImpulse(pub Vec3);
