//! A part of a cloth, and whether it is flat.

use bevy_math::Vec3;

use crate::solver::cloth_contact::regions::Extent;
use crate::solver::simd::block::larger;
use crate::solver::simd::lanes::LANES;

/// Particles of a patch at most: the places of a patch are the lanes of a block.
pub(super) const PARTICLES: usize = LANES;
/// Cosine of half the angle of a narrow cone. Seen from its axis, two particles of a square sheet that are not neighbours are at
/// least 1.57 spacings apart, and do not touch before the cloth has moved by the margin.
pub(super) const NARROW: f32 = 0.785;

/// A part of a cloth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// The box around its particles \[m\].
    pub extent: Extent,
    /// Axis of the cone that its normals lie in, of length one.
    pub axis: Vec3,
    /// Least cosine of the angle between this axis and that of a narrow cone which holds the cone; infinite where none does, as the
    /// patch is bent.
    least_cosine: f32,
}

impl Patch {
    /// A part in this box, whose normals lie in a cone of which half the angle has this cosine.
    #[inline(always)]
    pub fn new(extent: Extent, axis: Vec3, cosine: f32) -> Self {
        // The cosine of the difference of both angles.
        let sines = larger((1.0 - NARROW * NARROW) * (1.0 - cosine * cosine), 0.0).sqrt();
        let least_cosine = if cosine < NARROW { f32::INFINITY } else { NARROW * cosine + sines };
        Self { extent, axis, least_cosine }
    }

    pub fn is_bent(&self) -> bool {
        self.least_cosine == f32::INFINITY
    }

    /// Whether its cone lies in a narrow one around a vector of this length.
    fn is_along(&self, along: Vec3, length: f32) -> bool {
        self.axis.dot(along) >= self.least_cosine * length
    }
}

/// Whether patches all lie in one narrow cone.
pub(super) fn are_flat(all: &[Patch], some: impl Iterator<Item = usize> + Clone) -> bool {
    let sum = some.clone().map(|patch| all[patch].axis).sum::<Vec3>();
    let length = sum.length();
    length > 0.0 && some.into_iter().all(|patch| all[patch].is_along(sum, length))
}
