//! Weft threads: [`LANES`] rows at a time are turned into a strip of columns that stays in the nearest cache.

use crate::solver::constraints::threads::shifts::ShiftsMut;
use crate::solver::constraints::threads::tridiagonal::{Ends, Reach};
use crate::solver::constraints::threads::warp::place_apart;
use crate::solver::constraints::threads::{Lines, OnColliders, ThreadWorkspace, touch_nothing};
use crate::solver::contact::Contacts;
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, BlocksMut};
use crate::solver::simd::isa::{Isa, TransposingKernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, Cut, Workspaces};
use crate::solver::simd::slots::{CutAt, Slots, SlotsMut};
use crate::solver::simd::soa::{PartMut, Soa};
use crate::solver::simd::transpose::{Tile, Transpose};
use crate::solver::topology::lattice::Family;

/// Solves all weft threads, a row a lane.
pub(crate) struct SolveWeft<'a> {
    pub band: Band,
    /// The transposed layout, and the springs and inverse masses in it.
    pub lines: Layout,
    pub springs: &'a Family,
    pub inverse_mass: &'a [f32],
    pub reach: Reach,
    pub x: &'a Soa,
    pub d: PartMut<'a>,
    pub contacts: Option<Contacts<'a>>,
    pub shifts: Option<ShiftsMut<'a>>,
    pub rooms: &'a Workspaces<ThreadWorkspace>,
}

/// Tells whether any spring was longer than its limit before it was corrected.
impl TransposingKernel for SolveWeft<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self, transpose: impl Transpose) -> bool {
        let Self {
            band,
            lines,
            springs,
            inverse_mass,
            reach,
            x,
            mut d,
            mut contacts,
            shifts,
            rooms,
        } = self;
        let mut room = rooms.take();
        let ThreadWorkspace { strip, line, normals, slip, load } = &mut *room;
        let mut lines = Lines { layout: lines, springs, reach, inverse_mass, line, shifts };
        let mut excess = Block::ZERO;
        for row in band.rows.step_by(LANES) {
            fill_strip(transpose, band.layout, row, x, &d, strip);
            let mut ends = Strip(Blocks3Mut::new(strip, 0, band.layout.columns));
            let tiles = Tiles::new(band.layout, row);
            match &mut contacts {
                Some(contacts) if contacts.normals.touch(tiles.first / LANES, tiles.count, 1) => {
                    fill_normals(transpose, &tiles, &contacts.normals.normal, normals);
                    fill_axis(transpose, &tiles, &contacts.normals.slip, slip);
                    load.fill(0.0);
                    let mut ends = OnColliders {
                        ends,
                        hops: [1, 1],
                        normals: Blocks3::new(normals, 0, band.layout.columns),
                        slips: Blocks::new(slip, 0, band.layout.columns),
                        loads: BlocksMut::new(load, 0, band.layout.columns),
                    };
                    lines.solve(row, &mut ends, &mut excess);
                    let to = contacts.load.blocks(tiles.first, tiles.count);
                    add_axis(transpose, &tiles, load, to);
                }
                _ => lines.solve(row, &mut ends, &mut excess),
            }
            add_strip(transpose, band.layout, row, strip, &mut d);
        }
        excess.largest() > 0.0
    }
}

impl Cut for SolveWeft<'_> {
    type Output = bool;

    fn middle(&self) -> Option<usize> {
        self.band.middle()
    }

    fn is_shared(&self) -> bool {
        self.band.shared
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let slot = self.band.slot(row);
        let (d, d_below) = self.d.cut(slot);
        let (contacts, contacts_below) = self.contacts.cut(slot);
        let (shifts, shifts_below) = self.shifts.cut(place_apart(self.lines, 0, row));
        let (above, below) = self.band.cut(row);
        let below = Self {
            band: below,
            d: d_below,
            contacts: contacts_below,
            shifts: shifts_below,
            ..self
        };
        (Self { band: above, d, contacts, shifts, ..self }, below)
    }

    fn run(self, isa: Isa) -> bool {
        isa.run_transposing(self)
    }
}

/// A strip of columns, whose positions give way to their corrections.
struct Strip<'a>(Blocks3Mut<'a>);

impl Ends for Strip<'_> {
    touch_nothing!();

    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        self.0.at(place)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        self.0.set(place, correction);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, correction: Block3) {
        self.0.add(place, &correction);
    }
}

