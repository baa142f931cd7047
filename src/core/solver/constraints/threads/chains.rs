//! Solving the chains of a mesh, each whole: see `threads` for the elimination.

use crate::solver::constraints::threads::geometric_stiffness::{Threads, ease};
use crate::solver::constraints::threads::line::Line;
use crate::solver::constraints::threads::shifts::Shifts;
use crate::solver::constraints::threads::tridiagonal::{
    Between, Eliminated, Ends, Pivot, Reach, Tension,
};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::gather::PlacesMut;
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::Workspaces;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::simd::transpose::Transpose;
use crate::solver::topology::graph::chains::{Bundle, Chains};
use crate::solver::topology::graph::domains::{Domain, DomainBand, Rounds, cut_between_domains};

/// What chains are solved in.
#[derive(Clone, Debug)]
pub(crate) struct ChainWorkspace {
    /// Unknowns of a bundle.
    line: Line,
    /// Inverse masses along the chains of a bundle.
    inverse_mass: Array,
    /// Normals of what their particles lie on, where any do.
    normals: Soa,
}

impl ChainWorkspace {
    /// Room for any bundle of some chains.
    pub fn new(chains: &Rounds<Chains>) -> Self {
        let longest = chains.iter().map(|domain| domain.work.longest()).max().unwrap_or(0);
        let slots = longest * LANES;
        let (inverse_mass, normals) = (Array::zeros(slots), Soa::zeros(slots));
        Self { line: Line::new(longest), inverse_mass, normals }
    }
}

/// Solves all chains of a round. Tells whether any spring was longer than its limit before it was corrected.
pub(crate) struct SolveChains<'a> {
    pub band: DomainBand,
    pub domains: &'a [Domain<Chains>],
    pub reach: Reach,
    /// Whether any particle lies on a collider.
    pub touches: bool,
    pub places: PlacesMut<'a>,
    pub workspaces: &'a Workspaces<ChainWorkspace>,
    pub shifts: &'a mut [Shifts],
}

cut_between_domains!(
    SolveChains: TransposingKernel, run_transposing;
    domains; by slot places; by domain shifts
);

impl TransposingKernel for SolveChains<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self, t: impl Transpose) -> bool {
        let Self { domains, reach, touches, mut places, workspaces, shifts, .. } = self;
        let ChainWorkspace { line, inverse_mass, normals } = &mut *workspaces.take();
        let mut exceeds = false;
        for (Domain { slots, work: chains }, shifts) in domains.iter().zip(shifts) {
            for bundle in &chains.bundles {
                let (places, borne) = (places.within(slots), Block::ZERO);
                let laid = Laid::<_, false> {
                    t,
                    chains,
                    bundle,
                    inverse_mass,
                    normals,
                    shifts,
                    places,
                    borne,
                };
                exceeds |= if touches {
                    solve(&reach, laid.on_colliders(), line)
                } else {
                    solve(&reach, laid, line)
                };
            }
        }
        exceeds
    }
}

/// Solves and corrects the chains of a bundle. Tells whether any spring was longer than its limit before.
#[inline(always)]
fn solve<T: Transpose, const TOUCH: bool>(
    reach: &Reach,
    mut laid: Laid<'_, T, TOUCH>,
    line: &mut Line,
) -> bool {
    let springs = &mut line.springs[..laid.bundle.rows - 1];
    let exceeds = laid.eliminate(reach, springs);
    // Keeps taut chains from trembling.
    if laid.substitute(springs) > reach.steady {
        ease(line, &mut laid);
    }
    exceeds
}

/// The chains of a bundle.
struct Laid<'a, T, const TOUCH: bool> {
    t: T,
    chains: &'a Chains,
    bundle: &'a Bundle,
    inverse_mass: &'a mut Array,
    normals: &'a mut Soa,
    shifts: &'a mut Shifts,
    places: PlacesMut<'a>,
    /// Load on the normals of the particles that are corrected next: what they lie on bears it, and they do not follow.
    borne: Block,
}

impl<'a, T: Transpose> Laid<'a, T, false> {
    /// Chains of which any particle lies on a collider.
    #[inline(always)]
    fn on_colliders(self) -> Laid<'a, T, true> {
        let Self { t, chains, bundle, inverse_mass, normals, shifts, places, borne } = self;
        Laid { t, chains, bundle, inverse_mass, normals, shifts, places, borne }
    }
}

