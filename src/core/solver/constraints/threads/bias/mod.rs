//! Shear on the bias: the springs across the cells, solved whole along the diagonals of the sheet.
//!
//! Where one pass over the cells (`constraints::shear`) cannot bear the stiffness asked for, it leaves a cloth softer than that: a
//! substep's pass stands for no more than `k = 0.4 / (w h^2)`. Solved along whole diagonals, as threads are, springs bear many times
//! that, the more the longer the waves of shear are. They are solved so as well where the cloth carries
//! anything.
//!
//! The diagonals are [`LANES`] side by side, like columns that move by one from row to row. Some of them begin later
//! than others, or end earlier; there their lanes are in the padding between rows, where there are no springs.
//!
//! Cores cannot share the diagonals of a large sheet by rows. There each works on some bundles of them and puts what it comes to
//! apart (`apart`).

mod apart;
mod law;

pub(crate) use apart::{LoadsBack, PutDiagonalsBack, SolveBiasApart};
pub(crate) use law::ShearLaw;

use crate::solver::constraints::threads::Springs;
use crate::solver::constraints::threads::line::Line;
use crate::solver::constraints::threads::shifts::ShiftsMut;
use crate::solver::constraints::threads::tridiagonal::Ends;
use crate::solver::contact::{Contacts, Normals};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::{PartMut, Soa, ValuesMut};
use crate::solver::topology::lattice::Lattice;

/// Which way diagonals go from row to row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// To the column after.
    Right,
    /// To the column before.
    Left,
}

/// The diagonals of a lattice that go one way.
#[derive(Clone, Debug)]
pub(crate) struct Diagonals {
    way: Way,
    layout: Layout,
    pub bundles: Vec<Bundle>,
}

/// [`LANES`] diagonals side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bundle {
    /// The first row that any of them is in.
    row: usize,
    /// Rows that any of them is in: two at least.
    pub places: usize,
    /// The column of the first one in the first row. It may be before all.
    column: isize,
    /// Particles of all bundles before it, padding included.
    pub before: usize,
}

impl Diagonals {
    /// Finds the diagonals of a lattice: those that go right, and those that go left.
    pub fn both(layout: Layout) -> [Self; 2] {
        [Way::Right, Way::Left].map(|way| Self::new(layout, way))
    }

    fn new(layout: Layout, way: Way) -> Self {
        let (rows, columns, lanes) =
            (layout.rows as isize, layout.columns as isize, LANES as isize);
        // Columns that the first diagonals of bundles would be in, in the first row of all.
        let starts = match way {
            Way::Right => 1 - rows..columns,
            Way::Left => 0..columns + rows - 1,
        };
        let mut bundles = Vec::new();
        let mut before = 0;
        for start in starts.step_by(LANES) {
            let rows = match way {
                Way::Right => (1 - lanes - start).max(0)..(columns - start).min(rows),
                Way::Left => (start - columns + 1).max(0)..(start + lanes).min(rows),
            };
            // A particle alone has no spring.
            if rows.end - rows.start < 2 {
                continue;
            }
            let places = (rows.end - rows.start) as usize;
            let column = start + way.step() * rows.start;
            bundles.push(Bundle { row: rows.start as usize, places, column, before });
            before += places * LANES;
        }
        Self { way, layout, bundles }
    }

    /// Particles of all bundles, padding included.
    pub fn len(&self) -> usize {
        self.bundles.last().map_or(0, |last| last.before + last.places * LANES)
    }

    /// The slot of the first lane of a bundle's first row.
    pub fn slot(&self, bundle: &Bundle) -> usize {
        // Before the first column is the padding of the row before.
        self.layout.slot(bundle.row, 0).wrapping_add_signed(bundle.column)
    }

    /// Slots from one particle of a diagonal to the next.
    pub fn hop(&self) -> usize {
        self.layout.stride.wrapping_add_signed(self.way.step())
    }

    /// Slots from a spring to the particle that it goes on from: a cell's springs stand at its first corner.
    pub fn to_spring(&self) -> usize {
        usize::from(self.way == Way::Left)
    }
}

impl Way {
    fn step(self) -> isize {
        match self {
            Self::Right => 1,
            Self::Left => -1,
        }
    }
}

/// The springs across the cells, and what their ends lie on.
#[derive(Clone, Copy)]
pub(crate) struct Bias<'a> {
    pub lattice: &'a Lattice,
    pub diagonals: &'a Diagonals,
    pub law: ShearLaw,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
}

/// Solves all diagonals that go one way.
pub(crate) struct SolveBias<'a> {
    pub bias: Bias<'a>,
    pub d: PartMut<'a>,
    pub contacts: Option<Contacts<'a>>,
    pub line: &'a mut Line,
    pub shifts: Option<ShiftsMut<'a>>,
}

