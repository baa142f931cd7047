//! Shifts of the springs of a sheet: of its weft and warp threads, and of its diagonals where these are solved whole.
//!
//! Springs stand as they are solved: bundle by bundle of [`LANES`] lines, and in each place by place.

use super::{Row, Shifting, Shifts, are_within};
use crate::solver::constraints::threads::bias::Diagonals;
use crate::solver::simd::block::{Block, Block3, Blocks, BlocksMut};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::parallel::Cut;
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{Soa, ValuesMut};
use crate::solver::topology::lattice::Lattice;

/// Largest shift, in rest lengths. With three times as much a sheet of few substeps trembles at the corners that it hangs from.
const MOST: f32 = 0.1;

/// The shifts of all springs of a sheet: of weft, warp, and of the diagonals that go either way.
#[derive(Clone, Debug)]
pub(crate) struct SheetShifts(pub [LineShifts; 4]);

/// The shifts of lines that go one way.
#[derive(Clone, Debug)]
pub(crate) struct LineShifts {
    shifts: Shifts,
    bundles: Vec<LineBundle>,
    hops: Hops,
}

/// [`LANES`] lines side by side.
#[derive(Clone, Copy, Debug)]
struct LineBundle {
    /// Where its shifts begin.
    entry: usize,
    /// Particles of a line.
    places: usize,
    /// The slot of the first line's first particle, and where its first spring stands.
    first: usize,
    spring: usize,
}

/// Slots from one line to the next, from particle to particle of a line, and from spring to spring.
#[derive(Clone, Copy, Debug)]
struct Hops {
    line: usize,
    particle: usize,
    spring: usize,
}

/// The springs of some lines: their rest lengths, and one over their shape factors.
#[derive(Clone, Copy)]
pub(crate) struct LineSprings<'a> {
    rest: &'a [f32],
    factor: &'a [f32],
}

impl SheetShifts {
    /// Makes the shifts of a sheet, all of them zero.
    pub fn none(layout: Layout) -> Self {
        let [right, left] = Diagonals::both(layout);
        let transposed = layout.transposed();
        let weft = Hops { line: layout.stride, particle: 1, spring: transposed.stride };
        let warp = Hops { line: 1, particle: layout.stride, spring: layout.stride };
        Self([
            LineShifts::of_threads(transposed, weft, |thread| layout.slot(thread, 0)),
            LineShifts::of_threads(layout, warp, |thread| layout.slot(0, thread)),
            LineShifts::of_diagonals(&right),
            LineShifts::of_diagonals(&left),
        ])
    }

    /// Takes all shifts away.
    pub fn clear(&mut self) {
        self.0.iter_mut().for_each(LineShifts::clear);
    }

    /// Collects all shifts, to be kept \[m\].
    pub fn kept(&self) -> Vec<f32> {
        self.0.iter().flat_map(|lines| lines.shifts.by.iter().copied()).collect()
    }

    /// Puts back shifts that were kept. Leaves all as they are where the springs of the lattice cannot be shifted so, and tells.
    pub fn put_back(&mut self, lattice: &Lattice, kept: &[f32]) -> bool {
        if !self.can_be(lattice, kept) {
            return false;
        }
        let mut left = kept;
        for lines in &mut self.0 {
            let (own, others) = left.split_at(lines.shifts.by.len());
            lines.shifts.by.copy_from_slice(own);
            left = others;
        }
        true
    }

    /// Whether the springs of the lattice can be shifted so.
    pub fn can_be(&self, lattice: &Lattice, kept: &[f32]) -> bool {
        let mut left = kept;
        let all = self.0.iter().zip(LineSprings::of(lattice)).all(|(lines, springs)| {
            let Some((own, others)) = left.split_at_checked(lines.shifts.by.len()) else {
                return false;
            };
            left = others;
            are_within(own, lines.by_entry(springs.rest), MOST)
        });
        all && left.is_empty()
    }
}

