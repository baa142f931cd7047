//! Where springs are beyond the strain limit: one look in the order of memory, where holding springs to
//! it takes a pass for each colour. Where none is, nothing has to be held; and no more than around those that are.

use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::slots::ByBlock;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::lattice::Lattice;

/// The limit of strain, and which springs are held to it.
#[derive(Clone, Copy)]
pub(crate) struct Limit {
    /// Longest that a spring may be, in rest lengths: 1 + max strain.
    pub longest: f32,
    /// Whether shear springs are limited.
    pub shear: bool,
    /// Whether a mesh looks at all of its springs, or only at those that were near their limit when it last did.
    pub all: bool,
}

impl Limit {
    /// Length from which on a spring is near its limit, in rest lengths.
    pub fn near(&self) -> f32 {
        0.5 * (1.0 + self.longest)
    }
}

/// Strain beyond the limit that is left as it is.
pub(crate) const CLOSE: f32 = 5e-4;

/// How particles of a sheet may have moved since it was last looked at in this substep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Since {
    /// It was not looked at.
    Never,
    /// By a pass over the springs around those that were found, and by nothing else.
    Pass,
    /// By a pass, and then by anything.
    Round,
}

impl Since {
    /// Strain beyond the limit that is not looked for: no further pass is made for next to nothing.
    pub fn leaves(self) -> f32 {
        if self == Self::Never { 0.0 } else { CLOSE }
    }
}

/// Rows around those where any spring is beyond its limit in which a pass may bring others there, in steps: with each of its four batches it
/// may move the particles of one row more, in which springs of the row before end.
const SPREAD: [usize; 3] = [1, 2, 2];

/// The blocks of a sheet where springs are beyond their limit, or a pass may bring them there.
#[derive(Clone, Debug)]
pub(crate) struct Beyond {
    /// Where they are. Never in the padding.
    found: Vec<bool>,
    /// Where a pass may come.
    reached: Vec<bool>,
    /// Room to spread in.
    before: Vec<bool>,
    /// Blocks from row to row.
    across: usize,
}

impl Beyond {
    pub fn new(layout: Layout) -> Self {
        let none = vec![false; layout.len() / LANES];
        let across = layout.stride / LANES;
        Self { found: none.clone(), reached: none.clone(), before: none, across }
    }

    /// Where springs are beyond their limit, to be written, and the blocks to look at, where these are not all.
    pub fn begin_look(&mut self, since: Since) -> (ByBlock<'_, bool>, Option<&[bool]>) {
        let reached = (since == Since::Pass).then_some(&*self.reached);
        (ByBlock::all(&mut self.found), reached)
    }

    /// Finds where a pass may come to from what was found.
    pub fn spread(&mut self) {
        self.reached.copy_from_slice(&self.found);
        // To the blocks beside them, which are padding beside a row; then from row to row.
        self.spread_by(1);
        for rows in SPREAD {
            self.spread_by(rows * self.across);
        }
    }

    fn spread_by(&mut self, blocks: usize) {
        self.before.copy_from_slice(&self.reached);
        for (to, from) in self.reached.iter_mut().skip(blocks).zip(&self.before) {
            *to |= *from;
        }
        for (to, from) in self.reached.iter_mut().zip(self.before.iter().skip(blocks)) {
            *to |= *from;
        }
    }

    /// Whether a pass may come to the block that begins at a slot.
    #[inline(always)]
    pub fn reaches(&self, slot: usize) -> bool {
        self.reached[slot / LANES]
    }
}

/// Looks for springs that are longer than they may be at the substep's end. Tells whether any is.
pub(crate) struct ExceedsLimit<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    pub limit: Limit,
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// Where springs are that begin in a block.
    pub beyond: ByBlock<'a, bool>,
    /// The blocks to look at, if not all.
    pub only: Option<&'a [bool]>,
}

impl Kernel for ExceedsLimit<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        let Self { lattice, limit: Limit { shear, .. }, .. } = self;
        let layout = lattice.layout;
        let mut any = false;
        for row in self.band.rows.clone() {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                if self.only.is_some_and(|only| !only[slot / LANES]) {
                    self.beyond.row(slot, 1)[0] = false;
                    continue;
                }
                let mut excess = Block::ZERO;
                let below = slot + layout.stride;
                let here = self.places(slot);
                let right = self.places(slot + 1);
                self.look(&here, &right, &lattice.weft.rest, slot, &mut excess);
                if row + 1 < layout.rows {
                    let under = self.places(below);
                    self.look(&here, &under, &lattice.warp.rest, slot, &mut excess);
                    if shear {
                        let across = self.places(below + 1);
                        self.look(&here, &across, &lattice.diagonal.rest, slot, &mut excess);
                        self.look(&right, &under, &lattice.antidiagonal_rest, slot, &mut excess);
                    }
                }
                let is_beyond = excess.is_any_above(0.0);
                self.beyond.row(slot, 1)[0] = is_beyond;
                any |= is_beyond;
            }
        }
        any
    }
}

cut_between_rows!(ExceedsLimit, beyond);

impl ExceedsLimit<'_> {
    /// Where particles are at the substep's end.
    #[inline(always)]
    fn places(&self, slot: usize) -> Block3 {
        Block3::load_sum(self.x, self.d, slot)
    }

    #[inline(always)]
    fn look(&self, p: &Block3, q: &Block3, rest: &Array, at: usize, excess: &mut Block) {
        let rest = Block::load(rest, at);
        for i in 0..LANES {
            let span = q.at(i) - p.at(i);
            let longest = rest.0[i] * self.limit.longest;
            let over = span.dot(span) - longest * longest;
            // No spring has the rest length zero.
            let over = if rest.0[i] > 0.0 { over } else { 0.0 };
            excess.0[i] = larger(over, excess.0[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows and blocks that a pass may come to from those that are given.
    fn reached(
        beyond: &mut Beyond,
        layout: Layout,
        found: &[(usize, usize)],
    ) -> Vec<(usize, usize)> {
        let slot = |row, block| layout.slot(row, block * LANES);
        let all =
            (0..layout.rows).flat_map(|row| (0..layout.blocks_across()).map(move |b| (row, b)));
        for (row, block) in all.clone() {
            let (mut written, _) = beyond.begin_look(Since::Never);
            written.row(slot(row, block), 1)[0] = found.contains(&(row, block));
        }
        beyond.spread();
        all.filter(|&(row, block)| beyond.reaches(slot(row, block))).collect()
    }

    #[test]
    fn a_pass_reaches_five_rows_and_a_block_around_what_is_found() {
        let layout = Layout::new(40, 70);
        let mut beyond = Beyond::new(layout);
        let around = |rows: core::ops::RangeInclusive<usize>, blocks: &[usize]| -> Vec<_> {
            rows.flat_map(|row| blocks.iter().map(move |&block| (row, block))).collect()
        };
        assert_eq!(reached(&mut beyond, layout, &[(20, 1)]), around(15..=25, &[0, 1, 2]));
        // At the border, where padding is beside it; nothing of what was found before is left.
        assert_eq!(reached(&mut beyond, layout, &[(39, 4)]), around(34..=39, &[3, 4]));
        assert_eq!(reached(&mut beyond, layout, &[(0, 0)]), around(0..=5, &[0, 1]));
        assert_eq!(reached(&mut beyond, layout, &[]), []);
    }
}
