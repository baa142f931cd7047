//! Springs of a lattice, each worked out once: at the particle that holds it, which keeps its half for the
//! particle at the other end until that is visited, further on in the row or in the next.
//!
//! The halves of two rows stay in the nearest cache. What a particle adds up comes in an order that a
//! mirrored sheet shares: a sum of two does not depend on their order, and mirroring exchanges the two of a
//! pair, or the two pairs of diagonals.

use super::lanes::{Block, Block3, LANES, Soa};
use super::lattice::{Lattice, Layout};

/// The springs that are looked at, by their constants: a family of zero is left out.
pub(super) struct Springs<'a> {
    pub lattice: &'a Lattice,
    /// Of structural springs, for a shape factor of one.
    pub thread: f32,
    /// Of shear springs.
    pub shear: f32,
}

/// A law of force between the ends of springs.
pub(super) trait SpringForce {
    /// Forces on the particles of a block from springs to the particles at `there`. On those it is the
    /// opposite. Zero where the constant is.
    fn force(&self, here: usize, there: usize, rest: Block, constant: Block) -> Block3;
}

/// Forces on the first ends of the springs of the present row and of the one before it.
#[derive(Clone, Debug)]
pub(super) struct SpringRows {
    /// Slots of a row, with a block of zeros before it.
    width: usize,
    /// Of this row.
    weft: Soa,
    /// Of both rows in turn.
    warp: Soa,
    diagonal: Soa,
    antidiagonal: Soa,
}

impl SpringRows {
    pub fn new(layout: Layout) -> Self {
        let width = layout.stride + LANES;
        let both = Soa::zeros(2 * width);
        Self {
            width,
            weft: Soa::zeros(width),
            warp: both.clone(),
            diagonal: both.clone(),
            antidiagonal: both,
        }
    }

    /// Begins with a row: works out the springs that come to it from the row before. Before the first there are
    /// none.
    #[inline(always)]
    pub fn begin<F: SpringForce>(&mut self, springs: &Springs<'_>, row: usize, law: &F) {
        for springs in [&mut self.warp, &mut self.diagonal, &mut self.antidiagonal] {
            springs.clear();
        }
        if row > 0 {
            for column in (0..springs.lattice.layout.columns).step_by(LANES) {
                self.gather(springs, row - 1, column, law);
            }
        }
    }

    /// Forces on a block of all springs of its particles. Blocks are taken row by row, each from its
    /// first.
    #[inline(always)]
    pub fn gather<F: SpringForce>(
        &mut self,
        springs: &Springs<'_>,
        row: usize,
        column: usize,
        law: &F,
    ) -> Block3 {
        let at = LANES + column;
        let (now, before) = (row % 2 * self.width + at, (row + 1) % 2 * self.width + at);
        let Springs { lattice, thread, shear } = *springs;
        let slot = lattice.layout.slot(row, column);
        let below = slot + lattice.layout.stride;
        let (mut threads, mut diagonals) = (Block3::ZERO, Block3::ZERO);
        if thread > 0.0 {
            let (weft, warp) = (&lattice.weft, &lattice.warp);
            let constant = scaled(&weft.shape, slot, thread);
            let right = law.force(slot, slot + 1, Block::load(&weft.rest, slot), constant);
            right.store(&mut self.weft, at);
            let constant = scaled(&warp.shape, slot, thread);
            let down = law.force(slot, below, Block::load(&warp.rest, slot), constant);
            down.store(&mut self.warp, now);
            let left = Block3::load(&self.weft, at - 1);
            let up = Block3::load(&self.warp, before);
            threads = sum(right, left, down, up);
        }
        if shear > 0.0 {
            // Both stand at their cell: the one from its first corner on, the other across.
            let constant = scaled(&lattice.diagonal.shape, slot, shear);
            let rest = Block::load(&lattice.diagonal.rest, slot);
            let on = law.force(slot, below + 1, rest, constant);
            on.store(&mut self.diagonal, now);
            let rest = Block::load(&lattice.antidiagonal_rest, slot);
            let across = law.force(slot + 1, below, rest, constant);
            across.store(&mut self.antidiagonal, now);
            let back = Block3::load(&self.diagonal, before - 1);
            let beside = Block3::load(&self.antidiagonal, now - 1);
            let above = Block3::load(&self.antidiagonal, before);
            diagonals = sum(on, back, beside, above);
        }
        for i in 0..LANES {
            threads.set(i, threads.at(i) + diagonals.at(i));
        }
        threads
    }
}

/// Constants of springs, from their shape factors.
#[inline(always)]
fn scaled(shape: &[f32], slot: usize, constant: f32) -> Block {
    let mut out = Block::load(shape, slot);
    for lane in &mut out.0 {
        *lane *= constant;
    }
    out
}

/// Two springs that begin at a particle, each with one that ends there.
#[inline(always)]
fn sum(first: Block3, to_first: Block3, second: Block3, to_second: Block3) -> Block3 {
    let mut out = Block3::ZERO;
    for i in 0..LANES {
        let (one, other) = (first.at(i) - to_first.at(i), second.at(i) - to_second.at(i));
        out.set(i, one + other);
    }
    out
}
