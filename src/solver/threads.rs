//! Threads solved whole: every warp and weft line is corrected at once.
//!
//! The distance constraints along a line couple only neighbours, so that their matrix is
//! tridiagonal: `w_j + w_(j+1) + compliance` on the diagonal and `-w_(j+1) n_j . n_(j+1)` beside it.
//! One forward and one backward pass solve it, [`LANES`] lines side by side. The compliance is the
//! spring's own, `1 / (k h^2)` (Macklin, Mueller and Chentanez 2016, XPBD, eq. 18), so that a thread
//! at rest carries its load with the stiffness asked for.

use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, Soa, larger};
use super::lattice::{Family, Layout};
use super::state::Line;

/// Least compliance of a constraint, relative to the inverse masses of its ends. A straight line
/// held at both ends has one constraint too many; this keeps its matrix far enough from singular
/// for f32, at a strain of the same size.
const LEAST_COMPLIANCE: f32 = 1e-5;
/// Least pivot [1/kg]: between two held particles nothing can move, whatever the residual.
const LEAST_PIVOT: f32 = 1e-12;
/// Least length of a spring [m]: a collapsed one has no direction and is left alone.
const LEAST_LENGTH: f32 = 1e-12;

/// What becomes of the corrections of a line.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Apply {
    /// They replace the positions, to be carried back to the other layout.
    Overwrite,
    /// They are added to positions, and over `h` to velocities.
    Add {
        /// 1 / substep [1/s].
        rate: f32,
    },
}

/// Solves all lines of a layout: from row to row, a column a lane.
pub(super) struct SolveThreads<'a> {
    pub layout: Layout,
    pub springs: &'a Family,
    /// `1 / (k h^2)` of a spring of shape factor one [1/kg].
    pub compliance: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    /// Ignored where corrections overwrite.
    pub v: Option<&'a mut Soa>,
    pub line: &'a mut Line,
    pub apply: Apply,
}

impl Kernel for SolveThreads<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for column in (0..self.layout.columns).step_by(LANES) {
            self.eliminate(column);
            self.substitute(column);
        }
    }
}

impl SolveThreads<'_> {
    /// Forward elimination: row by row, each pivot from the one before.
    #[inline(always)]
    fn eliminate(&mut self, column: usize) {
        let first = self.layout.slot(0, column);
        let mut x0 = Block3::load(self.x, first);
        let mut w0 = Block::load(self.inverse_mass, first);
        let mut last = Pivot::default();
        for row in 1..self.layout.rows {
            let (spring, end) = (self.layout.slot(row - 1, column), self.layout.slot(row, column));
            let x1 = Block3::load(self.x, end);
            let w1 = Block::load(self.inverse_mass, end);
            let rest = Block::load(&self.springs.rest, spring);
            let factor = Block::load(&self.springs.compliance, spring);
            let mut next = Pivot::default();
            for i in 0..LANES {
                let d = x1.at(i) - x0.at(i);
                // Not `Vec3::length`, whose square root may be a call.
                let length = d.dot(d).sqrt();
                let n = d * (1.0 / larger(length, LEAST_LENGTH));
                let diagonal = w0.0[i] + w1.0[i];
                // In this order the larger of the two is a number even where the first is NaN.
                let soft = larger(factor.0[i] * self.compliance, diagonal * LEAST_COMPLIANCE);
                let beside = w0.0[i] * n.dot(last.direction.at(i));
                let carried = beside * last.inverse.0[i];
                let pivot = larger(diagonal + soft - beside * carried, LEAST_PIVOT);
                next.direction.set(i, n);
                next.inverse.0[i] = 1.0 / pivot;
                next.residual.0[i] = length - rest.0[i] + carried * last.residual.0[i];
            }
            let at = (row - 1) * LANES;
            next.direction.store(&mut self.line.direction, at);
            next.inverse.store(&mut self.line.inverse_pivot, at);
            next.residual.store(&mut self.line.residual, at);
            (x0, w0, last) = (x1, w1, next);
        }
    }

    /// Back substitution: tensions from the last spring to the first, and the corrections of the
    /// particles between them.
    #[inline(always)]
    fn substitute(&mut self, column: usize) {
        let mut next_pull = Block3::ZERO;
        for row in (1..self.layout.rows).rev() {
            let at = (row - 1) * LANES;
            let n = Block3::load(&self.line.direction, at);
            let inverse = Block::load(&self.line.inverse_pivot, at);
            let residual = Block::load(&self.line.residual, at);
            let slot = self.layout.slot(row, column);
            let w = Block::load(self.inverse_mass, slot);
            let mut pull = Block3::ZERO;
            let mut correction = Block3::ZERO;
            for i in 0..LANES {
                let beside = w.0[i] * n.at(i).dot(next_pull.at(i));
                let tension = (residual.0[i] + beside) * inverse.0[i];
                pull.set(i, n.at(i) * tension);
                correction.set(i, (next_pull.at(i) - pull.at(i)) * w.0[i]);
            }
            self.write(slot, correction);
            next_pull = pull;
        }
        let slot = self.layout.slot(0, column);
        let w = Block::load(self.inverse_mass, slot);
        let mut correction = Block3::ZERO;
        for i in 0..LANES {
            correction.set(i, next_pull.at(i) * w.0[i]);
        }
        self.write(slot, correction);
    }

    #[inline(always)]
    fn write(&mut self, slot: usize, correction: Block3) {
        let (Apply::Add { rate }, Some(v)) = (self.apply, self.v.as_deref_mut()) else {
            correction.store(self.x, slot);
            return;
        };
        let (mut new_x, mut new_v) = (Block3::load(self.x, slot), Block3::load(v, slot));
        for i in 0..LANES {
            new_x.set(i, new_x.at(i) + correction.at(i));
            new_v.set(i, new_v.at(i) + correction.at(i) * rate);
        }
        new_x.store(self.x, slot);
        new_v.store(v, slot);
    }
}

