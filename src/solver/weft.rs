//! Weft threads: [`LANES`] rows at a time are turned into a strip of columns that stays in the nearest cache.

use super::bands::{Band, Cut, CutAt, Rooms};
use super::isa::{Isa, TransposingKernel};
use super::lanes::{Block, Block3, LANES, PartMut, Slots, SlotsMut, Soa};
use super::lattice::{Family, Layout};
use super::threads::{Ends, Lines, Reach, Room};
use super::transpose::Transpose;

/// Solves all weft threads, a row a lane.
pub(super) struct SolveWeft<'a> {
    pub band: Band,
    /// The transposed layout, and the springs and inverse masses in it.
    pub lines: Layout,
    pub springs: &'a Family,
    pub inverse_mass: &'a [f32],
    pub reach: Reach,
    pub x: &'a Soa,
    pub d: PartMut<'a>,
    pub rooms: &'a Rooms<Room>,
}

/// Tells whether any spring was longer than its limit before it was corrected.
impl TransposingKernel for SolveWeft<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self, transpose: impl Transpose) -> bool {
        let Self { band, lines, springs, inverse_mass, reach, x, mut d, rooms } = self;
        let mut room = rooms.take();
        let Room { strip, line } = &mut *room;
        let mut lines = Lines { layout: lines, springs, reach, inverse_mass, line };
        let mut excess = Block::ZERO;
        for row in band.rows.step_by(LANES) {
            fill_strip(transpose, band.layout, row, x, &d, strip);
            lines.solve(row, &mut Strip(strip), &mut excess);
            add_strip(transpose, band.layout, row, strip, &mut d);
        }
        excess.largest() > 0.0
    }
}

impl Cut for SolveWeft<'_> {
    type Output = bool;

    fn band(&self) -> &Band {
        &self.band
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let (d, d_below) = self.d.cut(self.band.slot(row));
        let (above, below) = self.band.cut(row);
        (Self { band: above, d, ..self }, Self { band: below, d: d_below, ..self })
    }

    fn run(self, isa: Isa) -> bool {
        isa.run_transposing(self)
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

#[inline(always)]
fn fill_strip(
    t: impl Transpose,
    layout: Layout,
    row: usize,
    x: &Soa,
    d: &PartMut<'_>,
    strip: &mut Soa,
) {
    for column in (0..layout.columns).step_by(LANES) {
        let slot = layout.slot(row, column);
        let ([dx, dy, dz], own, at) = (d.axes(), slot - d.first(), column * LANES);
        fill_tile(t, [&x.x, dx], [slot, own], layout.stride, &mut strip.x, at);
        fill_tile(t, [&x.y, dy], [slot, own], layout.stride, &mut strip.y, at);
        fill_tile(t, [&x.z, dz], [slot, own], layout.stride, &mut strip.z, at);
    }
}

#[inline(always)]
fn add_strip(t: impl Transpose, layout: Layout, row: usize, strip: &Soa, d: &mut PartMut<'_>) {
    let first = d.first();
    let [dx, dy, dz] = d.axes_mut();
    for column in (0..layout.columns).step_by(LANES) {
        let (own, at) = (layout.slot(row, column) - first, column * LANES);
        add_tile(t, &strip.x, at, dx, own, layout.stride);
        add_tile(t, &strip.y, at, dy, own, layout.stride);
        add_tile(t, &strip.z, at, dz, own, layout.stride);
    }
}

/// Writes the sums of two arrays in a tile to a strip. Each has its own place for the first.
#[inline(always)]
fn fill_tile(
    t: impl Transpose,
    [x, d]: [&[f32]; 2],
    [from_x, from_d]: [usize; 2],
    stride: usize,
    strip: &mut [f32],
    at: usize,
) {
    let mut tile = [Block::ZERO; LANES];
    for (i, line) in tile.iter_mut().enumerate() {
        let (x, d) = (Block::load(x, from_x + i * stride), Block::load(d, from_d + i * stride));
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