impl<T: Transpose, const TOUCH: bool> Laid<'_, T, TOUCH> {
    /// Where the entries of a row begin.
    #[inline(always)]
    fn entry(&self, place: usize) -> usize {
        self.bundle.first + place * LANES
    }

    /// Gathers where the particles at a place are, their inverse masses and normals. These are kept: neighbours in memory are sooner
    /// read again.
    #[inline(always)]
    fn gather(&mut self, place: usize) -> (Block3, Block, Block3) {
        let (slots, entry) = (&self.chains.slots, self.entry(place));
        if !TOUCH {
            let (x, w) = self.places.gather_moved(self.t, slots, entry);
            return (x, w, Block3::ZERO);
        }
        let (x, w, normals) = self.places.gather_lying(self.t, slots, entry);
        normals.store(self.normals, place * LANES);
        (x, w, normals)
    }

    #[inline(always)]
    fn eliminate(&mut self, reach: &Reach, springs: &mut [Eliminated]) -> bool {
        let mut excess = Block::ZERO;
        let (mut x0, mut w0, mut n0) = self.gather(0);
        w0.store(self.inverse_mass, 0);
        let mut last = Pivot::default();
        for place in 1..self.bundle.rows {
            let at = self.entry(place);
            let (x1, mut w1, n1) = self.gather(place);
            let rest = Block::load(&self.chains.rest, at);
            let factor = Block::load(&self.chains.compliance, at);
            for i in 0..LANES {
                // Where there is no spring, nothing is to move.
                w1.0[i] = if rest.0[i] > 0.0 { w1.0[i] } else { 0.0 };
            }
            let shift = &Block::load(&self.shifts.by, at);
            let between = Between { x: [&x0, &x1], w: [&w0, &w1], normals: [&n0, &n1], shift };
            let next = last.next::<Self>(reach, &between, &rest, &factor, &mut excess);
            next.springs.put::<Self>(&mut springs[place - 1]);
            w1.store(self.inverse_mass, place * LANES);
            (x0, w0, n0, last) = (x1, w1, n1, next);
        }
        excess.largest() > 0.0
    }

    /// Corrects the particles, and tells what a spring moved one by at most \[m\].
    #[inline(always)]
    fn substitute(&mut self, springs: &[Eliminated]) -> f32 {
        let mut tension = Tension::default();
        for place in (1..self.bundle.rows).rev() {
            let w = Block::load(self.inverse_mass, place * LANES);
            let correction = tension.next(&springs[place - 1], &w, self, place);
            let at = self.entry(place);
            tension.multipliers.store(&mut self.shifts.multipliers, at);
            self.correct(place, correction);
        }
        let w = Block::load(self.inverse_mass, 0);
        let correction = tension.last(&w, self);
        self.correct(0, correction);
        tension.most.largest()
    }
}

impl<T: Transpose, const TOUCH: bool> Ends for Laid<'_, T, TOUCH> {
    const TOUCH: bool = TOUCH;

    #[inline(always)]
    fn positions(&self, place: usize) -> Block3 {
        self.places.gather_moved(self.t, &self.chains.slots, self.entry(place)).0
    }

    #[inline(always)]
    fn normals(&self, place: usize) -> Block3 {
        if !TOUCH {
            return Block3::ZERO;
        }
        Block3::load(self.normals, place * LANES)
    }

    #[inline(always)]
    fn slip(&self, _: usize) -> Block {
        // Inverse masses of places are as far as friction lets them go.
        Block::splat(1.0)
    }

    #[inline(always)]
    fn load(&mut self, _: usize, load: &Block) {
        self.borne = *load;
    }

    #[inline(always)]
    fn correct(&mut self, place: usize, correction: Block3) {
        let (slots, entry) = (&self.chains.slots, self.entry(place));
        if TOUCH {
            self.places.scatter_lying(self.t, slots, entry, correction, &self.borne);
        } else {
            self.places.scatter(self.t, slots, entry, correction);
        }
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, more: Block3) {
        Ends::correct(self, place, more);
    }
}

impl<T: Transpose, const TOUCH: bool> Threads for Laid<'_, T, TOUCH> {
    #[inline(always)]
    fn places(&self) -> usize {
        self.bundle.rows
    }

    #[inline(always)]
    fn inverse_mass(&self, place: usize) -> Block {
        Block::load(self.inverse_mass, place * LANES)
    }

    #[inline(always)]
    fn rest(&self, place: usize) -> Block {
        Block::load(&self.chains.rest, self.entry(place + 1))
    }

    #[inline(always)]
    fn normals(&self, place: usize) -> Option<Block3> {
        if TOUCH { Some(Ends::normals(self, place)) } else { None }
    }

    #[inline(always)]
    fn load(&mut self, place: usize, load: &Block) {
        Ends::load(self, place, load);
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, more: Block3) {
        Ends::correct(self, place, more);
    }
}