/// One step of the elimination.
#[derive(Clone, Copy)]
struct Pivot {
    direction: Block3,
    inverse: Block,
    residual: Block,
}

impl Default for Pivot {
    fn default() -> Self {
        Self { direction: Block3::ZERO, inverse: Block::ZERO, residual: Block::ZERO }
    }
}

/// Writes `from` with rows and columns exchanged.
pub(super) struct Transpose<'a> {
    /// Layout of `from`.
    pub layout: Layout,
    pub from: &'a Soa,
    pub to: &'a mut Soa,
}

impl Kernel for Transpose<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (from, to) = (self.from, self.to);
        for (from, to) in [(&from.x, &mut to.x), (&from.y, &mut to.y), (&from.z, &mut to.z)] {
            for row in (0..self.layout.rows).step_by(LANES) {
                for column in (0..self.layout.columns).step_by(LANES) {
                    transpose_tile(self.layout, row, column, from, to);
                }
            }
        }
    }
}

#[inline(always)]
fn transpose_tile(layout: Layout, row: usize, column: usize, from: &[f32], to: &mut [f32]) {
    let target = layout.transposed();
    let tile = load_transposed(layout, row, column, from);
    for (j, line) in tile.iter().enumerate() {
        line.store(to, target.slot(column + j, row));
    }
}

/// A tile of 16 x 16, read row by row, as its columns.
#[inline(always)]
fn load_transposed(layout: Layout, row: usize, column: usize, from: &[f32]) -> [Block; LANES] {
    let mut tile = [Block::ZERO; LANES];
    for (i, line) in tile.iter_mut().enumerate() {
        *line = Block::load(from, layout.slot(row + i, column));
    }
    let mut out = [Block::ZERO; LANES];
    for i in 0..LANES {
        for j in 0..LANES {
            out[j].0[i] = tile[i].0[j];
        }
    }
    out
}

/// Adds corrections that lie transposed to positions, and over the substep to velocities.
pub(super) struct AddTransposed<'a> {
    /// Layout of `corrections`.
    pub layout: Layout,
    pub corrections: &'a Soa,
    pub x: &'a mut Soa,
    pub v: &'a mut Soa,
    /// 1 / substep [1/s].
    pub rate: f32,
}

impl Kernel for AddTransposed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let d = self.corrections;
        let (x, v) = (self.x, self.v);
        for (d, x, v) in [
            (&d.x, &mut x.x, &mut v.x),
            (&d.y, &mut x.y, &mut v.y),
            (&d.z, &mut x.z, &mut v.z),
        ] {
            for row in (0..self.layout.rows).step_by(LANES) {
                for column in (0..self.layout.columns).step_by(LANES) {
                    add_tile(self.layout, row, column, d, x, v, self.rate);
                }
            }
        }
    }
}

#[inline(always)]
fn add_tile(
    layout: Layout,
    row: usize,
    column: usize,
    corrections: &[f32],
    x: &mut [f32],
    v: &mut [f32],
    rate: f32,
) {
    let target = layout.transposed();
    let tile = load_transposed(layout, row, column, corrections);
    for (j, correction) in tile.iter().enumerate() {
        let slot = target.slot(column + j, row);
        let (mut new_x, mut new_v) = (Block::load(x, slot), Block::load(v, slot));
        for i in 0..LANES {
            new_x.0[i] += correction.0[i];
            new_v.0[i] += correction.0[i] * rate;
        }
        new_x.store(x, slot);
        new_v.store(v, slot);
    }
}
