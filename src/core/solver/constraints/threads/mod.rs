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

pub(crate) mod chains;
pub(crate) mod geometric_stiffness;
pub(crate) mod line;
pub(crate) mod warp;
pub(crate) mod weft;

use crate::solver::constraints::threads::geometric_stiffness::{Threads, ease};
use crate::solver::constraints::threads::line::Line;
use crate::solver::contact::{LEAST_MOBILITY, divide};
use crate::solver::simd::block::{
    Block, Block3, Blocks, Blocks3, Blocks3Mut, BlocksMut, LANES, larger,
};
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::lattice::Family;

/// Least compliance of a constraint, relative to the inverse masses of its ends. A straight line
/// held at both ends has one constraint too many; this keeps its matrix far enough from singular
/// for f32, at a strain of the same size.
const LEAST_COMPLIANCE: f32 = 1e-5;
/// Least pivot \[m2/kg\]: between two held particles nothing can move, whatever the residual, and a
/// collapsed spring has no direction and is left alone.
const LEAST_PIVOT: f32 = 1e-30;

/// What a band of threads is solved in.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    /// [`LANES`] rows with rows and columns exchanged: positions, then corrections.
    pub strip: Soa,
    /// The same of normals, where particles lie on colliders, and of what these bear.
    pub normals: Soa,
    pub slip: Array,
    pub load: Array,
    /// The unknowns of [`LANES`] threads.
    pub line: Line,
}

impl Room {
    /// Room for either direction's threads.
    pub fn new(layout: Layout) -> Self {
        let strip = layout.columns.next_multiple_of(LANES) * LANES;
        Self {
            strip: Soa::zeros(strip),
            normals: Soa::zeros(strip),
            slip: Array::zeros(strip),
            load: Array::zeros(strip),
            line: Line::new(layout.rows.max(layout.columns) * LANES),
        }
    }
}

/// What the threads of one direction are made of, in the layout whose rows they run across.
pub(crate) struct Lines<'a> {
    pub layout: Layout,
    pub springs: &'a Family,
    pub reach: Reach,
    pub inverse_mass: &'a [f32],
    /// Room for the unknowns of [`LANES`] threads.
    pub line: &'a mut Line,
}

/// Where the particles of [`LANES`] threads are, and where their corrections go.
pub(crate) trait Ends {
    /// Whether any of them lies on a collider.
    const TOUCH: bool;
    /// Normals of what the particles at a place lie on.
    fn normals(&self, place: usize) -> Block3;
    /// Parts of their inverse masses that move them.
    fn slip(&self, place: usize) -> Block;
    /// Takes what pulls them along those.
    fn load(&mut self, place: usize, load: &Block);
    /// Positions of the particles at a place along the threads.
    fn positions(&self, place: usize) -> Block3;
    /// Takes their corrections.
    fn correct(&mut self, place: usize, correction: Block3);
    /// Takes more of them.
    fn correct_more(&mut self, place: usize, correction: Block3);
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
        let mut pivots = Pivots::new(self.line, bundle.places - 1);
        bundle.eliminate(&self.reach, ends, &mut pivots, excess);
        let most = bundle.substitute(&pivots, ends);
        // Keeps taut threads from trembling.
        if most > self.reach.steady {
            ease(self.line, &mut Woven { bundle, ends });
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
    /// Of the springs after each place.
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

    /// Forward elimination: from place to place, each pivot from the one before.
    #[inline(always)]
    fn eliminate<E: Ends>(
        &self,
        reach: &Reach,
        ends: &E,
        pivots: &mut Pivots<'_>,
        excess: &mut Block,
    ) {
        let (mut x0, mut w0) = (ends.positions(0), mobile(&self.inverse_mass.at(0), ends, 0));
        let mut n0 = ends.normals(0);
        let mut last = Pivot::default();
        for place in 1..self.places {
            let (spring, end) = ((place - 1) * self.hop, place * self.hop);
            let (x1, w1) = (ends.positions(place), mobile(&self.inverse_mass.at(end), ends, place));
            let n1 = ends.normals(place);
            let (rest, factor) = (self.rest.at(spring), self.compliance.at(spring));
            let between = Between { x: [&x0, &x1], w: [&w0, &w1], normals: [&n0, &n1] };
            let next = last.next::<E>(reach, &between, &rest, &factor, excess);
            pivots.set::<E>(place - 1, &next);
            (x0, w0, n0, last) = (x1, w1, n1, next);
        }
    }

    /// Back substitution: tensions from the last spring to the first, and the corrections of the particles between
    /// them. Tells what a spring moved a particle by at most \[m\].
    #[inline(always)]
    fn substitute<E: Ends>(&self, pivots: &Pivots<'_>, ends: &mut E) -> f32 {
        let mut tension = Tension::default();
        for place in (1..self.places).rev() {
            let w = mobile(&self.inverse_mass.at(place * self.hop), ends, place);
            let correction = tension.next(&pivots.at::<E>(place - 1), &w, ends, place);
            ends.correct(place, correction);
        }
        let correction = tension.last(&mobile(&self.inverse_mass.at(0), ends, 0), ends);
        ends.correct(0, correction);
        tension.most.largest()
    }
}

/// [`LANES`] threads of a lattice, and where their particles are.
struct Woven<'a, E> {
    bundle: Bundle<'a>,
    ends: &'a mut E,
}

