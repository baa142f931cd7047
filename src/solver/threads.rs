//! Threads solved whole: every warp and weft line is corrected at once.
//!
//! The distance constraints along a line couple only neighbours, so that their matrix is
//! tridiagonal: `w_j + w_(j+1) + compliance` on the diagonal and `-w_(j+1) n_j . n_(j+1)` beside it.
//! One forward and one backward pass solve it, [`LANES`] lines side by side, and two such blocks in
//! turns: each step of a pass waits for the one before, and meanwhile the other block's is worked on. The compliance is the
//! spring's own, `1 / (k h^2)` (Macklin, Mueller and Chentanez 2016, XPBD, eq. 18; with drag, what a
//! force still moves in a substep stands for `h^2`), so that a thread
//! at rest carries its load with the stiffness asked for.

use super::isa::{Kernel, TransposingKernel};
use super::lanes::{Block, Block3, LANES, Soa, larger};
use super::lattice::{Family, Layout};
use super::state::Line;
use super::transpose::Transpose;

/// Least compliance of a constraint, relative to the inverse masses of its ends. A straight line
/// held at both ends has one constraint too many; this keeps its matrix far enough from singular
/// for f32, at a strain of the same size.
const LEAST_COMPLIANCE: f32 = 1e-5;
/// Least pivot \[1/kg\]: between two held particles nothing can move, whatever the residual.
const LEAST_PIVOT: f32 = 1e-12;
/// Least length of a spring \[m\]: a collapsed one has no direction and is left alone.
const LEAST_LENGTH: f32 = 1e-12;

/// Solves all warp threads, a column a lane.
pub(super) struct SolveWarp<'a> {
    pub layout: Layout,
    pub lines: Lines<'a>,
    pub x: &'a Soa,
    pub d: &'a mut Soa,
}

/// Solves all weft threads, a row a lane: [`LANES`] rows at a time are turned into a strip of columns
/// that stays in the nearest cache.
pub(super) struct SolveWeft<'a> {
    pub layout: Layout,
    pub lines: Lines<'a>,
    pub x: &'a Soa,
    pub d: &'a mut Soa,
    /// Positions of a strip, then its corrections.
    pub strip: &'a mut Soa,
}

/// What the threads of one direction are made of, in the layout whose rows they run across.
pub(super) struct Lines<'a> {
    pub layout: Layout,
    pub springs: &'a Family,
    pub reach: Reach,
    pub inverse_mass: &'a [f32],
    /// Room for the unknowns of two blocks of [`LANES`] threads.
    pub line: &'a mut Line,
}

/// Tells whether any spring was longer than its limit before it was corrected.
impl Kernel for SolveWarp<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        let mut excess = Block::ZERO;
        let mut column = 0;
        while column + LANES < self.layout.columns {
            self.solve::<2>(column, &mut excess);
            column += 2 * LANES;
        }
        if column < self.layout.columns {
            self.solve::<1>(column, &mut excess);
        }
        excess.largest() > 0.0
    }
}

impl SolveWarp<'_> {
    #[inline(always)]
    fn solve<const BLOCKS: usize>(&mut self, column: usize, excess: &mut Block) {
        let first = self.layout.slot(0, column);
        let mut ends = InPlace { x: self.x, d: self.d, first, stride: self.layout.stride };
        self.lines.eliminate::<BLOCKS>(column, &ends, excess);
        self.lines.substitute::<BLOCKS>(column, &mut ends);
    }
}

/// Tells the same as [`SolveWarp`].
impl TransposingKernel for SolveWeft<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self, transpose: impl Transpose) -> bool {
        let mut excess = Block::ZERO;
        let mut row = 0;
        while row + LANES < self.layout.rows {
            self.solve::<2>(transpose, row, &mut excess);
            row += 2 * LANES;
        }
        if row < self.layout.rows {
            self.solve::<1>(transpose, row, &mut excess);
        }
        excess.largest() > 0.0
    }
}

impl SolveWeft<'_> {
    #[inline(always)]
    fn solve<const BLOCKS: usize>(&mut self, t: impl Transpose, row: usize, excess: &mut Block) {
        let width = self.layout.columns.next_multiple_of(LANES) * LANES;
        for block in 0..BLOCKS {
            self.fill_strip(t, row + block * LANES, block * width);
        }
        let mut ends = Strip { places: self.strip, width };
        self.lines.eliminate::<BLOCKS>(row, &ends, excess);
        self.lines.substitute::<BLOCKS>(row, &mut ends);
        for block in 0..BLOCKS {
            self.add_strip(t, row + block * LANES, block * width);
        }
    }

    #[inline(always)]
    fn fill_strip(&mut self, t: impl Transpose, row: usize, first: usize) {
        for column in (0..self.layout.columns).step_by(LANES) {
            let (slot, to) = (self.layout.slot(row, column), first + column * LANES);
            let (x, d, strip) = (self.x, &*self.d, &mut *self.strip);
            fill_tile(t, &x.x, &d.x, slot, self.layout.stride, &mut strip.x, to);
            fill_tile(t, &x.y, &d.y, slot, self.layout.stride, &mut strip.y, to);
            fill_tile(t, &x.z, &d.z, slot, self.layout.stride, &mut strip.z, to);
        }
    }

    #[inline(always)]
    fn add_strip(&mut self, t: impl Transpose, row: usize, first: usize) {
        for column in (0..self.layout.columns).step_by(LANES) {
            let (slot, from) = (self.layout.slot(row, column), first + column * LANES);
            let (d, strip) = (&mut *self.d, &*self.strip);
            add_tile(t, &strip.x, from, &mut d.x, slot, self.layout.stride);
            add_tile(t, &strip.y, from, &mut d.y, slot, self.layout.stride);
            add_tile(t, &strip.z, from, &mut d.z, slot, self.layout.stride);
        }
    }
}

