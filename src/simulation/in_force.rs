//! The shape, material, settings, pins and weights of a cloth that are in force.

use std::sync::Arc;

use bevy::prelude::*;

use crate::cloth::ClothShape;
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::ClothPins;
use crate::cloth::proxy::ClothProxy;
use crate::cloth::settings::ClothSettings;
use crate::cloth::skin::ClothSkin;
use crate::cloth::weights::ClothWeights;
use crate::mesh::proxy::Proxy;
use crate::mesh::rest_shape::RestShape;
use crate::solver::Pose;

/// Change of the scale from which on a cloth gets another size \[1\].
pub(crate) const OTHER_SIZE: f32 = 0.01;

/// The values that a running cloth uses. The components beside it may hold numbers that were refused.
#[derive(Reflect)]
#[reflect(from_reflect = false)]
pub(crate) struct InForce {
    /// The shape that the cloth was set up from.
    pub(crate) shape: ClothShape,
    pub(crate) material: ClothMaterial,
    pub(crate) settings: ClothSettings,
    pub(crate) pins: ClothPins,
    /// `None` where the cloth is the same everywhere.
    #[reflect(ignore)]
    pub(crate) weights: Option<ClothWeights>,
    /// `None` where the cloth is not worn.
    #[reflect(ignore)]
    pub(crate) skin: Option<ClothSkin>,
    /// `None` where what is drawn is simulated.
    #[reflect(ignore)]
    pub(crate) asked_proxy: Option<ClothProxy>,
    #[reflect(ignore)]
    pub(crate) proxy: Option<Arc<Proxy>>,
    /// What is simulated: unscaled, in the entity's frame.
    #[reflect(ignore)]
    pub(crate) rest_shape: RestShape,
    /// The entity's pose at setup, whose scale follows the entity's; of a worn one, the scale alone, which is its skeleton's.
    #[reflect(ignore)]
    pub(crate) placed: Pose,
}
