//! Whether any spring is beyond the strain limit: one look in the order of memory, where holding springs to
//! it takes a pass for each colour. Where none is, nothing has to be held.

use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::lattice::Lattice;

/// Looks for a spring that is longer than it may be at the substep's end.
pub(crate) struct ExceedsLimit<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    /// 1 + max strain.
    pub limit: f32,
    /// Whether shear springs are limited.
    pub shear: bool,
    pub x: &'a Soa,
    pub d: &'a Soa,
}

impl Kernel for ExceedsLimit<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { lattice, shear, .. } = self;
        let layout = lattice.layout;
        for row in self.band.rows.clone() {
            let mut excess = Block::ZERO;
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let below = slot + layout.stride;
                let here = self.places(slot);
                let right = self.places(slot + 1);
                self.look(&here, &right, &lattice.weft.rest, slot, &mut excess);
                if row + 1 == layout.rows {
                    continue;
                }
                let under = self.places(below);
                self.look(&here, &under, &lattice.warp.rest, slot, &mut excess);
                if shear {
                    let across = self.places(below + 1);
                    self.look(&here, &across, &lattice.diagonal.rest, slot, &mut excess);
                    self.look(&right, &under, &lattice.antidiagonal_rest, slot, &mut excess);
                }
            }
            if excess.largest() > 0.0 {
                return true;
            }
        }
        false
    }
}

cut_between_rows!(ExceedsLimit);

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
            let longest = rest.0[i] * self.limit;
            let over = span.dot(span) - longest * longest;
            // No spring has the rest length zero.
            let over = if rest.0[i] > 0.0 { over } else { 0.0 };
            excess.0[i] = larger(over, excess.0[i]);
        }
    }
}
