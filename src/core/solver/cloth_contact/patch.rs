//! A part of a cloth, and whether it is flat.

use bevy_math::Vec3;

use crate::solver::cloth_contact::regions::Extent;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};

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
    pub least_cosine: f32,
}

/// [`Patch::least_cosine`] of a patch whose normals lie in a cone of which half the angle has this cosine.
#[inline(always)]
pub(super) fn narrow_cosine(cosine: f32) -> f32 {
    // The cosine of the difference of both angles.
    let sines = larger((1.0 - NARROW * NARROW) * (1.0 - cosine * cosine), 0.0).sqrt();
    if cosine < NARROW { f32::INFINITY } else { NARROW * cosine + sines }
}

impl Patch {
    pub fn is_bent(&self) -> bool {
        self.least_cosine == f32::INFINITY
    }
}

/// Whether a cone of an axis and a least cosine lies in a narrow one around a vector of this length.
#[inline(always)]
fn is_along(axis: Vec3, least_cosine: f32, along: Vec3, length: f32) -> bool {
    axis.dot(along) >= least_cosine * length
}

/// Whether patches all lie in one narrow cone.
pub(super) fn are_flat(all: &[Patch], some: impl Iterator<Item = usize> + Clone) -> bool {
    let sum = some.clone().map(|patch| all[patch].axis).sum::<Vec3>();
    let length = sum.length();
    let is_along = |patch: usize| is_along(all[patch].axis, all[patch].least_cosine, sum, length);
    length > 0.0 && some.into_iter().all(is_along)
}

/// The cones of patches, side by side.
#[derive(Clone, Debug)]
pub(super) struct Cones {
    /// See [`Patch`].
    axis: Soa,
    least_cosine: Array,
}

impl Cones {
    /// Cones of so many patches that hold nothing.
    pub fn zeros(count: usize) -> Self {
        Self { axis: Soa::zeros(count), least_cosine: Array::zeros(count) }
    }

    /// Sets that of a patch.
    #[inline(always)]
    pub fn set(&mut self, number: usize, patch: &Patch) {
        self.axis.set(number, patch.axis);
        self.least_cosine[number] = patch.least_cosine;
    }

    /// Axes and least cosines of some patches that follow each other.
    #[inline(always)]
    pub fn load(&self, first: usize) -> (Block3, Block) {
        (Block3::load(&self.axis, first), Block::load(&self.least_cosine, first))
    }

    /// Tells lane by lane whether patches all lie in one narrow cone: one where they do, zero elsewhere.
    #[inline(always)]
    pub fn are_flat<const N: usize>(some: [&(Block3, Block); N]) -> Block {
        let mut flat = Block::ZERO;
        for i in 0..LANES {
            let mut sum = Vec3::ZERO;
            for (axis, _) in some {
                sum += axis.at(i);
            }
            let length = sum.dot(sum).sqrt();
            let mut is_flat = length > 0.0;
            for (axis, least_cosine) in some {
                is_flat &= is_along(axis.at(i), least_cosine.0[i], sum, length);
            }
            flat.0[i] = if is_flat { 1.0 } else { 0.0 };
        }
        flat
    }
}
