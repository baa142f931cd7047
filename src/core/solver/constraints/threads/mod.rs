//! Threads solved whole: every warp and weft line is corrected at once.
//!
//! The distance constraints along a line couple only neighbours, so that their matrix is
//! tridiagonal: `w_j + w_(j+1) + compliance` on the diagonal and `-w_(j+1) n_j . n_(j+1)` beside it.
//! One forward and one backward pass solve it, [`LANES`] lines side by side. The compliance is the
//! spring's own, `1 / (k h^2)` (Macklin, Mueller and Chentanez 2016, XPBD, eq. 18; with drag, what a
//! force still moves in a substep stands for `h^2`), so that a thread
//! at rest carries its load with the stiffness asked for.
//!
//! Where particles lie on colliders their inverse masses `w` give way to mobilities `w (1 - n n^T)` (`contact`): of
//! each product of two directions what is along the normals `n` is left out. The matrix stays tridiagonal.
//!
//! What is solved for is each tension over the spring's length, with each equation times that length: springs
//! then stand in it as they are, and none has to be divided by its length for a direction.

pub(crate) mod bias;
pub(crate) mod chains;
pub(crate) mod geometric_stiffness;
pub(crate) mod line;
pub(crate) mod shifts;
pub(crate) mod tridiagonal;
pub(crate) mod warp;
pub(crate) mod weft;

use crate::solver::constraints::threads::geometric_stiffness::{Threads, ease};
use crate::solver::constraints::threads::line::Line;
use crate::solver::constraints::threads::shifts::{ShiftsMut, ShiftsOfBundle};
use crate::solver::constraints::threads::tridiagonal::{
    Between, Eliminated, Ends, Law, Pivot, Reach, Tension,
};
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, BlocksMut};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::lattice::Family;

/// Working memory of a band of threads.
#[derive(Clone, Debug)]
pub(crate) struct ThreadWorkspace {
    /// [`LANES`] rows with rows and columns exchanged: positions, then corrections.
    pub strip: Soa,
    /// Normals of the same particles, where they lie on colliders, and the loads that these bear.
    pub normals: Soa,
    pub slip: Array,
    pub load: Array,
    /// The unknowns of [`LANES`] threads.
    pub line: Line,
}

impl ThreadWorkspace {
    /// Room for either direction's threads.
    pub fn new(layout: Layout) -> Self {
        let strip = layout.columns.next_multiple_of(LANES) * LANES;
        Self {
            strip: Soa::zeros(strip),
            normals: Soa::zeros(strip),
            slip: Array::zeros(strip),
            load: Array::zeros(strip),
            line: Line::new(layout.rows.max(layout.columns)),
        }
    }
}

/// The springs and masses of the threads of one direction, in the layout whose rows they run across.
pub(crate) struct Lines<'a> {
    pub layout: Layout,
    pub springs: &'a Family,
    pub reach: Reach,
    pub inverse_mass: &'a [f32],
    /// Room for the unknowns of [`LANES`] threads.
    pub line: &'a mut Line,
    pub shifts: Option<ShiftsMut<'a>>,
}

/// Particles of which some lie on colliders.
pub(crate) struct OnColliders<'a, E> {
    pub ends: E,
    /// Blocks from one place to the next of normals, and of loads.
    pub hops: [usize; 2],
    pub normals: Blocks3<'a>,
    pub slips: Blocks<'a>,
    pub loads: BlocksMut<'a>,
}

impl<E: Ends> Ends for OnColliders<'_, E> {
    const TOUCH: bool = true;

    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        self.ends.positions(place)
    }

    #[inline(always)]
    fn normals(&self, place: usize) -> Block3 {
        self.normals.at(place * self.hops[0])
    }

    #[inline(always)]
    fn slip(&self, place: usize) -> Block {
        self.slips.at(place * self.hops[0])
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        self.ends.correct(place, correction);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, correction: Block3) {
        self.ends.correct_more(place, correction);
    }

    #[inline(always)]
    fn load(&mut self, place: usize, load: &Block) {
        self.loads.add(place * self.hops[1], load);
    }
}

/// Makes the methods of [`Ends`] that have no meaning where none touches a collider.
macro_rules! touch_nothing {
    () => {
        const TOUCH: bool = false;

        #[inline(always)]
        fn normals(&self, _: usize) -> Block3 {
            Block3::ZERO
        }

        #[inline(always)]
        fn slip(&self, _: usize) -> Block {
            Block::splat(1.0)
        }

        #[inline(always)]
        fn load(&mut self, _: usize, _: &Block) {}
    };
}

pub(crate) use touch_nothing;

impl Lines<'_> {
    /// Solves and corrects the threads from one on.
    #[inline(always)]
    pub fn solve<E: Ends>(&mut self, thread: usize, ends: &mut E, excess: &mut Block) {
        let bundle = Bundle::new(self, thread);
        let places = self.layout.rows;
        match &mut self.shifts {
            Some(shifts) => {
                let shifts = shifts.of_bundle(thread * places, places);
                bundle.solve(&self.reach, self.line, ends, excess, shifts);
            }
            None => bundle.solve(&self.reach, self.line, ends, excess, ()),
        }
    }
}

/// [`LANES`] threads side by side.
#[derive(Clone, Copy)]
struct Bundle<'a> {
    /// Particles of each.
    places: usize,
    /// Blocks from one place to the next.
    hop: usize,
    inverse_mass: Blocks<'a>,
    /// Rest lengths of the springs after each place.
    rest: Blocks<'a>,
    compliance: Blocks<'a>,
}