/// Writes the sums of two arrays in a tile to a strip.
#[inline(always)]
fn fill_tile(
    t: impl Transpose,
    x: &[f32],
    d: &[f32],
    slot: usize,
    stride: usize,
    strip: &mut [f32],
    at: usize,
) {
    let mut tile = [Block::ZERO; LANES];
    for (i, line) in tile.iter_mut().enumerate() {
        let (x, d) = (Block::load(x, slot + i * stride), Block::load(d, slot + i * stride));
        for j in 0..LANES {
            line.0[j] = x.0[j] + d.0[j];
        }
    }
    for (j, line) in t.tile(&tile).into_iter().enumerate() {
        line.store(strip, at + j * LANES);
    }
}

/// Adds a part of a strip to a tile.
#[inline(always)]
fn add_tile(
    t: impl Transpose,
    strip: &[f32],
    at: usize,
    d: &mut [f32],
    slot: usize,
    stride: usize,
) {
    let mut tile = [Block::ZERO; LANES];
    for (j, line) in tile.iter_mut().enumerate() {
        *line = Block::load(strip, at + j * LANES);
    }
    for (i, line) in t.tile(&tile).into_iter().enumerate() {
        let mut new = Block::load(d, slot + i * stride);
        for j in 0..LANES {
            new.0[j] += line.0[j];
        }
        new.store(d, slot + i * stride);
    }
}

/// Where the particles of blocks of [`LANES`] threads are, and where their corrections go.
trait Ends {
    /// Positions of a block's particles at a place along the threads.
    fn positions(&self, place: usize, block: usize) -> Block3;
    /// Takes their corrections.
    fn correct(&mut self, place: usize, block: usize, correction: Block3);
}

/// Rows of the sheet.
struct InPlace<'a> {
    x: &'a Soa,
    d: &'a mut Soa,
    first: usize,
    stride: usize,
}

impl Ends for InPlace<'_> {
    #[inline(always)]
    fn positions(&self, place: usize, block: usize) -> Block3 {
        Block3::load_sum(self.x, self.d, self.first + place * self.stride + block * LANES)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, block: usize, correction: Block3) {
        let slot = self.first + place * self.stride + block * LANES;
        let mut d = Block3::load(self.d, slot);
        for i in 0..LANES {
            d.set(i, d.at(i) + correction.at(i));
        }
        d.store(self.d, slot);
    }
}

/// Strips of columns, whose positions give way to their corrections.
struct Strip<'a> {
    places: &'a mut Soa,
    /// From a strip to the next.
    width: usize,
}

impl Ends for Strip<'_> {
    #[inline(always)]
    fn positions(&self, place: usize, block: usize) -> Block3 {
        Block3::load(self.places, block * self.width + place * LANES)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, block: usize, correction: Block3) {
        correction.store(self.places, block * self.width + place * LANES);
    }
}

