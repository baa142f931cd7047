//! Warp threads: a column a lane, as the rows lie.
//!
//! Cores cannot share the rows of a large sheet by columns. There each works on a band of columns and puts what it
//! comes to apart, from where it is put back by rows.

use crate::solver::constraints::threads::shifts::ShiftsMut;
use crate::solver::constraints::threads::tridiagonal::{Ends, Reach};
use crate::solver::constraints::threads::{Lines, OnColliders, ThreadWorkspace, touch_nothing};
use crate::solver::contact::{Contacts, Normals};
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::{Band, Cut, Workspaces};
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};
use crate::solver::topology::lattice::Family;

/// Solves all warp threads.
pub(crate) struct SolveWarp<'a> {
    pub layout: Layout,
    pub lines: Lines<'a>,
    pub x: &'a Soa,
    pub d: &'a mut Soa,
    pub contacts: Option<Contacts<'a>>,
}

/// Tells whether any spring was longer than its limit before it was corrected.
impl Kernel for SolveWarp<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self) -> bool {
        let mut excess = Block::ZERO;
        for column in (0..self.layout.columns).step_by(LANES) {
            let (first, count) = (self.layout.slot(0, column), self.layout.blocks_down());
            let hop = self.layout.stride / LANES;
            let mut ends = InPlace {
                x: Blocks3::new(self.x, first, count),
                d: Blocks3Mut::new(self.d, first, count),
                hop,
            };
            match &mut self.contacts {
                Some(contacts) if contacts.normals.touch(first / LANES, count, hop) => {
                    let mut ends = OnColliders {
                        ends,
                        hops: [hop, hop],
                        normals: Blocks3::new(&contacts.normals.normal, first, count),
                        slips: Blocks::new(&contacts.normals.slip, first, count),
                        loads: contacts.load.blocks(first, count),
                    };
                    self.lines.solve(column, &mut ends, &mut excess);
                }
                _ => self.lines.solve(column, &mut ends, &mut excess),
            }
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
    touch_nothing!();

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
pub(crate) struct SolveWarpApart<'a> {
    /// In the transposed layout, whose rows are the columns.
    pub band: Band,
    pub layout: Layout,
    pub springs: &'a Family,
    pub inverse_mass: &'a [f32],
    pub reach: Reach,
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// The corrected displacements: bundle by bundle of [`LANES`] columns, and in each row by row.
    pub apart: PartMut<'a>,
    /// What particles lie on, what that bears so far, and where what it bears in the end is put apart as well.
    pub contacts: Option<(&'a Normals, &'a Array, ValuesMut<'a>)>,
    pub shifts: Option<ShiftsMut<'a>>,
    pub rooms: &'a Workspaces<ThreadWorkspace>,
}

/// Where a bundle of columns begins, and each of its rows.
pub(super) fn place_apart(layout: Layout, row: usize, column: usize) -> usize {
    column * layout.rows + row * LANES
}

/// Tells the same as [`SolveWarp`].
impl Kernel for SolveWarpApart<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self {
            band,
            layout,
            springs,
            inverse_mass,
            reach,
            x,
            d,
            mut apart,
            mut contacts,
            shifts,
            rooms,
        } = self;
        let line = &mut rooms.take().line;
        let mut lines = Lines { layout, springs, reach, inverse_mass, line, shifts };
        let mut excess = Block::ZERO;
        for column in band.rows.step_by(LANES) {
            let (first, count) = (layout.slot(0, column), layout.blocks_down());
            let hop = layout.stride / LANES;
            let put = place_apart(layout, 0, column);
            let mut ends = Apart {
                x: Blocks3::new(x, first, count),
                d: Blocks3::new(d, first, count),
                hop,
                to: Blocks3Mut::new(&mut apart, put, layout.rows),
            };
            if let Some((_, load, apart)) = &mut contacts {
                let (load, mut apart) =
                    (Blocks::new(load, first, count), apart.blocks(put, layout.rows));
                for row in 0..layout.rows {
                    apart.set(row, load.at(row * hop));
                }
            }
            match &mut contacts {
                Some((normals, _, apart)) if normals.touch(first / LANES, count, hop) => {
                    let mut ends = OnColliders {
                        ends,
                        hops: [hop, 1],
                        normals: Blocks3::new(&normals.normal, first, count),
                        slips: Blocks::new(&normals.slip, first, count),
                        loads: apart.blocks(put, layout.rows),
                    };
                    lines.solve(column, &mut ends, &mut excess);
                }
                _ => lines.solve(column, &mut ends, &mut excess),
            }
        }
        excess.largest() > 0.0
    }
}

impl<'a> Cut for SolveWarpApart<'a> {
    type Output = bool;

    fn middle(&self) -> Option<usize> {
        self.band.middle()
    }

    fn is_shared(&self) -> bool {
        self.band.shared
    }

    fn cut(self, column: usize) -> (Self, Self) {
        let place = place_apart(self.layout, 0, column);
        let (apart, apart_after) = self.apart.cut(place);
        let cut = |(normals, load, apart): (&'a Normals, &'a Array, ValuesMut<'a>)| {
            let (apart, after) = apart.cut(place);
            ((normals, load, apart), (normals, load, after))
        };
        let (contacts, contacts_after) = self.contacts.map(cut).unzip();
        let (shifts, shifts_after) = self.shifts.cut(place);
        let (before, after) = self.band.cut(column);
        let after = Self {
            band: after,
            apart: apart_after,
            contacts: contacts_after,
            shifts: shifts_after,
            ..self
        };
        (Self { band: before, apart, contacts, shifts, ..self }, after)
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
    touch_nothing!();

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
pub(crate) struct PutBack<'a> {
    pub band: Band,
    pub apart: &'a Soa,
    pub d: PartMut<'a>,
    /// Loads of contact, from the copy, and the array that they are put into.
    pub loads: Option<(&'a Array, ValuesMut<'a>)>,
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
            if let Some((apart, to)) = &mut self.loads {
                let apart = Blocks::new(apart, 0, blocks * layout.rows);
                let mut to = to.blocks(layout.slot(row, 0), blocks);
                for block in 0..blocks {
                    to.set(block, apart.at(block * layout.rows + row));
                }
            }
        }
    }
}

impl<'a> Cut for PutBack<'a> {
    type Output = ();

    fn middle(&self) -> Option<usize> {
        self.band.middle()
    }

    fn is_shared(&self) -> bool {
        self.band.shared
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let slot = self.band.slot(row);
        let (d, d_below) = self.d.cut(slot);
        let cut = |(apart, to): (&'a Array, ValuesMut<'a>)| {
            let (to, below) = to.cut(slot);
            ((apart, to), (apart, below))
        };
        let (loads, loads_below) = self.loads.map(cut).unzip();
        let (above, below) = self.band.cut(row);
        let below = Self { band: below, d: d_below, loads: loads_below, ..self };
        (Self { band: above, d, loads, ..self }, below)
    }

    fn run(self, isa: Isa) {
        isa.run(self);
    }
}
