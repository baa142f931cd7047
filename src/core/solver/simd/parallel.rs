//! Bands of rows: a large cloth is cut, so that the cores share the work.
//!
//! A stage is a kernel over rows. Of a large cloth it is cut in two between rows, with what each half writes, and
//! so are the halves, down to bands; those run side by side in rayon's pool, which the application may
//! set up. Where the cuts are depends on the sheet alone, and what bands find out is put together in their order:
//! bits are the same on any number of cores. A kernel that looks at rows next to its own looks at what no other writes
//! meanwhile, or at a copy.

use core::ops::Range;
use std::sync::{Mutex, MutexGuard, TryLockError};

use crate::solver::settings::Stretching;
use crate::solver::simd::block::larger;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::{Part, Soa};

/// Particles of a cloth at least that is cut: fewer are done sooner than handed over.
const LEAST_CUT: usize = 12_000;
/// Particles at least of a sheet of whole threads that is cut. Warp is solved by columns, all else by rows, so that half of its particles
/// change cores twice in a substep.
const LEAST_WOVEN: usize = 40_000;
/// Particles of a band at least.
const LEAST_BAND: usize = 4_096;
/// Bands at most. Each has room of its own.
const MOST: usize = 16;

/// Some rows of a sheet that are worked on one after the other, or are to be cut further.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    pub layout: Layout,
    pub rows: Range<usize>,
    /// Rows from cut to cut: whole strips.
    each: usize,
    /// Whether bands are shared out; else one follows the other.
    pub shared: bool,
}

impl Band {
    /// All rows, to be cut into bands where they are many.
    pub fn all(layout: Layout) -> Self {
        let Layout { rows, columns, .. } = layout;
        if layout.particles() < LEAST_CUT {
            return Self::uncut(layout);
        }
        let enough = LEAST_BAND.div_ceil(columns);
        let each = rows.div_ceil(MOST).max(enough).next_multiple_of(LANES);
        Self { layout, rows: 0..rows, each, shared: true }
    }

    /// All rows in one piece.
    pub fn uncut(layout: Layout) -> Self {
        let each = layout.rows.next_multiple_of(LANES).max(LANES);
        Self { layout, rows: 0..layout.rows, each, shared: false }
    }

    /// How many bands it is cut into.
    pub fn count(&self) -> usize {
        self.rows.len().div_ceil(self.each)
    }

    /// Where it is cut next, if it is.
    pub fn middle(&self) -> Option<usize> {
        let count = self.count();
        (count > 1).then(|| self.rows.start + count / 2 * self.each)
    }

    /// The slots of its pages: all of a mesh, padding included.
    pub fn slots(&self) -> Range<usize> {
        let Self { layout, rows, .. } = self;
        layout.slot(rows.start, 0)..layout.slot(rows.end, 0)
    }

    /// The rows before one, and from it on.
    pub fn cut(self, row: usize) -> (Self, Self) {
        let (above, below) = (self.rows.start..row, row..self.rows.end);
        (Self { rows: above, ..self }, Self { rows: below, ..self })
    }

    /// The slot of the first particle of a row.
    pub fn slot(&self, row: usize) -> usize {
        self.layout.slot(row, 0)
    }
}

/// How a cloth is cut.
#[derive(Clone, Debug)]
pub(crate) struct Bands {
    /// Between its rows.
    pub rows: Band,
    /// Between its columns, in the transposed layout, whose rows they are.
    pub columns: Band,
    /// Between its rows, even where there is but one core: for sums that depend on where the cuts are.
    pub sums: Band,
}

impl Bands {
    /// Whether cores can share a sheet, or else a mesh, to any profit.
    pub fn pays(layout: Layout, form: Stretching, is_sheet: bool) -> bool {
        let is_woven = is_sheet && form == Stretching::ImplicitThreads;
        layout.particles() >= if is_woven { LEAST_WOVEN } else { LEAST_CUT }
    }

    /// Whether bands are shared out; else one follows the other.
    pub fn are_shared(&self) -> bool {
        self.sums.shared
    }

    /// For all cores, or for one.
    pub fn new(layout: Layout, shared: bool) -> Self {
        let cut = if shared { Band::all } else { Band::uncut };
        let (rows, columns) = (cut(layout), cut(layout.transposed()));
        Self { rows, columns, sums: Band { shared, ..Band::all(layout) } }
    }

    /// Bands at most, of rows or of columns.
    pub fn most(&self) -> usize {
        self.rows.count().max(self.columns.count())
    }
}

/// Copies of the rows on both sides of each cut.
#[derive(Clone, Debug)]
pub(crate) struct Seams {
    band: Band,
    /// From one copy to the next: a row, with a block before and after it.
    width: usize,
    rows: Soa,
}

impl Seams {
    /// Room for the cuts of a sheet.
    pub fn new(band: Band) -> Self {
        let width = band.layout.stride + 2 * LANES;
        let cuts = band.count().saturating_sub(1);
        Self { rows: Soa::zeros(2 * cuts * width), width, band }
    }

    /// Copies the rows as they are.
    pub fn copy(&mut self, from: &Soa) {
        let Band { each, ref rows, .. } = self.band;
        for cut in (rows.start..rows.end).step_by(each).skip(1) {
            for row in [cut - 1, cut] {
                let (to, first) = (self.place(row), self.first(row));
                let axes = [&mut self.rows.x, &mut self.rows.y, &mut self.rows.z];
                for (axis, from) in axes.into_iter().zip([&from.x, &from.y, &from.z]) {
                    axis[to..to + self.width].copy_from_slice(&from[first..first + self.width]);
                }
            }
        }
    }

