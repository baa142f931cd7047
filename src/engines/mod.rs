//! The colliders of physics engines, made colliders of cloths.
//!
//! An engine's shape is read once and becomes a solid of our own ([`solid`]): an exact one where there is one, else a field that
//! is baked in the background, once a shape however many colliders have it ([`bakes`]). Each engine has its own version of
//! parry, whose shapes are alike: [`read`] is compiled for each of them. Bodies that are dynamic are moved by cloths ([`bodies`]).

mod adapt;
mod adapted;
#[cfg(feature = "avian")]
pub(crate) mod avian;
mod bakes;
mod bodies;
mod boxes;
mod changes;
mod engine;
#[cfg(feature = "rapier")]
pub(crate) mod rapier;
mod solid;

use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::collider::bake::SdfCells;

/// Lets cloths collide with the collider of a physics engine that is on the same entity: Avian's or Rapier's `Collider`.
///
/// The engine's plugin for cloths, `AvianClothPlugin` or `RapierClothPlugin`, keeps an [`SdfCollider`](crate::SdfCollider) of the
/// same shape and friction on the entity, as long as the collider is neither a sensor nor disabled. An `SdfCollider` of one's own is left
/// alone, and is what cloths collide with. [`SdfColliderDisabled`](crate::SdfColliderDisabled) lets cloths alone pass through.
///
/// Balls, boxes, capsules, cylinders, cones, half-spaces, voxels and height fields are exact, and so are rounded and compound shapes
/// of them. Convex hulls and closed meshes are baked to fields in the background, and passed through until then.
///
/// Cloths push bodies that are dynamic. What a cloth carries comes to rest and falls asleep with it. A cloth that is pinned to a dynamic
/// body ([`ClothPins::anchored_to`](crate::ClothPins::anchored_to)) pulls it, whether the body has this component or not. Where an
/// engine locks axes of a body, or holds it by joints, it learns so at its next step.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothCollider {
    /// Coulomb's coefficient of friction \[1\]. Higher holds better. `None` is that of the engine's `Friction` (Avian's dynamic
    /// one, which may be on the body), or 0.5 where there is none.
    pub friction: Option<f32>,
    /// The layers that it is in. The engine's own layers mean nothing to cloths.
    pub layers: ClothLayers,
    /// Thickness of what has no inside: segments, triangles, polylines, open meshes \[m\]. Half of it is on either side. Zero refuses
    /// them. With another, every triangle mesh is a surface, closed or not; other shapes do not have it.
    pub thickness: f32,
    /// Whether cloths leave its body alone. They else carry it, slow it down and turn it, if it is dynamic and the engine runs in a
    /// fixed schedule: the body has a [`ColliderMass`](crate::ColliderMass) then, of which the engine says the numbers.
    pub one_way: bool,
    /// How fine the fields of hulls and meshes are, in the frame of the engine's unscaled shape.
    pub cells: SdfCells,
}