impl<E: Ends> Threads for Woven<'_, E> {
    #[inline(always)]
    fn places(&self) -> usize {
        self.bundle.places
    }

    #[inline(always)]
    fn inverse_mass(&self, place: usize) -> Block {
        mobile(&self.bundle.inverse_mass.at(place * self.bundle.hop), self.ends, place)
    }

    #[inline(always)]
    fn rest(&self, place: usize) -> Block {
        self.bundle.rest.at(place * self.bundle.hop)
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

/// How soft the springs are, and how long they may be.
#[derive(Clone, Copy)]
pub(crate) struct Reach {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
    /// What a spring may move a particle by without its thread trembling \[m\].
    pub steady: f32,
}

/// What springs are between: positions, inverse masses, and normals of what their ends lie on.
pub(crate) struct Between<'a> {
    pub x: [&'a Block3; 2],
    pub w: [&'a Block; 2],
    pub normals: [&'a Block3; 2],
}

/// One step of the elimination.
#[derive(Clone, Copy)]
pub(crate) struct Pivot {
    /// From one end of the springs to the other, and how long that is \[m\].
    span: Block3,
    length: Block,
    /// 1 / pivot \[kg/m2\].
    inverse: Block,
    /// Length times excess length, and what the springs before add to it \[m2\].
    residual: Block,
    /// How far the springs go along the normals at their second ends \[m\].
    across: Block,
}

impl Default for Pivot {
    fn default() -> Self {
        let none = Block::ZERO;
        Self { span: Block3::ZERO, length: none, inverse: none, residual: none, across: none }
    }
}

impl Pivot {
    /// The step after this one, for the springs between two places. Notes by how much they exceed their limit; those
    /// without a rest length are none.
    #[inline(always)]
    pub fn next<E: Ends>(
        &self,
        reach: &Reach,
        between: &Between<'_>,
        rest: &Block,
        factor: &Block,
        excess: &mut Block,
    ) -> Self {
        let Between { x, w, normals } = between;
        let mut next = Self::default();
        for i in 0..LANES {
            let span = x[1].at(i) - x[0].at(i);
            let square = span.dot(span);
            // Not `Vec3::length`, whose square root may be a call.
            let length = square.sqrt();
            let over = length - rest.0[i] * reach.limit;
            let over = if rest.0[i] > 0.0 { over } else { 0.0 };
            excess.0[i] = larger(over, excess.0[i]);
            let diagonal = w[0].0[i] + w[1].0[i];
            // In this order the larger of the two is a number even where the first is NaN.
            let soft = larger(factor.0[i] * reach.compliance, diagonal * LEAST_COMPLIANCE);
            let mut whole = square * (diagonal + soft);
            let mut along = span.dot(self.span.at(i));
            if E::TOUCH {
                let (n0, n1) = (normals[0].at(i), normals[1].at(i));
                let (across0, across1) = (n0.dot(span), n1.dot(span));
                let still = w[0].0[i] * (across0 * across0) + w[1].0[i] * (across1 * across1);
                let all = square * diagonal;
                whole = larger(all - still, all * LEAST_MOBILITY) + square * soft;
                along -= across0 * self.across.0[i];
                next.across.0[i] = across1;
            }
            let beside = w[0].0[i] * along;
            let carried = beside * self.inverse.0[i];
            let pivot = larger(whole - beside * carried, LEAST_PIVOT);
            next.span.set(i, span);
            next.length.0[i] = length;
            next.inverse.0[i] = 1.0 / pivot;
            next.residual.0[i] = length * (length - rest.0[i]) + carried * self.residual.0[i];
        }
        next
    }
}

/// The steps of an elimination, spring by spring.
pub(crate) struct Pivots<'a> {
    span: Blocks3Mut<'a>,
    length: BlocksMut<'a>,
    inverse: BlocksMut<'a>,
    residual: BlocksMut<'a>,
    across: BlocksMut<'a>,
}

impl<'a> Pivots<'a> {
    /// Those of so many springs.
    #[inline(always)]
    pub fn new(line: &'a mut Line, springs: usize) -> Self {
        Self {
            span: Blocks3Mut::new(&mut line.span, 0, springs),
            length: BlocksMut::new(&mut line.length, 0, springs),
            inverse: BlocksMut::new(&mut line.inverse_pivot, 0, springs),
            residual: BlocksMut::new(&mut line.residual, 0, springs),
            across: BlocksMut::new(&mut line.across, 0, springs),
        }
    }

    #[inline(always)]
    pub fn at<E: Ends>(&self, spring: usize) -> Pivot {
        Pivot {
            span: self.span.at(spring),
            length: self.length.at(spring),
            inverse: self.inverse.at(spring),
            residual: self.residual.at(spring),
            across: if E::TOUCH { self.across.at(spring) } else { Block::ZERO },
        }
    }

    #[inline(always)]
    pub fn set<E: Ends>(&mut self, spring: usize, pivot: &Pivot) {
        self.span.set(spring, pivot.span);
        self.length.set(spring, pivot.length);
        self.inverse.set(spring, pivot.inverse);
        self.residual.set(spring, pivot.residual);
        if E::TOUCH {
            self.across.set(spring, pivot.across);
        }
    }
}

/// The pull of the springs that come after a place.
#[derive(Clone, Copy)]
pub(crate) struct Tension {
    pull: Block3,
    /// What a spring has moved a particle by so far, at most \[m\].
    pub most: Block,
}

impl Default for Tension {
    fn default() -> Self {
        Self { pull: Block3::ZERO, most: Block::ZERO }
    }
}

impl Tension {
    /// Goes on to the springs before the particles of a place, of inverse masses `w`, and gives these their corrections.
    /// What the particles lie on takes the rest.
    #[inline(always)]
    pub fn next<E: Ends>(
        &mut self,
        pivot: &Pivot,
        w: &Block,
        ends: &mut E,
        place: usize,
    ) -> Block3 {
        let normals = ends.normals(place);
        let (mut pull, mut correction, mut load) = (Block3::ZERO, Block3::ZERO, Block::ZERO);
        for i in 0..LANES {
            let (span, after) = (pivot.span.at(i), self.pull.at(i));
            let mut along = span.dot(after);
            let (n, across) = (normals.at(i), pivot.across.0[i]);
            if E::TOUCH {
                load.0[i] = n.dot(after);
                along -= across * load.0[i];
            }
            let tension = (pivot.residual.0[i] + w.0[i] * along) * pivot.inverse.0[i];
            self.most.0[i] = larger(tension * pivot.length.0[i] * w.0[i], self.most.0[i]);
            pull.set(i, span * tension);
            let mut moves = after - pull.at(i);
            if E::TOUCH {
                load.0[i] -= across * tension;
                moves -= n * load.0[i];
            }
            correction.set(i, moves * w.0[i]);
        }
        if E::TOUCH {
            ends.load(place, &load);
        }
        self.pull = pull;
        correction
    }

    /// Corrections of the first particles.
    #[inline(always)]
    pub fn last<E: Ends>(&self, w: &Block, ends: &mut E) -> Block3 {
        let mut moves = self.pull;
        if E::TOUCH {
            let (along, load) = divide(&self.pull, &ends.normals(0));
            ends.load(0, &load);
            moves = along;
        }
        let mut correction = Block3::ZERO;
        for i in 0..LANES {
            correction.set(i, moves.at(i) * w.0[i]);
        }
        correction
    }
}
