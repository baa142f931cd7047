//! Springs of a lattice, each worked out once: at the particle that holds it, which keeps its half for the
//! particle at the other end until that is visited, further on in the row or in the next.
//!
//! The halves of two rows stay in the nearest cache. What a particle adds up comes in an order that a
//! mirrored sheet shares: a sum of two does not depend on their order, and mirroring exchanges the two of a
//! pair, or the two pairs of diagonals.

use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::lattice::Lattice;

/// The springs that are looked at, by their constants: a family of zero is left out.
pub(crate) struct Springs<'a> {
    pub lattice: &'a Lattice,
    /// Constant of structural springs, for a shape factor of one.
    pub thread: f32,
    /// Constant of shear springs.
    pub shear: f32,
}

/// A law of force between the ends of springs.
pub(crate) trait SpringForce {
    /// The data of neighbouring particles that it reads.
    type Ends;

    /// So many blocks of particles from a slot on.
    fn ends(&self, slot: usize, blocks: usize) -> Self::Ends;

    /// Forces on a block of first ends. On the others it is the opposite. Zero where the constant is.
    fn force(ends: [&Self::Ends; 2], block: usize, springs: &SpringBlock) -> Block3;
}

/// A block of springs.
pub(crate) struct SpringBlock {
    /// \[m\]
    pub rest: Block,
    pub constant: Block,
}

/// Forces on the first ends of the springs of the present row and of the one before it.
#[derive(Clone, Debug)]
pub(crate) struct SpringRows {
    /// Slots of a row, with a block of zeros before it.
    width: usize,
    /// Forces of the springs of this row.
    weft: Soa,
    /// Forces of the springs to the next row, of both rows in turn.
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
            self.work_out(springs, row - 1, law);
        }
    }

    /// Works out the springs that begin at a row. Rows are taken in their order.
    #[inline(always)]
    pub fn work_out<F: SpringForce>(&mut self, springs: &Springs<'_>, row: usize, law: &F) {
        let Springs { lattice, thread, shear } = *springs;
        let (first, blocks) = (self.first(row), lattice.layout.blocks_across());
        let slot = lattice.layout.slot(row, 0);
        let below = slot + lattice.layout.stride;
        let (here, right) = (law.ends(slot, blocks), law.ends(slot + 1, blocks));
        let (under, across) = (law.ends(below, blocks), law.ends(below + 1, blocks));
        let springs = |rest, shape, stiffness| {
            let (rest, shape) = (Blocks::new(rest, slot, blocks), Blocks::new(shape, slot, blocks));
            SpringsFrom { blocks, rest, shape, stiffness }
        };
        if thread > 0.0 {
            let Lattice { weft, warp, .. } = lattice;
            let weft = springs(&weft.rest, &weft.shape, thread);
            weft.work_out::<F>([&here, &right], &mut self.weft, LANES);
            let warp = springs(&warp.rest, &warp.shape, thread);
            warp.work_out::<F>([&here, &under], &mut self.warp, first);
        }
        if shear > 0.0 {
            // Both stand at their cell: the one from its first corner on, the other across.
            let Lattice { diagonal, antidiagonal_rest, .. } = lattice;
            let on = springs(&diagonal.rest, &diagonal.shape, shear);
            on.work_out::<F>([&here, &across], &mut self.diagonal, first);
            let back = springs(antidiagonal_rest, &diagonal.shape, shear);
            back.work_out::<F>([&right, &under], &mut self.antidiagonal, first);
        }
    }

    /// The springs at the particles of a row, once it has been worked out.
    #[inline(always)]
    pub fn at(&self, springs: &Springs<'_>, row: usize) -> SpringsAt<'_> {
        let blocks = springs.lattice.layout.blocks_across();
        let (now, before) = (self.first(row), self.first(row + 1));
        let (weft, warp) = (&self.weft, &self.warp);
        let (diagonal, antidiagonal) = (&self.diagonal, &self.antidiagonal);
        SpringsAt {
            threads: springs.thread > 0.0,
            shear: springs.shear > 0.0,
            right: Blocks3::new(weft, LANES, blocks),
            left: Blocks3::new(weft, LANES - 1, blocks),
            down: Blocks3::new(warp, now, blocks),
            up: Blocks3::new(warp, before, blocks),
            on: Blocks3::new(diagonal, now, blocks),
            back: Blocks3::new(diagonal, before - 1, blocks),
            beside: Blocks3::new(antidiagonal, now - 1, blocks),
            above: Blocks3::new(antidiagonal, before, blocks),
        }
    }

    /// Where the springs of a row begin, in the arrays of two rows.
    fn first(&self, row: usize) -> usize {
        row % 2 * self.width + LANES
    }
}

/// Forces on the first ends of the springs at the particles of a row.
pub(crate) struct SpringsAt<'a> {
    threads: bool,
    shear: bool,
    right: Blocks3<'a>,
    left: Blocks3<'a>,
    down: Blocks3<'a>,
    up: Blocks3<'a>,
    on: Blocks3<'a>,
    back: Blocks3<'a>,
    beside: Blocks3<'a>,
    above: Blocks3<'a>,
}

impl SpringsAt<'_> {
    /// Forces on a block of all springs of its particles.
    #[inline(always)]
    pub fn forces(&self, block: usize) -> Block3 {
        let mut forces = Block3::ZERO;
        if self.threads {
            let (right, left) = (self.right.at(block), self.left.at(block));
            forces = sum(&right, &left, &self.down.at(block), &self.up.at(block));
        }
        if self.shear {
            let (on, back) = (self.on.at(block), self.back.at(block));
            forces = forces.plus(&sum(&on, &back, &self.beside.at(block), &self.above.at(block)));
        }
        forces
    }
}

/// The springs of a family that begin at a row.
struct SpringsFrom<'a> {
    blocks: usize,
    rest: Blocks<'a>,
    shape: Blocks<'a>,
    /// The springs' constant for a shape factor of one.
    stiffness: f32,
}

impl SpringsFrom<'_> {
    /// Puts their forces to `to`, from `first` on.
    #[inline(always)]
    fn work_out<F: SpringForce>(&self, ends: [&F::Ends; 2], to: &mut Soa, first: usize) {
        let mut to = Blocks3Mut::new(to, first, self.blocks);
        for block in 0..self.blocks {
            let (rest, mut constant) = (self.rest.at(block), self.shape.at(block));
            for lane in &mut constant.0 {
                *lane *= self.stiffness;
            }
            to.set(block, F::force(ends, block, &SpringBlock { rest, constant }));
        }
    }
}

/// Two springs that begin at a particle, each with one that ends there.
#[inline(always)]
fn sum(first: &Block3, to_first: &Block3, second: &Block3, to_second: &Block3) -> Block3 {
    let mut out = Block3::ZERO;
    for i in 0..LANES {
        let (one, other) = (first.at(i) - to_first.at(i), second.at(i) - to_second.at(i));
        out.set(i, one + other);
    }
    out
}