impl<'a> LineSprings<'a> {
    /// Springs of a lattice, in the order of [`SheetShifts`].
    pub fn of(lattice: &'a Lattice) -> [Self; 4] {
        let Lattice { weft_transposed: weft, warp, diagonal, antidiagonal_rest, .. } = lattice;
        let factor = &*diagonal.compliance;
        [
            Self { rest: &weft.rest, factor: &weft.compliance },
            Self { rest: &warp.rest, factor: &warp.compliance },
            Self { rest: &diagonal.rest, factor },
            Self { rest: antidiagonal_rest, factor },
        ]
    }
}

impl LineShifts {
    /// Makes the shifts of threads, which are the columns of a layout. `first` is the slot of a thread's first particle.
    fn of_threads(layout: Layout, hops: Hops, first: impl Fn(usize) -> usize) -> Self {
        let places = layout.rows;
        let bundle = |thread: usize| LineBundle {
            entry: thread * places,
            places,
            first: first(thread),
            spring: layout.slot(0, thread),
        };
        Self::new((0..layout.columns).step_by(LANES).map(bundle).collect(), hops)
    }

    fn of_diagonals(diagonals: &Diagonals) -> Self {
        let hop = diagonals.hop();
        let bundle = |bundle| {
            let first = diagonals.slot(bundle);
            let spring = first - diagonals.to_spring();
            LineBundle { entry: bundle.before, places: bundle.places, first, spring }
        };
        let hops = Hops { line: 1, particle: hop, spring: hop };
        Self::new(diagonals.bundles.iter().map(bundle).collect(), hops)
    }

    fn new(bundles: Vec<LineBundle>, hops: Hops) -> Self {
        let entries = bundles.last().map_or(0, |last| last.entry + last.places * LANES);
        Self { shifts: Shifts::none(entries), bundles, hops }
    }

    /// Takes all shifts away.
    pub fn clear(&mut self) {
        self.shifts.by.fill(0.0);
    }

    /// Numbers of springs, by entry.
    fn by_entry(&self, springs: &[f32]) -> impl Iterator<Item = f32> {
        let hop = self.hops.spring;
        let rows = self.bundles.iter().flat_map(move |bundle| {
            (0..bundle.places).map(move |place| bundle.spring + place * hop)
        });
        rows.flat_map(|first| springs[first..first + LANES].iter().copied())
    }

    /// Lends the shifts to a solve of the lines, and the multipliers where it `notes` them.
    pub fn in_solve(&mut self, notes: bool) -> ShiftsMut<'_> {
        let Shifts { by, multipliers } = &mut self.shifts;
        ShiftsMut { by, multipliers: notes.then(|| ValuesMut::all(multipliers)) }
    }

    /// Shifts the springs by what they are too long at the end of a tick. Bundles are shared out between as many cores as `most`.
    pub fn shift<'a>(
        &'a mut self,
        springs: LineSprings<'a>,
        shifting: Shifting,
        compliance: f32,
        x: &'a Soa,
        most: usize,
    ) -> ShiftLines<'a> {
        let Self { shifts: Shifts { by, multipliers }, bundles, hops } = self;
        let least = bundles.len().div_ceil(most);
        let by = ValuesMut::all(by);
        ShiftLines {
            bundles,
            least,
            hops: *hops,
            springs,
            shifting,
            compliance,
            x,
            by,
            multipliers,
        }
    }
}

/// Shifts that a solve reads, and room for the multipliers that it comes to.
pub(crate) struct ShiftsMut<'a> {
    by: &'a [f32],
    multipliers: Option<ValuesMut<'a>>,
}

/// Shifts and multipliers of a bundle.
pub(crate) struct BundleShifts<'a> {
    by: Blocks<'a>,
    multipliers: Option<BlocksMut<'a>>,
}

