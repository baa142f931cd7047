//! The particles of one side of a batch, as its response sees them.

use bevy_math::Vec3;

use crate::solver::cloth_contact::beads::Beads;
use crate::solver::contact::LEAST_MOBILITY;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::transpose::Transpose;

/// Where the particles of one side of a batch are.
#[derive(Clone, Copy)]
pub(super) struct Spots {
    /// Where the substep began, and displacements since \[m\].
    pub x: Block3,
    pub d: Block3,
    /// Inverse masses \[1/kg\].
    pub inverse_mass: Block,
    /// 1 where a particle stands down, else 0.
    pub down: Block,
}

impl Spots {
    #[inline(always)]
    pub fn gather(t: impl Transpose, beads: &Beads, slots: &[u32; LANES]) -> Self {
        let beads = &*beads.all;
        let [x, y, z, inverse_mass] = t.apart(|i| beads[slots[i] as usize].x);
        let [dx, dy, dz, down] = t.apart(|i| beads[slots[i] as usize].d);
        Self { x: Block3 { x, y, z }, d: Block3 { x: dx, y: dy, z: dz }, inverse_mass, down }
    }

    /// From the particles of another side to these, how much further they move in the substep \[m\].
    #[inline(always)]
    pub fn further_than(&self, other: &Self) -> Block3 {
        let mut further = Block3::ZERO;
        for i in 0..LANES {
            further.set(i, self.d.at(i) - other.d.at(i));
        }
        further
    }
}

/// Numbers of the particles of one side of a batch, those that touch.
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
    /// The numbers of particles that lie on nothing, with the cloth's normals.
    #[inline(always)]
    pub fn free(normal: Block3, spots: &Spots) -> Self {
        let w = spots.inverse_mass;
        let [onto, undone] = [Block3::ZERO; 2];
        Self { normal, onto, undone, inverse_mass: w, slipping: w, loose: w, pushed: w }
    }

    /// Takes in how particles lie on colliders, whose displacements are `d`.
    #[inline(always)]
    pub fn lie(&mut self, t: impl Transpose, beads: &Beads, slots: &[u32; LANES], d: &Block3) {
        let Beads { onto, carried, .. } = beads;
        // Of one length, so that one check of a slot does for both.
        let carried = &carried[..onto.len()];
        let [x, y, z, slip] = t.apart(|i| onto[slots[i] as usize]);
        let [cx, cy, cz, loose] = t.apart(|i| carried[slots[i] as usize]);
        self.onto = Block3 { x, y, z };
        let carried = Block3 { x: cx, y: cy, z: cz };
        for i in 0..LANES {
            let (onto, w) = (self.onto.at(i), self.inverse_mass.0[i]);
            let undone = (d.at(i) - carried.at(i)) * (1.0 - loose.0[i]);
            let undone = undone - onto * onto.dot(undone);
            let lies = onto.x != 0.0 || onto.y != 0.0 || onto.z != 0.0;
            self.undone.set(i, if lies { undone } else { Vec3::ZERO });
            self.slipping.0[i] = w * slip.0[i];
            self.loose.0[i] = w * slip.0[i] * loose.0[i];
        }
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