    /// A row next to a cut, as it was.
    #[inline(always)]
    pub fn row(&self, row: usize) -> Part<'_> {
        let at = self.place(row);
        let copy = at..at + self.width;
        let Soa { x, y, z } = &self.rows;
        Part { first: self.first(row), axes: [&x[copy.clone()], &y[copy.clone()], &z[copy]] }
    }

    fn first(&self, row: usize) -> usize {
        self.band.slot(row) - LANES
    }

    /// Where the copy of a row begins.
    fn place(&self, row: usize) -> usize {
        // The last row before a cut comes before the first one after it.
        let each = self.band.each;
        let is_before = usize::from((row + 1).is_multiple_of(each));
        (2 * ((row + 1) / each) - 1 - is_before) * self.width
    }
}

/// Room to work in, as much as there are bands. A band takes the first that is free, which a core has used last.
#[derive(Debug)]
pub(crate) struct Workspaces<T>(Vec<Mutex<T>>);

impl<T> Workspaces<T> {
    /// Room for so many bands.
    pub fn new(bands: usize, make: impl Fn() -> T) -> Self {
        Self((0..bands.max(1)).map(|_| Mutex::new(make())).collect())
    }

    /// Takes a room that is free.
    pub fn take(&self) -> MutexGuard<'_, T> {
        loop {
            for room in &self.0 {
                match room.try_lock() {
                    Ok(room) => return room,
                    // What is in there has no meaning between two bands.
                    Err(TryLockError::Poisoned(room)) => return room.into_inner(),
                    Err(TryLockError::WouldBlock) => {}
                }
            }
        }
    }
}

impl<T: Clone> Clone for Workspaces<T> {
    fn clone(&self) -> Self {
        Self::new(self.0.len(), || self.take().clone())
    }
}

/// A kernel that can be cut in two: between rows, or between the domains of a mesh.
pub(crate) trait Cut: Sized + Send {
    /// The result for a band.
    type Output: Merge;
    /// The row or the domain where it is cut next, if it is.
    fn middle(&self) -> Option<usize>;
    /// Whether its parts are shared out; else one follows the other.
    fn is_shared(&self) -> bool;
    /// The same for what comes before the middle, and from it on.
    fn cut(self, middle: usize) -> (Self, Self);
    /// Works on all of it.
    fn run(self, isa: Isa) -> Self::Output;
}

/// Makes a kernel with a `band` one that can be cut, with these of its fields. What else it has, both halves share.
macro_rules! cut_between_rows {
    ($kernel:ident $(, $part:ident)*) => {
        $crate::solver::simd::parallel::cut_between_rows!(@ $kernel, Kernel, run $(, $part)*);
    };
    (transposing $kernel:ident $(, $part:ident)*) => {
        $crate::solver::simd::parallel::cut_between_rows!(
            @ $kernel, TransposingKernel, run_transposing $(, $part)*
        );
    };
    (@ $kernel:ident, $trait:ident, $run:ident $(, $part:ident)*) => {
        impl $crate::solver::simd::parallel::Cut for $kernel<'_> {
            type Output = <Self as $crate::solver::simd::isa::$trait>::Output;

            fn middle(&self) -> Option<usize> {
                self.band.middle()
            }

            fn is_shared(&self) -> bool {
                self.band.shared
            }

            fn cut(self, row: usize) -> (Self, Self) {
                $(let $part = $crate::solver::simd::slots::CutAt::cut(self.$part, self.band.slot(row));)*
                let (above, below) = self.band.cut(row);
                (
                    Self { band: above, $($part: $part.0,)* ..self },
                    Self { band: below, $($part: $part.1,)* ..self },
                )
            }

            fn run(self, isa: $crate::solver::simd::isa::Isa) -> Self::Output {
                isa.$run(self)
            }
        }
    };
}

pub(crate) use cut_between_rows;

/// Results of bands, which can be put together.
pub(crate) trait Merge: Send {
    /// The result of a band together with those below it.
    fn merge(self, below: Self) -> Self;
}

impl Merge for () {
    fn merge(self, (): ()) {}
}

impl Merge for bool {
    fn merge(self, below: Self) -> Self {
        self | below
    }
}

/// A number of which the larger of two is what both come to.
pub(crate) struct Largest(pub f32);

impl Merge for Largest {
    fn merge(self, below: Self) -> Self {
        Self(larger(self.0, below.0))
    }
}

/// Calls `act` where [`run`] shares out its bands, as each of its runs would else be handed over there.
pub(crate) fn inside<R: Send>(act: impl FnOnce() -> R + Send) -> R {
    rayon::join(act, || ()).0
}

/// Runs a kernel on all of its rows.
pub(crate) fn run<K: Cut>(isa: Isa, kernel: K) -> K::Output {
    let Some(middle) = kernel.middle() else { return kernel.run(isa) };
    let shared = kernel.is_shared();
    let (above, below) = kernel.cut(middle);
    let (above, below) = if shared {
        rayon::join(|| run(isa, above), || run(isa, below))
    } else {
        (run(isa, above), run(isa, below))
    };
    above.merge(below)
}
