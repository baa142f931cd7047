//! Warp threads: a column a lane, as the rows lie.
//!
//! Cores cannot share the rows of a large sheet by columns. There each works on a band of columns and puts what it
//! comes to apart, from where it is put back by rows.

use super::bands::{Band, Cut, CutAt, Rooms, cut_between_rows};
use super::isa::{Isa, Kernel};
use super::lanes::{Block, Block3, Blocks3, Blocks3Mut, LANES, PartMut, Soa};
use super::lattice::{Family, Layout};
use super::threads::{Ends, Lines, Reach, Room};

/// Solves all warp threads.
pub(super) struct SolveWarp<'a> {
    pub layout: Layout,
    pub lines: Lines<'a>,
    pub x: &'a Soa,
    pub d: &'a mut Soa,
}

/// Tells whether any spring was longer than its limit before it was corrected.
impl Kernel for SolveWarp<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        let mut excess = Block::ZERO;
        for column in (0..self.layout.columns).step_by(LANES) {
            let (first, count) = (self.layout.slot(0, column), self.layout.blocks_down());
            let mut ends = InPlace {
                x: Blocks3::new(self.x, first, count),
                d: Blocks3Mut::new(self.d, first, count),
                hop: self.layout.stride / LANES,
            };
            self.lines.solve(column, &mut ends, &mut excess);
        }
        excess.largest() > 0.0
    }
}

/// Rows of the sheet.
struct InPlace<'a> {
    x: Blocks3<'a>,
    d: Blocks3Mut<'a>,
    /// Blocks from one row to the next.
    hop: usize,
}

impl Ends for InPlace<'_> {
    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        self.x.at(place * self.hop).plus(&self.d.at(place * self.hop))
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        self.d.add(place * self.hop, &correction);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, correction: Block3) {
        self.correct(place, correction);
    }
}

/// Solves the warp threads of a band of columns.
pub(super) struct SolveWarpApart<'a> {
    /// In the transposed layout, whose rows are the columns.
    pub band: Band,
    pub layout: Layout,
    pub springs: &'a Family,
    pub inverse_mass: &'a [f32],
    pub reach: Reach,
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// What displacements become: bundle by bundle of [`LANES`] columns, and in each row by row.
    pub apart: PartMut<'a>,
    pub rooms: &'a Rooms<Room>,
}

/// Where a bundle of columns begins, and each of its rows.
fn place_apart(layout: Layout, row: usize, column: usize) -> usize {
    column * layout.rows + row * LANES
}

/// Tells the same as [`SolveWarp`].
impl Kernel for SolveWarpApart<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { band, layout, springs, inverse_mass, reach, x, d, mut apart, rooms } = self;
        let line = &mut rooms.take().line;
        let mut lines = Lines { layout, springs, reach, inverse_mass, line };
        let mut excess = Block::ZERO;
        for column in band.rows.step_by(LANES) {
            let (first, count) = (layout.slot(0, column), layout.blocks_down());
            let mut ends = Apart {
                x: Blocks3::new(x, first, count),
                d: Blocks3::new(d, first, count),
                hop: layout.stride / LANES,
                to: Blocks3Mut::new(&mut apart, place_apart(layout, 0, column), layout.rows),
            };
            lines.solve(column, &mut ends, &mut excess);
        }
        excess.largest() > 0.0
    }
}

impl Cut for SolveWarpApart<'_> {
    type Output = bool;

    fn band(&self) -> &Band {
        &self.band
    }

    fn cut(self, column: usize) -> (Self, Self) {
        let (apart, apart_after) = self.apart.cut(place_apart(self.layout, 0, column));
        let (before, after) = self.band.cut(column);
        let after = Self { band: after, apart: apart_after, ..self };
        (Self { band: before, apart, ..self }, after)
    }

    fn run(self, isa: Isa) -> bool {
        isa.run(self)
    }
}

/// Rows of the sheet, whose displacements are put apart.
struct Apart<'a> {
    x: Blocks3<'a>,
    d: Blocks3<'a>,
    /// Blocks from one row to the next.
    hop: usize,
    to: Blocks3Mut<'a>,
}

impl Ends for Apart<'_> {
    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        self.x.at(place * self.hop).plus(&self.d.at(place * self.hop))
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        self.to.set(place, self.d.at(place * self.hop).plus(&correction));
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, correction: Block3) {
        self.to.add(place, &correction);
    }
}

/// Puts displacements back that [`SolveWarpApart`] has put apart.
pub(super) struct PutBack<'a> {
    pub band: Band,
    pub apart: &'a Soa,
    pub d: PartMut<'a>,
}

impl Kernel for PutBack<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band;
        let blocks = layout.blocks_across();
        // A bundle is as many blocks as there are rows.
        let apart = Blocks3::new(self.apart, 0, blocks * layout.rows);
        for row in rows {
            let mut d = Blocks3Mut::new(&mut self.d, layout.slot(row, 0), blocks);
            for block in 0..blocks {
                d.set(block, apart.at(block * layout.rows + row));
            }
        }
    }
}

cut_between_rows!(PutBack, d);
