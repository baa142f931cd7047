//! Diagonals that cores share: each puts what it comes to apart, from where it is added by rows.

use core::ops::Range;

use super::{Bias, Bundle, Diagonals, OnBias, To};
use crate::solver::constraints::threads::ThreadWorkspace;
use crate::solver::contact::Normals;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Cut, Workspaces, cut_between_rows};
use crate::solver::simd::slots::{CutAt, SlotsMut};
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};

/// Bundles of a core's share at least.
const LEAST_SHARE: usize = 4;

/// Solves some of the diagonals that go one way.
pub(crate) struct SolveBiasApart<'a> {
    pub bias: Bias<'a>,
    pub bundles: Range<usize>,
    pub d: &'a Soa,
    /// Corrections, bundle by bundle, and in each row by row.
    pub corrections: PartMut<'a>,
    /// What particles lie on, and what that bears of those, as the corrections are.
    pub contacts: Option<(&'a Normals, ValuesMut<'a>)>,
    pub rooms: &'a Workspaces<ThreadWorkspace>,
}

impl Kernel for SolveBiasApart<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bias, bundles, d, mut corrections, mut contacts, rooms } = self;
        let line = &mut rooms.take().line;
        for bundle in &bias.diagonals.bundles[bundles] {
            let strands = bias.strands(bundle);
            let first = bundle.before;
            let corrections = corrections.reborrow();
            match &mut contacts {
                Some((normals, loads)) if strands.touch(normals) => {
                    let to = Apart { d, first, corrections, loads: Some(loads.reborrow()) };
                    OnBias::<_, true> { strands, x: bias.x, normals: Some(normals), to }
                        .solve(&bias.law, line);
                }
                rest => {
                    if let Some((_, loads)) = rest {
                        for place in 0..bundle.places {
                            loads.set(first + place * LANES, &Block::ZERO);
                        }
                    }
                    let to = Apart { d, first, corrections, loads: None };
                    OnBias::<_, false> { strands, x: bias.x, normals: None, to }
                        .solve(&bias.law, line);
                }
            }
        }
    }
}

impl<'a> Cut for SolveBiasApart<'a> {
    type Output = ();

    fn middle(&self) -> Option<usize> {
        let Range { start, end } = self.bundles;
        (end - start >= 2 * LEAST_SHARE).then_some(usize::midpoint(start, end))
    }

    fn is_shared(&self) -> bool {
        true
    }

    fn cut(self, middle: usize) -> (Self, Self) {
        let place = self.bias.diagonals.bundles[middle].before;
        let (corrections, corrections_after) = self.corrections.cut(place);
        let cut = |(normals, loads): (&'a Normals, ValuesMut<'a>)| {
            let (loads, after) = loads.cut(place);
            ((normals, loads), (normals, after))
        };
        let (contacts, contacts_after) = self.contacts.map(cut).unzip();
        let (before, after) = (self.bundles.start..middle, middle..self.bundles.end);
        let after = Self {
            bundles: after,
            corrections: corrections_after,
            contacts: contacts_after,
            ..self
        };
        (Self { bundles: before, corrections, contacts, ..self }, after)
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
    corrections: PartMut<'a>,
    loads: Option<ValuesMut<'a>>,
}

impl To for Apart<'_> {
    #[inline(always)]
    fn displacements(&self, slot: usize) -> Block3 {
        Block3::load(self.d, slot)
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, _: usize, correction: &Block3) {
        correction.store(&mut self.corrections, self.first + place * LANES);
    }

    #[inline(always)]
    fn load(&mut self, place: usize, _: usize, load: &Block) {
        if let Some(loads) = &mut self.loads {
            loads.set(self.first + place * LANES, load);
        }
    }
}

/// Adds what [`SolveBiasApart`] has put apart.
pub(crate) struct AddBack<'a> {
    pub band: Band,
    pub diagonals: &'a Diagonals,
    pub corrections: &'a Soa,
    pub d: PartMut<'a>,
    /// Loads of contact, and the array that they are added to.
    pub loads: Option<AddLoads<'a>>,
}

/// Loads that are added to others.
pub(crate) struct AddLoads<'a> {
    pub from: &'a Array,
    pub to: ValuesMut<'a>,
}

impl CutAt for AddLoads<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (to, below) = self.to.cut(slot);
        (Self { from: self.from, to }, Self { from: self.from, to: below })
    }
}

impl Kernel for AddBack<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { band, diagonals, corrections, mut d, mut loads } = self;
        let columns = band.layout.columns as isize;
        for row in band.rows.clone() {
            for bundle in &diagonals.bundles {
                let Some((column, from)) = bundle.in_row(row, diagonals) else { continue };
                // What is beyond the row is padding.
                let first = (-column).max(0);
                let count = ((columns - column).min(LANES as isize) - first).max(0) as usize;
                let from = from + first as usize;
                let slot = band.layout.slot(row, 0) + (column + first) as usize;
                let at = slot - crate::solver::simd::slots::Slots::first(&d);
                let [x, y, z] = d.axes_mut();
                for (to, by) in [(x, &corrections.x), (y, &corrections.y), (z, &corrections.z)] {
                    let by = &by[from..from + count];
                    to[at..at + count].iter_mut().zip(by).for_each(|(to, by)| *to += by);
                }
                if let Some(AddLoads { from: loads, to }) = &mut loads {
                    to.add_some(slot, &loads[from..from + count]);
                }
            }
        }
    }
}

cut_between_rows!(AddBack, d, loads);

impl Bundle {
    /// The column of the first diagonal in a row, and where what it came to there is.
    fn in_row(&self, row: usize, diagonals: &Diagonals) -> Option<(isize, usize)> {
        let place = row.checked_sub(self.row).filter(|place| *place < self.places)?;
        let column = self.column + diagonals.way.step() * place as isize;
        Some((column, self.before + place * LANES))
    }
}
