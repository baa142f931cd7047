//! The particles of one side of a batch, as its response sees them.

use bevy_math::Vec3;

use crate::solver::cloth_contact::side::Side;
use crate::solver::contact::LEAST_MOBILITY;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;

/// Numbers of the particles of one side of a batch, where they touch.
pub(super) struct Grains {
    /// The cloth's normal, and that of the collider that a particle lies on.
    pub normal: Block3,
    pub onto: Block3,
    /// Part of the displacement that the collider's friction is to undo \[m\].
    pub undone: Block3,
    /// Inverse mass, all of it, and what is left of it along a collider \[1/kg\].
    pub inverse_mass: Block,
    pub slipping: Block,
    /// Inverse mass that is left along a collider once its friction has held the particle \[1/kg\].
    pub loose: Block,
    /// Inverse mass that a push without speed moves \[1/kg\].
    pub pushed: Block,
}

impl Grains {
    #[inline(always)]
    pub fn load(side: &mut Side<'_>, slots: &[u32; LANES], touches: &[u32; LANES]) -> Self {
        let mut grains = Self {
            normal: Block3::ZERO,
            onto: Block3::ZERO,
            undone: Block3::ZERO,
            inverse_mass: Block::ZERO,
            slipping: Block::ZERO,
            loose: Block::ZERO,
            pushed: Block::ZERO,
        };
        for i in (0..LANES).filter(|&i| touches[i] != 0) {
            let slot = slots[i] as usize;
            let (lies, w) = (side.lies(slot), side.inverse_mass[slot]);
            grains.normal.set(i, side.normal(slot));
            grains.onto.set(i, lies.onto);
            grains.undone.set(i, lies.undone);
            grains.inverse_mass.0[i] = w;
            grains.slipping.0[i] = w * lies.slip;
            grains.loose.0[i] = w * lies.slip * lies.loose;
            grains.pushed.0[i] =
                if side.is_held { grains.loose.0[i] } else { grains.slipping.0[i] };
        }
        grains
    }

    /// How far momentum of one along a direction of some length moves a particle that moves by `w` where it is free \[1/kg\].
    #[inline(always)]
    pub fn mobility(&self, w: &Block, lane: usize, direction: Vec3, square: f32) -> f32 {
        let onto = self.onto.at(lane).dot(direction);
        w.0[lane] * (1.0 - onto * onto / square)
    }

    /// Least mobility of two particles that a push divides by \[1/kg\].
    #[inline(always)]
    pub fn least_mobility_with(&self, other: &Self, lane: usize) -> f32 {
        let all = self.inverse_mass.0[lane] + other.inverse_mass.0[lane];
        larger(all * LEAST_MOBILITY, f32::MIN_POSITIVE)
    }
}
