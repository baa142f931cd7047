//! The weft springs of a sheet, held to Provot's strain limit. Neighbours lie in one block, so that each particle works out its own
//! half of the correction from its partner's place.

use crate::solver::constraints::strain_limit::{
    CorrectBatch, LEAST_DIVISOR, LEAST_LENGTH, mobility,
};
use crate::solver::contact::divide;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;

impl CorrectBatch<'_> {
    /// Weft springs: of even columns, then of odd ones.
    #[inline(always)]
    pub(super) fn weft(&mut self, limit: f32) {
        for row in self.band.rows.clone() {
            self.weft_row::<0>(row, limit);
        }
        for row in self.band.rows.clone() {
            self.weft_row::<1>(row, limit);
        }
    }

    /// The particles to the left of those of a block. Loads them from memory: shifted in registers, they would pass through memory
    /// all the same, and wait for what was stored.
    #[inline(always)]
    fn left_of(&self, row: usize, column: usize) -> Block3 {
        let slot = self.lattice.layout.slot(row, column);
        if column > 0 || row > self.band.rows.start {
            return Block3::load_sum(self.x, &self.d, slot - 1);
        }
        let x = Block3::load_sum(self.x, &self.d, slot);
        let mut left = Block3::ZERO;
        for i in 1..LANES {
            left.set(i, x.at(i - 1));
        }
        left
    }

    #[inline(always)]
    fn weft_row<const PARITY: usize>(&mut self, row: usize, limit: f32) {
        let rests = &self.lattice.weft.rest;
        let columns = self.lattice.layout.columns;
        // No particle is to the left of the first one.
        let mut left = self.left_of(row, 0);
        for column in (0..columns).step_by(LANES) {
            let slot = self.lattice.layout.slot(row, column);
            let is_last = column + LANES >= columns;
            if !self.looks_at(slot) {
                left = if is_last { Block3::ZERO } else { self.left_of(row, column + LANES) };
                continue;
            }
            let x = Block3::load_sum(self.x, &self.d, slot);
            let right = Block3::load_sum(self.x, &self.d, slot + 1);
            let partner = alternate3::<PARITY>(&right, &left);
            let rest = [Block::load(rests, slot), Block::load(rests, slot - 1)];
            let rest = alternate::<PARITY>(&rest[0], &rest[1]);
            let (mut span, mut length, mut excess) = (Block3::ZERO, Block::ZERO, Block::ZERO);
            for i in 0..LANES {
                let apart = partner.at(i) - x.at(i);
                span.set(i, apart);
                length.0[i] = larger(apart.dot(apart).sqrt(), LEAST_LENGTH);
                let beyond = larger(length.0[i] - rest.0[i] * limit, 0.0);
                // No spring has the rest length zero: beside the sheet there is nothing to correct.
                excess.0[i] = if rest.0[i] > 0.0 { beyond } else { 0.0 };
            }
            // The next block's last neighbour is needed as it was, before this one is stored.
            left = if is_last { Block3::ZERO } else { self.left_of(row, column + LANES) };
            if excess.is_any() {
                self.shorten::<PARITY>(slot, &span, &length, &excess);
            }
        }
    }

    /// Moves a block of particles by their part of what the weft springs to their partners are too long.
    #[inline(always)]
    fn shorten<const PARITY: usize>(
        &mut self,
        slot: usize,
        span: &Block3,
        length: &Block,
        excess: &Block,
    ) {
        let w = self.mobile(slot);
        let other = alternate::<PARITY>(&self.mobile(slot + 1), &self.mobile(slot - 1));
        let mut d = Block3::load(&self.d, slot);
        match &mut self.contacts {
            None => {
                for i in 0..LANES {
                    let divisor = larger(w.0[i] + other.0[i], LEAST_DIVISOR) * length.0[i];
                    d.set(i, d.at(i) + span.at(i) * (excess.0[i] * w.0[i] / divisor));
                }
            }
            Some(contacts) => {
                let normals = &contacts.normals.normal;
                let n = Block3::load(normals, slot);
                let partner = [Block3::load(normals, slot + 1), Block3::load(normals, slot - 1)];
                let partner = alternate3::<PARITY>(&partner[0], &partner[1]);
                let mut pulls = Block3::ZERO;
                for i in 0..LANES {
                    let across = [n.at(i).dot(span.at(i)), partner.at(i).dot(span.at(i))];
                    let (w, other) = (w.0[i], other.0[i]);
                    let both = mobility(w + other, across, length.0[i], [w, other]);
                    let divisor = larger(both, LEAST_DIVISOR) * length.0[i];
                    pulls.set(i, span.at(i) * (excess.0[i] / divisor));
                }
                let (along, load) = divide(&pulls, &n);
                contacts.add(slot, &load);
                for i in 0..LANES {
                    d.set(i, d.at(i) + along.at(i) * w.0[i]);
                }
            }
        }
        d.store(&mut self.d, slot);
    }
}

/// Every other lane of the one, from the lane `PARITY` on, and those between of the other. Without a condition: of two places in
/// memory, the compiler would choose before it loads, lane by lane.
#[inline(always)]
fn alternate<const PARITY: usize>(one: &Block, other: &Block) -> Block {
    let mut out = Block::ZERO;
    for i in 0..LANES {
        let mask = if i % 2 == PARITY { u32::MAX } else { 0 };
        let bits = (one.0[i].to_bits() & mask) | (other.0[i].to_bits() & !mask);
        out.0[i] = f32::from_bits(bits);
    }
    out
}

/// The same of vectors.
#[inline(always)]
fn alternate3<const PARITY: usize>(one: &Block3, other: &Block3) -> Block3 {
    Block3 {
        x: alternate::<PARITY>(&one.x, &other.x),
        y: alternate::<PARITY>(&one.y, &other.y),
        z: alternate::<PARITY>(&one.z, &other.z),
    }
}
