//! Which colliders a cloth meets.

use bevy::prelude::*;

/// Layers of colliders, a bit each. A cloth and a collider meet where they share one.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothLayers;
/// const FURNITURE: ClothLayers = ClothLayers(1 << 0);
/// const BODIES: ClothLayers = ClothLayers(1 << 1);
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((SdfCollider::from(Sphere::new(0.5)).in_layers(BODIES), Transform::default()));
/// // This one passes through bodies.
/// commands.spawn((
///     Cloth::sheet(Vec2::ONE, UVec2::splat(32)),
///     ClothSettings { layers: FURNITURE, ..default() },
/// ));
/// # }
/// ```
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
#[reflect(Default, Debug, PartialEq, Clone, Hash)]
pub struct ClothLayers(pub u32);

impl ClothLayers {
    /// Every layer.
    pub const ALL: Self = Self(u32::MAX);
    /// No layer: nothing is met.
    pub const NONE: Self = Self(0);
}

impl Default for ClothLayers {
    fn default() -> Self {
        Self::ALL
    }
}

impl From<u32> for ClothLayers {
    fn from(bits: u32) -> Self {
        Self(bits)
    }
}
