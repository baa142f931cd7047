//! Shear of threads while corrections are carried on (`carry`): all springs across the cells corrected at once,
//! each from where the particles were before any was (Jacobi's iteration).
//!
//! The order in which springs are corrected one after the other gives what moves a direction, and sheets
//! gain energy by it once corrections are carried on: a sweep to and fro does not, and costs
//! twice as much. All at once has no order, and passes over the rows but once.

use bevy::math::Vec3;

use super::bands::{Band, Rooms, Seams, cut_between_rows};
use super::constraint::{LEAST_DIVISOR, LEAST_LENGTH};
use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, Part, PartMut, Soa, larger};
use super::lattice::Lattice;

/// Two springs lie in line at a particle, and each of all four may pull: a correction moves its ends by no
/// more than this part of what it would take alone.
const CROWD: f32 = 2.5;

/// How far shear springs are corrected.
#[derive(Clone, Copy)]
pub(super) struct ShearRule {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
    /// How many times [`CROWD`] the springs at a particle get in each other's way.
    pub crowd: f32,
}

impl ShearRule {
    /// How strongly a spring pulls for each metre of its length, as the correction of an end of inverse mass
    /// one \[kg\]: to its rest length, or to its limit where that is more.
    #[inline(always)]
    pub fn pull(&self, length: f32, rest: f32, factor: f32, inverse_masses: f32) -> f32 {
        let stiffest = larger(inverse_masses, LEAST_DIVISOR) * (CROWD * self.crowd);
        let divisor = larger(factor * self.compliance, stiffest);
        let (elastic, limited) = (length - rest, length - rest * self.limit);
        // The larger of two fractions, and but one division.
        let is_limited = limited * divisor > elastic * stiffest;
        let (over, by) = if is_limited { (limited, stiffest) } else { (elastic, divisor) };
        if rest > 0.0 { over / (by * length) } else { 0.0 }
    }
}

/// Corrects the shear springs of a lattice.
pub(super) struct CorrectShear<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    pub inverse_mass: &'a [f32],
    pub rule: ShearRule,
    pub x: &'a Soa,
    pub d: PartMut<'a>,
    /// Displacements on both sides of the cuts, before any is corrected.
    pub seams: &'a Seams,
    pub rooms: &'a Rooms<RowPulls>,
}

/// Pulls of the springs from one row to the next, by column from [`LANES`] on.
#[derive(Clone, Debug)]
pub(super) struct RowPulls {
    /// Of those to the next column.
    right: Soa,
    /// Of those to the column before.
    left: Soa,
}

impl RowPulls {
    /// Room for rows of so many columns.
    pub fn new(columns: usize) -> Self {
        let len = columns.next_multiple_of(LANES) + 2 * LANES;
        Self { right: Soa::zeros(len), left: Soa::zeros(len) }
    }
}

impl Kernel for CorrectShear<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let mut pulls = self.rooms.take();
        pulls.right.clear();
        pulls.left.clear();
        if rows.start > 0 {
            self.pull_from_above(&mut pulls, rows.start);
        }
        for row in rows.clone() {
            // What is below the last row has been corrected by now, perhaps.
            let below =
                (row + 1 == rows.end && rows.end < layout.rows).then(|| self.seams.row(rows.end));
            // The pull before a block is gone from its place once the block before has been there.
            let mut before = Vec3::ZERO;
            for column in (0..layout.columns).step_by(LANES) {
                self.correct(&mut pulls, [row, column], below, &mut before);
            }
        }
    }
}

cut_between_rows!(CorrectShear, d);

impl CorrectShear<'_> {
    /// Works out the pulls between the row before the band and its first.
    #[inline(always)]
    fn pull_from_above(&self, pulls: &mut RowPulls, first: usize) {
        let (above, below) = (self.seams.row(first - 1), self.seams.row(first));
        for column in (0..self.lattice.layout.columns).step_by(LANES) {
            let [right, left] = self.pulls(first - 1, column, &above, &below);
            right.store(&mut pulls.right, LANES + column);
            left.store(&mut pulls.left, LANES + column);
        }
    }

    /// Corrects a block of a row, of which those before are corrected already: nothing looks at them any
    /// more. `below` is the next row, where it is not of this band.
    #[inline(always)]
    fn correct(
        &mut self,
        pulls: &mut RowPulls,
        [row, column]: [usize; 2],
        below: Option<Part<'_>>,
        before: &mut Vec3,
    ) {
        let (slot, place) = (self.lattice.layout.slot(row, column), LANES + column);
        let mut above_right = Block3::load(&pulls.right, place - 1);
        let above_left = Block3::load(&pulls.left, place + 1);
        above_right.set(0, *before);
        *before = pulls.right.get(place + LANES - 1);
        let own = self.d.part();
        let [right, left] = self.pulls(row, column, &own, &below.unwrap_or(own));
        let w = Block::load(self.inverse_mass, slot);
        let mut d = Block3::load(&self.d, slot);
        for i in 0..LANES {
            let pull = right.at(i) + left.at(i) - above_right.at(i) - above_left.at(i);
            d.set(i, d.at(i) + pull * w.0[i]);
        }
        d.store(&mut self.d, slot);
        right.store(&mut pulls.right, place);
        left.store(&mut pulls.left, place);
    }

    /// Pulls on a block of the springs to the next row, to the right and to the left, from the displacements of
    /// both rows.
    #[inline(always)]
    fn pulls(&self, row: usize, column: usize, own: &Part<'_>, next: &Part<'_>) -> [Block3; 2] {
        let slot = self.lattice.layout.slot(row, column);
        let below = slot + self.lattice.layout.stride;
        let diagonal = &self.lattice.diagonal;
        let rest = Block::load(&diagonal.rest, slot);
        let factor = Block::load(&diagonal.compliance, slot);
        let right = self.pull([slot, below + 1], [own, next], &rest, &factor);
        let rest = Block::load(&self.lattice.antidiagonal_rest, slot - 1);
        let factor = Block::load(&diagonal.compliance, slot - 1);
        let left = self.pull([slot, below - 1], [own, next], &rest, &factor);
        [right, left]
    }

    /// Pulls of springs between particles from `p` and from `q`, on the first of them.
    #[inline(always)]
    fn pull(
        &self,
        [p, q]: [usize; 2],
        [dp, dq]: [&Part<'_>; 2],
        rest: &Block,
        factor: &Block,
    ) -> Block3 {
        let (xp, xq) = (Block3::load_sum(self.x, dp, p), Block3::load_sum(self.x, dq, q));
        let (wp, wq) = (Block::load(self.inverse_mass, p), Block::load(self.inverse_mass, q));
        let mut pull = Block3::ZERO;
        for i in 0..LANES {
            let span = xq.at(i) - xp.at(i);
            let length = larger(span.dot(span).sqrt(), LEAST_LENGTH);
            let strength = self.rule.pull(length, rest.0[i], factor.0[i], wp.0[i] + wq.0[i]);
            pull.set(i, span * strength);
        }
        pull
    }
}
