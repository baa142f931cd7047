//! Diagonals that cores share: each puts what it comes to apart, from where it is put back by rows.

use core::ops::Range;

use super::{Bias, Bundle, Diagonals, OnBias, To};
use crate::solver::constraints::threads::ThreadWorkspace;
use crate::solver::constraints::threads::shifts::ShiftsMut;
use crate::solver::contact::Normals;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Cut, Workspaces, cut_between_rows};
use crate::solver::simd::slots::{CutAt, Slots, SlotsMut};
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};

/// Solves some of the diagonals that go one way.
pub(crate) struct SolveBiasApart<'a> {
    pub bias: Bias<'a>,
    pub bundles: Range<usize>,
    /// Bundles of a share at least: there are no more shares than rooms.
    pub least: usize,
    pub d: &'a Soa,
    /// The corrected displacements, bundle by bundle, and in each row by row.
    pub apart: PartMut<'a>,
    /// What particles lie on, what that bears so far, and where what it bears in the end is put apart as well.
    pub contacts: Option<(&'a Normals, &'a Array, ValuesMut<'a>)>,
    pub shifts: Option<ShiftsMut<'a>>,
    pub rooms: &'a Workspaces<ThreadWorkspace>,
}

impl Kernel for SolveBiasApart<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bias, bundles, d, mut apart, mut contacts, mut shifts, rooms, .. } = self;
        let line = &mut rooms.take().line;
        for bundle in &bias.diagonals.bundles[bundles] {
            let strands = bias.strands(bundle);
            let (first, apart) = (bundle.before, apart.reborrow());
            if let Some((_, load, loads)) = &mut contacts {
                for place in 0..bundle.places {
                    loads.set(first + place * LANES, &Block::load(load, strands.slot(place)));
                }
            }
            match &mut contacts {
                Some((normals, _, loads)) if strands.touch(normals) => {
                    let to = Apart { d, first, apart, loads: Some(loads.reborrow()) };
                    OnBias::<_, true> { strands, x: bias.x, normals: Some(normals), to }.solve(
                        &bias.law,
                        line,
                        &mut shifts,
                    );
                }
                _ => {
                    let to = Apart { d, first, apart, loads: None };
                    OnBias::<_, false> { strands, x: bias.x, normals: None, to }.solve(
                        &bias.law,
                        line,
                        &mut shifts,
                    );
                }
            }
        }
    }
}

impl<'a> Cut for SolveBiasApart<'a> {
    type Output = ();

    fn middle(&self) -> Option<usize> {
        let Range { start, end } = self.bundles;
        (end - start >= 2 * self.least).then_some(usize::midpoint(start, end))
    }

    fn is_shared(&self) -> bool {
        true
    }

    fn cut(self, middle: usize) -> (Self, Self) {
        let place = self.bias.diagonals.bundles[middle].before;
        let (apart, apart_after) = self.apart.cut(place);
        let cut = |(normals, load, loads): (&'a Normals, &'a Array, ValuesMut<'a>)| {
            let (loads, after) = loads.cut(place);
            ((normals, load, loads), (normals, load, after))
        };
        let (contacts, contacts_after) = self.contacts.map(cut).unzip();
        let (shifts, shifts_after) = self.shifts.cut(place);
        let (before, after) = (self.bundles.start..middle, middle..self.bundles.end);
        let after = Self {
            bundles: after,
            apart: apart_after,
            contacts: contacts_after,
            shifts: shifts_after,
            ..self
        };
        (Self { bundles: before, apart, contacts, shifts, ..self }, after)
    }

    fn run(self, isa: Isa) {
        isa.run(self);
    }
}

/// Room of their own.
struct Apart<'a> {
    d: &'a Soa,
    /// Where the bundle's begins.
    first: usize,
    apart: PartMut<'a>,
    loads: Option<ValuesMut<'a>>,
}

impl To for Apart<'_> {
    #[inline(always)]
    fn displacements(&self, slot: usize) -> Block3 {
        Block3::load(self.d, slot)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, slot: usize, correction: &Block3) {
        let corrected = Block3::load(self.d, slot).plus(correction);
        corrected.store(&mut self.apart, self.first + place * LANES);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, _: usize, more: &Block3) {
        let at = self.first + place * LANES;
        Block3::load(&self.apart, at).plus(more).store(&mut self.apart, at);
    }

    #[inline(always)]
    fn load(&mut self, place: usize, _: usize, load: &Block) {
        if let Some(loads) = &mut self.loads {
            loads.add(self.first + place * LANES, load);
        }
    }
}

/// Puts displacements back that [`SolveBiasApart`] has put apart.
pub(crate) struct PutDiagonalsBack<'a> {
    pub band: Band,
    pub diagonals: &'a Diagonals,
    pub apart: &'a Soa,
    pub d: PartMut<'a>,
    /// Loads of contact, from the copy, and the array that they are put into.
    pub loads: Option<LoadsBack<'a>>,
}

/// Loads, and where they belong.
pub(crate) struct LoadsBack<'a> {
    pub apart: &'a Array,
    pub to: ValuesMut<'a>,
}

impl CutAt for LoadsBack<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (to, below) = self.to.cut(slot);
        (Self { to, ..self }, Self { to: below, ..self })
    }
}

impl Kernel for PutDiagonalsBack<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { band, diagonals, apart, mut d, mut loads } = self;
        for row in band.rows.clone() {
            for bundle in &diagonals.bundles {
                let Some(InRow { column, from, count }) = bundle.in_row(row, diagonals) else {
                    continue;
                };
                let (slot, from) = (band.layout.slot(row, column), from..from + count);
                let at = slot - d.first();
                let [x, y, z] = d.axes_mut();
                for (to, apart) in [(x, &apart.x), (y, &apart.y), (z, &apart.z)] {
                    to[at..at + count].copy_from_slice(&apart[from.clone()]);
                }
                if let Some(LoadsBack { apart, to }) = &mut loads {
                    to.put(slot, &apart[from]);
                }
            }
        }
    }
}

cut_between_rows!(PutDiagonalsBack, d, loads);

/// Particles of a row that are in a bundle.
struct InRow {
    column: usize,
    /// Where what they came to is.
    from: usize,
    count: usize,
}

impl Bundle {
    /// The particles of a row: without what is beyond the row.
    fn in_row(&self, row: usize, diagonals: &Diagonals) -> Option<InRow> {
        let place = row.checked_sub(self.row).filter(|place| *place < self.places)?;
        let column = self.column + diagonals.way.step() * place as isize;
        let beyond = (-column).max(0);
        let count = (diagonals.layout.columns as isize - column).min(LANES as isize) - beyond;
        Some(InRow {
            column: (column + beyond) as usize,
            from: self.before + place * LANES + beyond as usize,
            count: usize::try_from(count).ok()?,
        })
    }
}
