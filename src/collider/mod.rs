//! Colliders: the solids that cloths collide with, and where they are in each tick.

pub(crate) mod bake;
pub(crate) mod body;
pub(crate) mod check;
pub(crate) mod disturbance;
pub(crate) mod gather_bodies;
pub(crate) mod impulse;
pub(crate) mod load;
pub(crate) mod mass;
pub(crate) mod shape;
pub(crate) mod snapshot;
pub(crate) mod tick_body;
pub(crate) mod tick_colliders;

use std::sync::Arc;

use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::collider::shape::{CustomSdf, SdfShape};
use crate::collider::tick_colliders::ColliderPose;
use crate::sdf::shapes::CapsuleBetween;
use crate::sdf::{DistanceField, SignedDistance};

/// Distance moved in a tick beyond which a collider counts as teleported, and sweeps nothing on its way \[m\].
const JUMP: f32 = 10.0;

/// A rigid solid for every cloth that shares one of its layers.
///
/// It follows its entity, which may be scaled alike along all axes. Another scale, a length of the shape
/// that is not from 1e-6 to 1e7 m, or a field that will not come is refused with a
/// [`ClothError`](crate::ClothError), and the collider is ignored until that is fixed. May be moved in the
/// fixed schedule or once a frame, and changed at any time. A collider that moves more than 10 m in a tick
/// counts as teleported: it sweeps nothing on its way. Neither does one that comes along with a cloth that is teleported, however far.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((SdfCollider::from(Sphere::new(0.5)), Transform::from_xyz(0.0, 1.0, 0.0)));
/// commands.spawn(SdfCollider::from(InfinitePlane3d::default()).with_friction(0.8));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, Clone)]
#[require(Transform, ColliderPose)]
pub struct SdfCollider {
    /// The solid, in the entity's frame.
    pub shape: SdfShape,
    /// Coulomb's coefficient of friction \[1\]. Higher holds better; a pair's is the geometric
    /// mean.
    pub friction: f32,
    /// The layers that it is in. A cloth passes through unless
    /// [`ClothSettings::layers`](crate::ClothSettings::layers) shares one.
    pub layers: ClothLayers,
}

impl Default for SdfCollider {
    /// Bevy's default sphere, of a radius of 0.5 m.
    fn default() -> Self {
        Self::new(Sphere::default())
    }
}

impl SdfCollider {
    /// A collider with a friction of 0.5.
    pub fn new(shape: impl Into<SdfShape>) -> Self {
        Self { shape: shape.into(), friction: 0.5, layers: ClothLayers::ALL }
    }

    /// A collider of a field that is baked (see also [`BakeSdf`](crate::BakeSdf)) or loaded from an `.sdf` file. It is
    /// waited for as long as it loads.
    pub fn field(field: Handle<DistanceField>) -> Self {
        Self::new(field)
    }

    /// A collider of any other solid.
    pub fn custom(shape: impl SignedDistance) -> Self {
        Self::new(SdfShape::Custom(CustomSdf(Arc::new(shape))))
    }

    /// A capsule between two points of the entity's frame \[m\]: on the joint of a skinned character, the
    /// bone from it to the next. [`ClothBody`](crate::ClothBody) fits those of a whole character.
    pub fn capsule_between(from: Vec3, to: Vec3, radius: f32) -> Self {
        Self::new(CapsuleBetween { from, to, radius })
    }

    /// In these layers alone.
    pub fn in_layers(self, layers: impl Into<ClothLayers>) -> Self {
        Self { layers: layers.into(), ..self }
    }

    /// With another coefficient of friction \[1\]. Higher holds better.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }
}

/// Lets cloths pass through an [`SdfCollider`], for as long as it is on its entity.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::SdfColliderDisabled;
/// fn open(mut commands: Commands, door: Single<Entity, With<SdfCollider>>) {
///     commands.entity(*door).insert(SdfColliderDisabled);
/// }
/// # bevy::ecs::system::assert_is_system(open);
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct SdfColliderDisabled;

impl<S: Into<SdfShape>> From<S> for SdfCollider {
    fn from(shape: S) -> Self {
        Self::new(shape)
    }
}
