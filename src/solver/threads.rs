//! Threads solved whole: every warp and weft line is corrected at once.
//!
//! The distance constraints along a line couple only neighbours, so that their matrix is
//! tridiagonal: `w_j + w_(j+1) + compliance` on the diagonal and `-w_(j+1) n_j . n_(j+1)` beside it.
//! One forward and one backward pass solve it, [`LANES`] lines side by side. The compliance is the
//! spring's own, `1 / (k h^2)` (Macklin, Mueller and Chentanez 2016, XPBD, eq. 18; with drag, what a
//! force still moves in a substep stands for `h^2`), so that a thread
//! at rest carries its load with the stiffness asked for.
//!
//! What is solved for is each tension over the spring's length, with each equation times that length: springs
//! then stand in it as they are, and none has to be divided by its length for a direction.

use super::isa::{Kernel, TransposingKernel};
use super::lanes::{Block, Block3, LANES, Soa, larger};
use super::lattice::{Family, Layout};
use super::state::Line;
use super::taut::{Threads, ease};
use super::transpose::Transpose;

/// Least compliance of a constraint, relative to the inverse masses of its ends. A straight line
/// held at both ends has one constraint too many; this keeps its matrix far enough from singular
/// for f32, at a strain of the same size.
const LEAST_COMPLIANCE: f32 = 1e-5;
/// Least pivot \[m2/kg\]: between two held particles nothing can move, whatever the residual, and a
/// collapsed spring has no direction and is left alone.
const LEAST_PIVOT: f32 = 1e-30;

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
    /// Room for the unknowns of [`LANES`] threads.
    pub line: &'a mut Line,
}

/// Tells whether any spring was longer than its limit before it was corrected.
impl Kernel for SolveWarp<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        let mut excess = Block::ZERO;
        for column in (0..self.layout.columns).step_by(LANES) {
            let first = self.layout.slot(0, column);
            let stride = self.layout.stride;
            let mut ends = InPlace { x: self.x, d: self.d, first, stride };
            self.lines.eliminate(column, &ends, &mut excess);
            self.lines.substitute(column, &mut ends);
        }
        excess.largest() > 0.0
    }
}

/// Tells the same as [`SolveWarp`].
impl TransposingKernel for SolveWeft<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self, transpose: impl Transpose) -> bool {
        let mut excess = Block::ZERO;
        for row in (0..self.layout.rows).step_by(LANES) {
            self.fill_strip(transpose, row);
            let mut ends = Strip(self.strip);
            self.lines.eliminate(row, &ends, &mut excess);
            self.lines.substitute(row, &mut ends);
            self.add_strip(transpose, row);
        }
        excess.largest() > 0.0
    }
}

impl SolveWeft<'_> {
    #[inline(always)]
    fn fill_strip(&mut self, t: impl Transpose, row: usize) {
        for column in (0..self.layout.columns).step_by(LANES) {
            let slot = self.layout.slot(row, column);
            let (x, d, strip) = (self.x, &*self.d, &mut *self.strip);
            fill_tile(t, &x.x, &d.x, slot, self.layout.stride, &mut strip.x, column * LANES);
            fill_tile(t, &x.y, &d.y, slot, self.layout.stride, &mut strip.y, column * LANES);
            fill_tile(t, &x.z, &d.z, slot, self.layout.stride, &mut strip.z, column * LANES);
        }
    }

    #[inline(always)]
    fn add_strip(&mut self, t: impl Transpose, row: usize) {
        for column in (0..self.layout.columns).step_by(LANES) {
            let slot = self.layout.slot(row, column);
            let (d, strip) = (&mut *self.d, &*self.strip);
            add_tile(t, &strip.x, column * LANES, &mut d.x, slot, self.layout.stride);
            add_tile(t, &strip.y, column * LANES, &mut d.y, slot, self.layout.stride);
            add_tile(t, &strip.z, column * LANES, &mut d.z, slot, self.layout.stride);
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

/// Where the particles of [`LANES`] threads are, and where their corrections go.
trait Ends {
    /// Positions of the particles at a place along the threads.
    fn positions(&self, place: usize) -> Block3;
    /// Takes their corrections.
    fn correct(&mut self, place: usize, correction: Block3);
    /// Takes more of them.
    fn correct_more(&mut self, place: usize, correction: Block3);
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
    fn positions(&self, place: usize) -> Block3 {
        Block3::load_sum(self.x, self.d, self.first + place * self.stride)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        let slot = self.first + place * self.stride;
        let mut d = Block3::load(self.d, slot);
        for i in 0..LANES {
            d.set(i, d.at(i) + correction.at(i));
        }
        d.store(self.d, slot);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, correction: Block3) {
        self.correct(place, correction);
    }
}

/// A strip of columns, whose positions give way to their corrections.
struct Strip<'a>(&'a mut Soa);

impl Ends for Strip<'_> {
    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        Block3::load(self.0, place * LANES)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        correction.store(self.0, place * LANES);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, correction: Block3) {
        let mut sum = Block3::load(self.0, place * LANES);
        for i in 0..LANES {
            sum.set(i, sum.at(i) + correction.at(i));
        }
        sum.store(self.0, place * LANES);
    }
}

