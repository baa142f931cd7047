//! Solving the chains of a mesh, each whole: see `threads` for the elimination.

use super::chains::{Bundle, Chains};
use super::places::Places;
use crate::solver::isa::TransposingKernel;
use crate::solver::lanes::{Array, Block, Block3, LANES};
use crate::solver::state::Line;
use crate::solver::taut::{Threads, ease};
use crate::solver::threads::{Pivot, Pivots, Reach, Tension};
use crate::solver::transpose::Transpose;

/// Solves all chains. Tells whether any spring was longer than its limit before it was corrected.
pub(crate) struct SolveChains<'a> {
    pub chains: &'a Chains,
    pub reach: Reach,
    pub places: &'a mut Places,
    pub line: &'a mut Line,
    /// Inverse masses along the chains of a bundle.
    pub inverse_mass: &'a mut Array,
}

impl TransposingKernel for SolveChains<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self, t: impl Transpose) -> bool {
        let mut excess = Block::ZERO;
        let chains = self.chains;
        for bundle in &chains.bundles {
            self.eliminate(t, bundle, &mut excess);
            self.substitute(t, bundle);
        }
        excess.largest() > 0.0
    }
}

impl SolveChains<'_> {
    #[inline(always)]
    fn eliminate(&mut self, t: impl Transpose, bundle: &Bundle, excess: &mut Block) {
        let (mut x0, mut w0) = self.places.gather_moved(t, &self.chains.slots, bundle.first);
        w0.store(self.inverse_mass, 0);
        let mut last = Pivot::default();
        let mut pivots = Pivots::new(self.line, bundle.rows - 1);
        for place in 1..bundle.rows {
            let at = bundle.first + place * LANES;
            let (x1, w1) = self.places.gather_moved(t, &self.chains.slots, at);
            let rest = Block::load(&self.chains.rest, at);
            let factor = Block::load(&self.chains.compliance, at);
            let next = last.next(&self.reach, [&x0, &x1], [&w0, &w1], &rest, &factor, excess);
            pivots.set(place - 1, &next);
            w1.store(self.inverse_mass, place * LANES);
            (x0, w0, last) = (x1, w1, next);
        }
    }

    #[inline(always)]
    fn substitute(&mut self, t: impl Transpose, bundle: &Bundle) {
        let mut tension = Tension::default();
        let pivots = Pivots::new(self.line, bundle.rows - 1);
        for place in (1..bundle.rows).rev() {
            let w = Block::load(self.inverse_mass, place * LANES);
            let correction = tension.next(&pivots.at(place - 1), &w);
            let at = bundle.first + place * LANES;
            self.places.scatter(t, &self.chains.slots, at, correction);
        }
        let w = Block::load(self.inverse_mass, 0);
        self.places.scatter(t, &self.chains.slots, bundle.first, tension.last(&w));
        if tension.most.largest() > self.reach.steady {
            self.ease(t, bundle);
        }
    }

    /// Keeps taut chains from trembling.
    #[inline(always)]
    fn ease(&mut self, t: impl Transpose, bundle: &Bundle) {
        let Self { chains, inverse_mass, line, places, .. } = self;
        ease(line, &mut Laid { t, chains, bundle, inverse_mass, places });
    }
}

/// The chains of a bundle.
struct Laid<'a, T> {
    t: T,
    chains: &'a Chains,
    bundle: &'a Bundle,
    inverse_mass: &'a Array,
    places: &'a mut Places,
}

impl<T: Transpose> Threads for Laid<'_, T> {
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
        Block::load(&self.chains.rest, self.bundle.first + (place + 1) * LANES)
    }

    #[inline(always)]
    fn correct_more(&mut self, place: usize, more: Block3) {
        let at = self.bundle.first + place * LANES;
        self.places.scatter(self.t, &self.chains.slots, at, more);
    }
}