impl Lines<'_> {
    /// Forward elimination: from place to place, each pivot from the one before.
    #[inline(always)]
    fn eliminate<const BLOCKS: usize>(
        &mut self,
        thread: usize,
        ends: &impl Ends,
        excess: &mut Block,
    ) {
        let mut x0 = [Block3::ZERO; BLOCKS];
        let mut w0 = [Block::ZERO; BLOCKS];
        let mut last = [Pivot::default(); BLOCKS];
        for block in 0..BLOCKS {
            x0[block] = ends.positions(0, block);
            w0[block] = self.inverse_masses(0, thread, block);
        }
        for place in 1..self.layout.rows {
            for block in 0..BLOCKS {
                let spring = self.layout.slot(place - 1, thread + block * LANES);
                let x1 = ends.positions(place, block);
                let w1 = self.inverse_masses(place, thread, block);
                let rest = Block::load(&self.springs.rest, spring);
                let factor = Block::load(&self.springs.compliance, spring);
                let (x, w) = ([&x0[block], &x1], [&w0[block], &w1]);
                let next = last[block].next(&self.reach, x, w, &rest, &factor, excess);
                next.store(self.line, ((place - 1) * BLOCKS + block) * LANES);
                (x0[block], w0[block], last[block]) = (x1, w1, next);
            }
        }
    }

    /// Back substitution: tensions from the last spring to the first, and the corrections of the
    /// particles between them.
    #[inline(always)]
    fn substitute<const BLOCKS: usize>(&mut self, thread: usize, ends: &mut impl Ends) {
        let mut tension = [Tension::default(); BLOCKS];
        for place in (1..self.layout.rows).rev() {
            for (block, tension) in tension.iter_mut().enumerate() {
                let pivot = Pivot::load(self.line, ((place - 1) * BLOCKS + block) * LANES);
                let w = self.inverse_masses(place, thread, block);
                ends.correct(place, block, tension.next(&pivot, &w));
            }
        }
        for (block, tension) in tension.iter().enumerate() {
            let w = self.inverse_masses(0, thread, block);
            ends.correct(0, block, tension.last(&w));
        }
    }

    #[inline(always)]
    fn inverse_masses(&self, place: usize, thread: usize, block: usize) -> Block {
        Block::load(self.inverse_mass, self.layout.slot(place, thread + block * LANES))
    }
}

/// How soft the springs are, and how long they may be.
#[derive(Clone, Copy)]
pub(super) struct Reach {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
}

/// One step of the elimination.
#[derive(Clone, Copy)]
pub(super) struct Pivot {
    direction: Block3,
    inverse: Block,
    residual: Block,
}

impl Default for Pivot {
    fn default() -> Self {
        Self { direction: Block3::ZERO, inverse: Block::ZERO, residual: Block::ZERO }
    }
}

impl Pivot {
    /// The step after this one, for springs between particles at `x` of inverse masses `w`. Notes by
    /// how much they exceed their limit; those without a rest length are none.
    #[inline(always)]
    pub fn next(
        &self,
        reach: &Reach,
        x: [&Block3; 2],
        w: [&Block; 2],
        rest: &Block,
        factor: &Block,
        excess: &mut Block,
    ) -> Self {
        let mut next = Self::default();
        for i in 0..LANES {
            let span = x[1].at(i) - x[0].at(i);
            // Not `Vec3::length`, whose square root may be a call.
            let length = span.dot(span).sqrt();
            let over = length - rest.0[i] * reach.limit;
            let over = if rest.0[i] > 0.0 { over } else { 0.0 };
            excess.0[i] = larger(over, excess.0[i]);
            let n = span * (1.0 / larger(length, LEAST_LENGTH));
            let diagonal = w[0].0[i] + w[1].0[i];
            // In this order the larger of the two is a number even where the first is NaN.
            let soft = larger(factor.0[i] * reach.compliance, diagonal * LEAST_COMPLIANCE);
            let beside = w[0].0[i] * n.dot(self.direction.at(i));
            let carried = beside * self.inverse.0[i];
            let pivot = larger(diagonal + soft - beside * carried, LEAST_PIVOT);
            next.direction.set(i, n);
            next.inverse.0[i] = 1.0 / pivot;
            next.residual.0[i] = length - rest.0[i] + carried * self.residual.0[i];
        }
        next
    }

    #[inline(always)]
    pub fn store(&self, line: &mut Line, at: usize) {
        self.direction.store(&mut line.direction, at);
        self.inverse.store(&mut line.inverse_pivot, at);
        self.residual.store(&mut line.residual, at);
    }

    #[inline(always)]
    pub fn load(line: &Line, at: usize) -> Self {
        Self {
            direction: Block3::load(&line.direction, at),
            inverse: Block::load(&line.inverse_pivot, at),
            residual: Block::load(&line.residual, at),
        }
    }
}

/// The pull of the springs that come after a place.
#[derive(Clone, Copy)]
pub(super) struct Tension {
    pull: Block3,
}

impl Default for Tension {
    fn default() -> Self {
        Self { pull: Block3::ZERO }
    }
}

impl Tension {
    /// Goes on to the springs before particles of inverse masses `w`; gives these their corrections.
    #[inline(always)]
    pub fn next(&mut self, pivot: &Pivot, w: &Block) -> Block3 {
        let mut pull = Block3::ZERO;
        let mut correction = Block3::ZERO;
        for i in 0..LANES {
            let n = pivot.direction.at(i);
            let beside = w.0[i] * n.dot(self.pull.at(i));
            let tension = (pivot.residual.0[i] + beside) * pivot.inverse.0[i];
            pull.set(i, n * tension);
            correction.set(i, (self.pull.at(i) - pull.at(i)) * w.0[i]);
        }
        self.pull = pull;
        correction
    }

    /// Corrections of the first particles.
    #[inline(always)]
    pub fn last(&self, w: &Block) -> Block3 {
        let mut correction = Block3::ZERO;
        for i in 0..LANES {
            correction.set(i, self.pull.at(i) * w.0[i]);
        }
        correction
    }
}