impl Lines<'_> {
    /// Forward elimination: from place to place, each pivot from the one before.
    #[inline(always)]
    fn eliminate(&mut self, thread: usize, ends: &impl Ends, excess: &mut Block) {
        let mut x0 = ends.positions(0);
        let mut w0 = Block::load(self.inverse_mass, self.layout.slot(0, thread));
        let mut last = Pivot::default();
        for place in 1..self.layout.rows {
            let spring = self.layout.slot(place - 1, thread);
            let x1 = ends.positions(place);
            let w1 = Block::load(self.inverse_mass, self.layout.slot(place, thread));
            let rest = Block::load(&self.springs.rest, spring);
            let factor = Block::load(&self.springs.compliance, spring);
            let next = last.next(&self.reach, [&x0, &x1], [&w0, &w1], &rest, &factor, excess);
            next.store(self.line, (place - 1) * LANES);
            (x0, w0, last) = (x1, w1, next);
        }
    }

    /// Back substitution: tensions from the last spring to the first, and the corrections of the
    /// particles between them.
    #[inline(always)]
    fn substitute(&mut self, thread: usize, ends: &mut impl Ends) {
        let mut tension = Tension::default();
        for place in (1..self.layout.rows).rev() {
            let pivot = Pivot::load(self.line, (place - 1) * LANES);
            let w = Block::load(self.inverse_mass, self.layout.slot(place, thread));
            ends.correct(place, tension.next(&pivot, &w));
        }
        let w = Block::load(self.inverse_mass, self.layout.slot(0, thread));
        ends.correct(0, tension.last(&w));
        if tension.most.largest() > self.reach.steady {
            self.ease(thread, ends);
        }
    }

    /// Keeps taut threads from trembling.
    #[inline(always)]
    fn ease(&mut self, thread: usize, ends: &mut impl Ends) {
        let Self { layout, springs, inverse_mass, .. } = *self;
        ease(self.line, &mut Woven { layout, springs, inverse_mass, thread, ends });
    }
}

/// [`LANES`] threads of a lattice.
struct Woven<'a, E> {
    layout: Layout,
    springs: &'a Family,
    inverse_mass: &'a [f32],
    thread: usize,
    ends: &'a mut E,
}

impl<E: Ends> Threads for Woven<'_, E> {
    #[inline(always)]
    fn places(&self) -> usize {
        self.layout.rows
    }

    #[inline(always)]
    fn inverse_mass(&self, place: usize) -> Block {
        Block::load(self.inverse_mass, self.layout.slot(place, self.thread))
    }

    #[inline(always)]
    fn rest(&self, place: usize) -> Block {
        Block::load(&self.springs.rest, self.layout.slot(place, self.thread))
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, more: Block3) {
        self.ends.correct_more(place, more);
    }
}

/// How soft the springs are, and how long they may be.
#[derive(Clone, Copy)]
pub(super) struct Reach {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
    /// What a spring may move a particle by without its thread trembling \[m\].
    pub steady: f32,
}

/// One step of the elimination.
#[derive(Clone, Copy)]
pub(super) struct Pivot {
    /// From one end of the springs to the other, and how long that is \[m\].
    span: Block3,
    length: Block,
    /// 1 / pivot \[kg/m2\].
    inverse: Block,
    /// Length times excess length, and what the springs before add to it \[m2\].
    residual: Block,
}

impl Default for Pivot {
    fn default() -> Self {
        let none = Block::ZERO;
        Self { span: Block3::ZERO, length: none, inverse: none, residual: none }
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
            let square = span.dot(span);
            // Not `Vec3::length`, whose square root may be a call.
            let length = square.sqrt();
            let over = length - rest.0[i] * reach.limit;
            let over = if rest.0[i] > 0.0 { over } else { 0.0 };
            excess.0[i] = larger(over, excess.0[i]);
            let diagonal = w[0].0[i] + w[1].0[i];
            // In this order the larger of the two is a number even where the first is NaN.
            let soft = larger(factor.0[i] * reach.compliance, diagonal * LEAST_COMPLIANCE);
            let beside = w[0].0[i] * span.dot(self.span.at(i));
            let carried = beside * self.inverse.0[i];
            let pivot = larger(square * (diagonal + soft) - beside * carried, LEAST_PIVOT);
            next.span.set(i, span);
            next.length.0[i] = length;
            next.inverse.0[i] = 1.0 / pivot;
            next.residual.0[i] = length * (length - rest.0[i]) + carried * self.residual.0[i];
        }
        next
    }

    #[inline(always)]
    pub fn store(&self, line: &mut Line, at: usize) {
        self.span.store(&mut line.span, at);
        self.length.store(&mut line.length, at);
        self.inverse.store(&mut line.inverse_pivot, at);
        self.residual.store(&mut line.residual, at);
    }

    #[inline(always)]
    pub fn load(line: &Line, at: usize) -> Self {
        Self {
            span: Block3::load(&line.span, at),
            length: Block::load(&line.length, at),
            inverse: Block::load(&line.inverse_pivot, at),
            residual: Block::load(&line.residual, at),
        }
    }
}

/// The pull of the springs that come after a place.
#[derive(Clone, Copy)]
pub(super) struct Tension {
    pull: Block3,
    /// What a spring has moved a particle by so far, at most \[m\].
    pub most: Block,
}

impl Default for Tension {
    fn default() -> Self {
        Self { pull: Block3::ZERO, most: Block::ZERO }
    }
}

impl Tension {
    /// Goes on to the springs before particles of inverse masses `w`; gives these their corrections.
    #[inline(always)]
    pub fn next(&mut self, pivot: &Pivot, w: &Block) -> Block3 {
        let mut pull = Block3::ZERO;
        let mut correction = Block3::ZERO;
        for i in 0..LANES {
            let span = pivot.span.at(i);
            let beside = w.0[i] * span.dot(self.pull.at(i));
            let tension = (pivot.residual.0[i] + beside) * pivot.inverse.0[i];
            self.most.0[i] = larger(tension * pivot.length.0[i] * w.0[i], self.most.0[i]);
            pull.set(i, span * tension);
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