impl<'a> Bundle<'a> {
    #[inline(always)]
    fn new(lines: &Lines<'a>, thread: usize) -> Self {
        let Lines { layout, springs, inverse_mass, .. } = lines;
        let (first, count) = (layout.slot(0, thread), layout.blocks_down());
        Self {
            places: layout.rows,
            hop: layout.stride / LANES,
            inverse_mass: Blocks::new(inverse_mass, first, count),
            rest: Blocks::new(&springs.rest, first, count),
            compliance: Blocks::new(&springs.compliance, first, count),
        }
    }
}

impl Springs for Bundle<'_> {
    #[inline(always)]
    fn places(&self) -> usize {
        self.places
    }

    #[inline(always)]
    fn inverse_mass(&self, place: usize) -> Block {
        self.inverse_mass.at(place * self.hop)
    }

    #[inline(always)]
    fn rest(&self, place: usize) -> Block {
        self.rest.at(place * self.hop)
    }

    #[inline(always)]
    fn compliance(&self, place: usize) -> Block {
        self.compliance.at(place * self.hop)
    }
}

/// The springs and masses of [`LANES`] threads side by side.
trait Springs {
    /// Particles of a thread.
    fn places(&self) -> usize;
    /// Inverse masses at a place \[1/kg\].
    fn inverse_mass(&self, place: usize) -> Block;
    /// Rest lengths of the springs after a place \[m\].
    fn rest(&self, place: usize) -> Block;
    /// One over their shape factors.
    fn compliance(&self, place: usize) -> Block;

    /// Solves and corrects the threads.
    #[inline(always)]
    fn solve<E: Ends>(
        self,
        law: &impl Law,
        line: &mut Line,
        ends: &mut E,
        excess: &mut Block,
        mut shifts: impl ShiftsOfBundle,
    ) where
        Self: Sized,
    {
        let springs = &mut line.springs[..self.places() - 1];
        self.eliminate(law, ends, springs, excess, &shifts);
        let most = self.substitute(springs, ends, &mut shifts);
        // Keeps taut threads from trembling.
        if most > law.reach().steady {
            ease(line, &mut Woven { springs: self, ends });
        }
    }

    /// Forward elimination: from place to place, each pivot from the one before.
    #[inline(always)]
    fn eliminate<E: Ends>(
        &self,
        law: &impl Law,
        ends: &E,
        springs: &mut [Eliminated],
        excess: &mut Block,
        shifts: &impl ShiftsOfBundle,
    ) {
        let (mut x0, mut w0) = (ends.positions(0), mobile(&self.inverse_mass(0), ends, 0));
        let mut n0 = ends.normals(0);
        let mut last = Pivot::default();
        for place in 1..self.places() {
            let (x1, w1) = (ends.positions(place), mobile(&self.inverse_mass(place), ends, place));
            let n1 = ends.normals(place);
            let (rest, factor) = (self.rest(place - 1), self.compliance(place - 1));
            let shift = shifts.at(place - 1);
            let between =
                Between { x: [&x0, &x1], w: [&w0, &w1], normals: [&n0, &n1], shift: &shift };
            let next = last.next::<E>(law, &between, &rest, &factor, excess);
            next.springs.put::<E>(&mut springs[place - 1]);
            (x0, w0, n0, last) = (x1, w1, n1, next);
        }
    }

    /// Back substitution: tensions from the last spring to the first, and the corrections of the particles between
    /// them. Tells what a spring moved a particle by at most \[m\].
    #[inline(always)]
    fn substitute<E: Ends>(
        &self,
        springs: &[Eliminated],
        ends: &mut E,
        shifts: &mut impl ShiftsOfBundle,
    ) -> f32 {
        let mut tension = Tension::default();
        for place in (1..self.places()).rev() {
            let w = mobile(&self.inverse_mass(place), ends, place);
            let correction = tension.next(&springs[place - 1], &w, ends, place);
            shifts.note(place - 1, &tension.multipliers);
            ends.correct(place, correction);
        }
        let correction = tension.last(&mobile(&self.inverse_mass(0), ends, 0), ends);
        ends.correct(0, correction);
        tension.most.largest()
    }
}

/// [`LANES`] threads of a lattice, and where their particles are.
struct Woven<'a, S, E> {
    springs: S,
    ends: &'a mut E,
}

impl<S: Springs, E: Ends> Threads for Woven<'_, S, E> {
    #[inline(always)]
    fn places(&self) -> usize {
        self.springs.places()
    }

    #[inline(always)]
    fn inverse_mass(&self, place: usize) -> Block {
        mobile(&self.springs.inverse_mass(place), self.ends, place)
    }

    #[inline(always)]
    fn rest(&self, place: usize) -> Block {
        self.springs.rest(place)
    }

    #[inline(always)]
    fn normals(&self, place: usize) -> Option<Block3> {
        if E::TOUCH { Some(self.ends.normals(place)) } else { None }
    }

    #[inline(always)]
    fn load(&mut self, place: usize, load: &Block) {
        self.ends.load(place, load);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, more: Block3) {
        self.ends.correct_more(place, more);
    }
}

/// Inverse masses of particles, as far as friction lets them go.
#[inline(always)]
fn mobile<E: Ends>(w: &Block, ends: &E, place: usize) -> Block {
    let mut mobile = *w;
    if E::TOUCH {
        let slip = ends.slip(place);
        for i in 0..LANES {
            mobile.0[i] *= slip.0[i];
        }
    }
    mobile
}
