//! The skin of a shape that is drawn finer than it is simulated.

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::mesh::skinned::SkinnedShape;

/// The skin of a drawn shape, which another carries.
pub(crate) struct DrawnSkin {
    pub shape: SkinnedShape,
    /// Which of its particles have a max distance of 0: they are drawn where the skin is.
    pub at_zero: Vec<bool>,
}

impl DrawnSkin {
    /// Of a cloth that has no limits yet.
    pub fn new(shape: SkinnedShape) -> Self {
        Self { at_zero: vec![false; shape.points.len()], shape }
    }

    /// Where the joints of these matrices take a particle in the world \[m\].
    pub fn place(&self, particle: usize, matrices: &[Affine3A]) -> Vec3 {
        let SkinnedShape { points, influences, .. } = &self.shape;
        influences[particle].blend(matrices).transform_point3(points[particle])
    }
}