impl Kernel for SolveBias<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { bias, mut d, mut contacts, line, mut shifts } = self;
        for bundle in &bias.diagonals.bundles {
            let strands = bias.strands(bundle);
            match &mut contacts {
                Some(Contacts { normals, load }) if strands.touch(normals) => {
                    let to = InPlace { d: d.reborrow(), load: Some(load.reborrow()) };
                    OnBias::<_, true> { strands, x: bias.x, normals: Some(normals), to }.solve(
                        &bias.law,
                        line,
                        &mut shifts,
                    );
                }
                _ => {
                    let to = InPlace { d: d.reborrow(), load: None };
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

impl<'a> Bias<'a> {
    #[inline(always)]
    fn strands(&self, bundle: &Bundle) -> Strands<'a> {
        let Lattice { diagonal, antidiagonal_rest, .. } = self.lattice;
        let rest = match self.diagonals.way {
            Way::Right => &diagonal.rest,
            Way::Left => antidiagonal_rest,
        };
        Strands {
            entry: bundle.before,
            places: bundle.places,
            first: self.diagonals.slot(bundle),
            hop: self.diagonals.hop(),
            to_spring: self.diagonals.to_spring(),
            inverse_mass: self.inverse_mass,
            rest,
            compliance: &diagonal.compliance,
        }
    }
}

/// The springs of a bundle.
#[derive(Clone, Copy)]
struct Strands<'a> {
    /// Where its shifts begin.
    entry: usize,
    places: usize,
    /// The slot of the first lane of the first place, and slots from place to place.
    first: usize,
    hop: usize,
    /// Slots from a spring to the particle that it goes on from.
    to_spring: usize,
    inverse_mass: &'a [f32],
    rest: &'a [f32],
    compliance: &'a [f32],
}

impl Strands<'_> {
    #[inline(always)]
    fn slot(&self, place: usize) -> usize {
        self.first + place * self.hop
    }

    /// Whether any particle lies on a collider.
    #[inline(always)]
    fn touch(&self, normals: &Normals) -> bool {
        (0..self.places).any(|place| {
            let slot = self.slot(place);
            let block = slot / LANES;
            normals.touch(block, slot.div_ceil(LANES) - block + 1, 1)
        })
    }
}

impl Springs for Strands<'_> {
    #[inline(always)]
    fn places(&self) -> usize {
        self.places
    }

    #[inline(always)]
    fn inverse_mass(&self, place: usize) -> Block {
        Block::load(self.inverse_mass, self.slot(place))
    }

    #[inline(always)]
    fn rest(&self, place: usize) -> Block {
        Block::load(self.rest, self.slot(place) - self.to_spring)
    }

    #[inline(always)]
    fn compliance(&self, place: usize) -> Block {
        Block::load(self.compliance, self.slot(place) - self.to_spring)
    }
}

/// Where corrections go.
trait To {
    /// Displacements of some slots.
    fn displacements(&self, slot: usize) -> Block3;
    /// Takes the corrections of the particles at a place.
    fn correct(&mut self, place: usize, slot: usize, correction: &Block3);
    /// Takes more of them.
    fn correct_more(&mut self, place: usize, slot: usize, more: &Block3);
    /// Takes what pulls them onto what they lie on.
    fn load(&mut self, place: usize, slot: usize, load: &Block);
}

/// Into the sheet.
struct InPlace<'a> {
    d: PartMut<'a>,
    load: Option<ValuesMut<'a>>,
}

impl To for InPlace<'_> {
    #[inline(always)]
    fn displacements(&self, slot: usize) -> Block3 {
        Block3::load(&self.d, slot)
    }

    #[inline(always)]
    fn correct(&mut self, _: usize, slot: usize, correction: &Block3) {
        Block3::load(&self.d, slot).plus(correction).store(&mut self.d, slot);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, slot: usize, more: &Block3) {
        self.correct(place, slot, more);
    }

    #[inline(always)]
    fn load(&mut self, _: usize, slot: usize, load: &Block) {
        if let Some(all) = &mut self.load {
            all.add(slot, load);
        }
    }
}

/// The particles of a bundle.
struct OnBias<'a, T, const TOUCH: bool> {
    strands: Strands<'a>,
    x: &'a Soa,
    normals: Option<&'a Normals>,
    to: T,
}

impl<T: To, const TOUCH: bool> OnBias<'_, T, TOUCH> {
    #[inline(always)]
    fn solve(mut self, law: &ShearLaw, line: &mut Line, shifts: &mut Option<ShiftsMut<'_>>) {
        let (strands, excess) = (self.strands, &mut Block::splat(0.0));
        match shifts {
            Some(shifts) => {
                let shifts = shifts.of_bundle(strands.entry, strands.places);
                strands.solve(law, line, &mut self, excess, shifts);
            }
            None => strands.solve(law, line, &mut self, excess, ()),
        }
    }
}

impl<T: To, const TOUCH: bool> Ends for OnBias<'_, T, TOUCH> {
    const TOUCH: bool = TOUCH;
    const HAS_GAPS: bool = true;

    #[inline(always)]
    fn normals(&self, place: usize) -> Block3 {
        match self.normals {
            Some(normals) if TOUCH => Block3::load(&normals.normal, self.strands.slot(place)),
            _ => Block3::ZERO,
        }
    }

    #[inline(always)]
    fn slip(&self, place: usize) -> Block {
        match self.normals {
            Some(normals) if TOUCH => Block::load(&normals.slip, self.strands.slot(place)),
            _ => Block::splat(1.0),
        }
    }

    #[inline(always)]
    fn load(&mut self, place: usize, load: &Block) {
        self.to.load(place, self.strands.slot(place), load);
    }

    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        let slot = self.strands.slot(place);
        Block3::load(self.x, slot).plus(&self.to.displacements(slot))
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        self.to.correct(place, self.strands.slot(place), &correction);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, more: Block3) {
        self.to.correct_more(place, self.strands.slot(place), &more);
    }
}
