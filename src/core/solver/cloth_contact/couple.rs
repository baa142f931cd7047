//! Two cloths that may touch.

use crate::solver::cloth_contact::batches::Batches;
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::parts::Body;
use crate::solver::cloth_contact::respond::{Respond, Touched};
use crate::solver::simd::block::smaller;
use crate::solver::simd::soa::{Array, Soa};

/// Two cloths that may touch.
#[derive(Debug, Default)]
pub(super) struct Couple {
    /// Which they are, the first one first.
    pub of: [usize; 2],
    pub friction: f32,
    pub pairs: Vec<Pair>,
    pub batches: Batches,
    /// How far each region of the one may move relative to each of the other \[m\].
    pub allowed: Vec<f32>,
    pub travelled: f32,
    /// Whether any pair has touched in the tick.
    pub has_touched: bool,
    /// What touched in the last substep.
    pub touched: Touched,
}

impl Couple {
    /// Moves apart what touches, of cloths that were at `found_at`, where their first slots are given.
    pub fn meet(
        &mut self,
        bodies: &mut [impl Body],
        found_at: &Soa,
        first: &[u32],
        still: &mut (Soa, Array),
    ) {
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(mut one), Some(mut other)) = (one.parts(), other.parts()) else { return };
        let (isa, shift) = (one.isa, one.origin - other.origin);
        let drift = one.drift - other.drift;
        let most_push = smaller(one.most_push, other.most_push);
        // One of the two moves.
        let [ones, others] = match (one.moves, other.moves) {
            (false, _) => [Some(still), None],
            (_, false) => [None, Some(still)],
            _ => [None, None],
        };
        let [a, b] = self.of.map(|of| first[of]);
        let respond = Respond {
            pairs: &self.pairs,
            batches: &mut self.batches,
            sides: &mut [one.side(a, found_at, ones), other.side(b, found_at, others)],
            shift,
            drift,
            travelled: self.travelled,
            friction: self.friction,
            most_push,
        };
        self.touched = isa.run(respond);
        if self.touched.count > 0 {
            self.has_touched = true;
            for others in [one.others, other.others] {
                others.since_touch = 0;
                others.tangles.is_suspected |= self.touched.is_deep;
            }
        }
    }

    pub fn search_tangles(&self, bodies: &mut [impl Body]) {
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(one), Some(other)) = (one.parts(), other.parts()) else { return };
        let shift = one.origin - other.origin;
        let (here, tangles) = one.places();
        let (there, theirs) = other.places();
        for pair in &self.pairs {
            let at = |slot| here.at(slot) + shift;
            tangles.search_with(theirs, pair, at, |slot| there.at(slot));
        }
    }
}