/// Writes the sums of positions and displacements of [`LANES`] rows to a strip.
#[inline(always)]
fn fill_strip(
    t: impl Transpose,
    layout: Layout,
    row: usize,
    x: &Soa,
    d: &PartMut<'_>,
    strip: &mut Soa,
) {
    let tiles = Tiles::new(layout, row);
    let own = tiles.first - d.first();
    let ([dx, dy, dz], to) = (d.axes(), strip.axes_mut());
    for ((x, d), to) in [(&*x.x, dx), (&*x.y, dy), (&*x.z, dz)].into_iter().zip(to) {
        let x = Blocks::new(x, tiles.first, tiles.count);
        let d = Blocks::new(d, own, tiles.count);
        let to = BlocksMut::new(to, 0, tiles.across * LANES);
        let mut sums = Sums { x, d, to, hop: tiles.hop, block: 0 };
        for block in 0..tiles.across {
            sums.block = block;
            t.tile(&mut sums);
        }
    }
}

/// Writes the normals of [`LANES`] rows to a strip.
#[inline(always)]
fn fill_normals(t: impl Transpose, tiles: &Tiles, from: &Soa, strip: &mut Soa) {
    for (from, to) in [&from.x, &from.y, &from.z].into_iter().zip(strip.axes_mut()) {
        fill_axis(t, tiles, from, to);
    }
}

/// Writes the numbers of [`LANES`] rows to a strip.
#[inline(always)]
fn fill_axis(t: impl Transpose, tiles: &Tiles, from: &[f32], to: &mut [f32]) {
    let from = Blocks::new(from, tiles.first, tiles.count);
    let to = BlocksMut::new(to, 0, tiles.across * LANES);
    let mut numbers = Numbers { from, to, hop: tiles.hop, block: 0 };
    for block in 0..tiles.across {
        numbers.block = block;
        t.tile(&mut numbers);
    }
}

/// Adds a strip to displacements.
#[inline(always)]
fn add_strip(t: impl Transpose, layout: Layout, row: usize, strip: &Soa, d: &mut PartMut<'_>) {
    let tiles = Tiles::new(layout, row);
    let own = tiles.first - d.first();
    for (strip, d) in strip.axes().into_iter().zip(d.axes_mut()) {
        add_axis(t, &tiles, strip, BlocksMut::new(d, own, tiles.count));
    }
}

/// Adds one coordinate of a strip to that of [`LANES`] rows.
#[inline(always)]
fn add_axis(t: impl Transpose, tiles: &Tiles, strip: &[f32], to: BlocksMut<'_>) {
    let strip = Blocks::new(strip, 0, tiles.across * LANES);
    let mut columns = Columns { strip, to, hop: tiles.hop, block: 0 };
    for block in 0..tiles.across {
        columns.block = block;
        t.tile(&mut columns);
    }
}

/// A tile of positions and displacements, whose sums go to a strip.
struct Sums<'a> {
    x: Blocks<'a>,
    d: Blocks<'a>,
    to: BlocksMut<'a>,
    hop: usize,
    block: usize,
}

impl Tile for Sums<'_> {
    #[inline(always)]
    fn row(&self, row: usize) -> Block {
        let at = self.block + row * self.hop;
        self.x.at(at).plus(&self.d.at(at))
    }

    #[inline(always)]
    fn put(&mut self, column: usize, rows: Block) {
        self.to.set(self.block * LANES + column, rows);
    }
}

/// A tile of numbers that go to a strip.
struct Numbers<'a> {
    from: Blocks<'a>,
    to: BlocksMut<'a>,
    hop: usize,
    block: usize,
}

impl Tile for Numbers<'_> {
    #[inline(always)]
    fn row(&self, row: usize) -> Block {
        self.from.at(self.block + row * self.hop)
    }

    #[inline(always)]
    fn put(&mut self, column: usize, rows: Block) {
        self.to.set(self.block * LANES + column, rows);
    }
}

/// A tile of a strip that is added to rows.
struct Columns<'a> {
    strip: Blocks<'a>,
    to: BlocksMut<'a>,
    hop: usize,
    block: usize,
}

impl Tile for Columns<'_> {
    #[inline(always)]
    fn row(&self, row: usize) -> Block {
        self.strip.at(self.block * LANES + row)
    }

    #[inline(always)]
    fn put(&mut self, column: usize, rows: Block) {
        self.to.add(self.block + column * self.hop, &rows);
    }
}

/// [`LANES`] rows in tiles of as many columns.
struct Tiles {
    /// The slot where they begin.
    first: usize,
    across: usize,
    /// Blocks from one row to the next.
    hop: usize,
    /// Blocks from the first to the last.
    count: usize,
}

impl Tiles {
    #[inline(always)]
    fn new(layout: Layout, row: usize) -> Self {
        let (across, hop) = (layout.blocks_across(), layout.stride / LANES);
        Self { first: layout.slot(row, 0), across, hop, count: (LANES - 1) * hop + across }
    }
}
