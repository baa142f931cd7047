//! How particles were held by what they lay on, while corrections moved them.

use crate::solver::contact::active_set::Normals;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{Soa, ValuesMut};

/// Particles that have been held by what they lay on. What has met a collider is held no longer.
pub(super) struct Held<'a> {
    pub set: &'a Normals,
    /// The particles' displacements before any correction.
    pub unpulled: &'a Soa,
    pub lost: ValuesMut<'a>,
    pub load: ValuesMut<'a>,
}

impl CutAt for Held<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (lost, lost_below) = self.lost.cut(slot);
        let (load, load_below) = self.load.cut(slot);
        let below = Self { lost: lost_below, load: load_below, ..self };
        (Self { lost, load, ..self }, below)
    }
}

/// How a block of particles was held.
#[derive(Clone, Copy)]
pub(super) struct Hold {
    /// Displacements along the normals that contact has held back \[m\].
    pub unfollowed: Block3,
    /// Displacements before any correction \[m\].
    pub unpulled: Block3,
    /// One over the slip: displacements along the surface that pulls would have made, over those that they did.
    pub unslipped: Block,
    /// One where a particle was held.
    pub was: Block,
}

impl Hold {
    pub const NONE: Self = Self {
        unfollowed: Block3::ZERO,
        unpulled: Block3::ZERO,
        unslipped: Block([1.0; LANES]),
        was: Block::ZERO,
    };
}

impl Held<'_> {
    /// How a block's particles were held; `None` where none was.
    #[inline(always)]
    pub fn of(&mut self, slot: usize, w: &Block) -> Option<Hold> {
        if !self.set.any || !self.set.blocks[slot / LANES] {
            return None;
        }
        let mut hold = Hold { unfollowed: Block3::load(&self.set.normal, slot), ..Hold::NONE };
        hold.unpulled = Block3::load(self.unpulled, slot);
        let slip = Block::load(&self.set.slip, slot);
        let (lost, load) = (self.lost.blocks(slot, 1).at(0), self.load.blocks(slot, 1).at(0));
        for i in 0..LANES {
            let n = hold.unfollowed.at(i);
            let all = lost.0[i] + load.0[i] * w.0[i];
            // What another collider has met is held no more.
            let was = n.dot(n) > 0.0 && all != 0.0;
            hold.was.0[i] = if was { 1.0 } else { 0.0 };
            hold.unslipped.0[i] = if was { 1.0 / slip.0[i] } else { 1.0 };
            hold.unfollowed.set(i, n * all);
        }
        Some(hold)
    }

    /// Lets those of a block's particles go that would go further than `slow`: the whole way of what is fast is looked
    /// at.
    #[inline(always)]
    pub fn free(&mut self, slot: usize, d: &mut Block3, slow: f32) {
        if !self.set.any || !self.set.blocks[slot / LANES] {
            return;
        }
        let n = Block3::load(&self.set.normal, slot);
        let mut values = self.lost.blocks(slot, 1);
        let mut lost = values.at(0);
        for i in 0..LANES {
            let own = d.at(i) + n.at(i) * lost.0[i];
            let is_fast = own.dot(own) > slow * slow && lost.0[i] != 0.0;
            d.set(i, if is_fast { own } else { d.at(i) });
            lost.0[i] = if is_fast { 0.0 } else { lost.0[i] };
        }
        values.set(0, lost);
    }

    /// Forgets what held those of a block's particles that touch, which have a depth.
    #[inline(always)]
    pub fn let_go(&mut self, slot: usize, depth: &Block) {
        for values in [&mut self.lost, &mut self.load] {
            let mut values = values.blocks(slot, 1);
            let mut left = values.at(0);
            for i in 0..LANES {
                left.0[i] = if depth.0[i] > 0.0 { 0.0 } else { left.0[i] };
            }
            values.set(0, left);
        }
    }
}