impl ShiftsMut<'_> {
    /// Shifts of a bundle that begin at an entry.
    #[expect(
        clippy::manual_map,
        reason = "a closure that is not inlined keeps the baseline's instructions"
    )]
    #[inline(always)]
    pub fn of_bundle(&mut self, entry: usize, places: usize) -> BundleShifts<'_> {
        let multipliers = match &mut self.multipliers {
            Some(multipliers) => Some(multipliers.blocks(entry, places)),
            None => None,
        };
        BundleShifts { by: Blocks::new(self.by, entry, places), multipliers }
    }
}

impl CutAt for ShiftsMut<'_> {
    fn cut(self, entry: usize) -> (Self, Self) {
        let (multipliers, after) = self.multipliers.cut(entry);
        (Self { multipliers, ..self }, Self { multipliers: after, ..self })
    }
}

/// How the springs of a bundle are shifted; `()` where none are.
pub(crate) trait ShiftsOfBundle {
    /// Shifts of the springs after a place \[m\].
    fn at(&self, place: usize) -> Block;
    /// Takes the multipliers of the springs after a place.
    fn note(&mut self, place: usize, multipliers: &Block);
}

impl ShiftsOfBundle for () {
    #[inline(always)]
    fn at(&self, _: usize) -> Block {
        Block::ZERO
    }

    #[inline(always)]
    fn note(&mut self, _: usize, _: &Block) {}
}

impl ShiftsOfBundle for BundleShifts<'_> {
    #[inline(always)]
    fn at(&self, place: usize) -> Block {
        self.by.at(place)
    }

    #[inline(always)]
    fn note(&mut self, place: usize, multipliers: &Block) {
        if let Some(to) = &mut self.multipliers {
            to.set(place, *multipliers);
        }
    }
}

/// Shifts the springs of lines that go one way, at the end of a tick.
pub(crate) struct ShiftLines<'a> {
    bundles: &'a [LineBundle],
    /// Bundles of a share at least.
    least: usize,
    hops: Hops,
    springs: LineSprings<'a>,
    shifting: Shifting,
    /// Compliance in the last substep of a spring of shape factor one \[1/kg\].
    compliance: f32,
    x: &'a Soa,
    by: ValuesMut<'a>,
    multipliers: &'a [f32],
}

impl Kernel for ShiftLines<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bundles, hops, springs, shifting, compliance, x, mut by, multipliers, .. } =
            self;
        for &LineBundle { entry, places, first, spring } in bundles {
            let mut p = particles(x, first, hops.line);
            for place in 0..places - 1 {
                let q = particles(x, first + (place + 1) * hops.particle, hops.line);
                let (spring, at) = (spring + place * hops.spring, entry + place * LANES);
                let row = Row {
                    ends: [&p, &q],
                    rest: Block::load(springs.rest, spring),
                    factor: Block::load(springs.factor, spring),
                    multipliers: Block::load(multipliers, at),
                    compliance,
                    most: MOST,
                };
                let mut by = by.blocks(at, 1);
                by.set(0, row.shifted(by.at(0), shifting));
                p = q;
            }
        }
    }
}

/// The particles of [`LANES`] lines, from the slot of the first on.
#[inline(always)]
fn particles(x: &Soa, first: usize, hop: usize) -> Block3 {
    if hop == 1 {
        return Block3::load(x, first);
    }
    let mut particles = Block3::ZERO;
    for i in 0..LANES {
        particles.set(i, x.get(first + i * hop));
    }
    particles
}

impl Cut for ShiftLines<'_> {
    type Output = ();

    fn middle(&self) -> Option<usize> {
        let count = self.bundles.len();
        (count >= 2 * self.least).then_some(count / 2)
    }

    fn is_shared(&self) -> bool {
        true
    }

    fn cut(self, middle: usize) -> (Self, Self) {
        let (bundles, after) = self.bundles.split_at(middle);
        let (by, by_after) = self.by.cut(after[0].entry);
        (Self { bundles, by, ..self }, Self { bundles: after, by: by_after, ..self })
    }

    fn run(self, isa: Isa) {
        isa.run(self);
    }
}
