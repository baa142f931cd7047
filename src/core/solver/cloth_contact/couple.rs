//! Two cloths that may touch.

use crate::solver::cloth_contact::AT_LEAST;
use crate::solver::cloth_contact::batches::Batches;
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::history::{History, Stuck, stamp, take_shared};
use crate::solver::cloth_contact::others::OthersContact;
use crate::solver::cloth_contact::parts::{Body, Parts};
use crate::solver::cloth_contact::respond::{LookAtPairs, Respond, Touched};
use crate::solver::cloth_contact::travel::{Allowance, Travelled};
use crate::solver::simd::block::smaller;
use crate::solver::simd::soa::Soa;

/// Two cloths that may touch.
#[derive(Debug, Default)]
pub(super) struct Couple {
    /// Which they are, the first one first.
    pub of: [usize; 2],
    pub friction: f32,
    pub pairs: Vec<Pair>,
    pub batches: Batches,
    /// How far the regions of both may move relative to each other.
    pub allowance: Allowance,
    pub travelled: Travelled,
    /// Room for what both keep of pairs that touch, each its half.
    halves: [History; 2],
    /// Whether any pair has touched in the tick.
    pub has_touched: bool,
    /// What touched in the last substep.
    pub touched: Touched,
}

/// Cloths as they were when pairs were found.
#[derive(Clone, Copy)]
pub(super) struct Found<'a> {
    pub at: &'a Soa,
    /// Where each cloth's first slot is there.
    pub first: &'a [u32],
}

impl Couple {
    /// Begins a tick with what two cloths keep of each other, of which the first one has so many slots.
    pub fn recall(&mut self, [one, other]: [&mut OthersContact; 2], slots: usize) {
        match take_shared(&mut one.histories, &mut other.histories) {
            Some(halves) => {
                let pairs = halves[0].pairs.iter().zip(&halves[1].pairs);
                let pairs = pairs.map(|(a, b)| ([a.slot, b.slot], a.anchor));
                self.batches.take_anchors(slots, pairs);
                self.halves = halves;
            }
            None => self.batches.take_anchors(0, core::iter::empty()),
        }
    }

    /// Ends a tick: both keep the pairs that touch.
    pub fn remember(&mut self, bodies: &mut [impl Body]) {
        let halves = &mut self.halves;
        for half in &mut *halves {
            half.pairs.clear();
        }
        for (slots, anchor) in self.batches.anchored() {
            for ((half, slot), anchor) in halves.iter_mut().zip(slots).zip([anchor, -anchor]) {
                half.pairs.push(Stuck { slot, anchor });
            }
        }
        let [Some(first), Some(second)] = halves.each_ref().map(|half| half.pairs.first()) else {
            return;
        };
        let slots = [first.slot, second.slot];
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(one), Some(other)) = (one.parts(), other.parts()) else { return };
        let place = |parts: &Parts<'_>, slot: u32| parts.origin + parts.x.get(slot as usize);
        let stamp = stamp(halves, [place(&one, slots[0]), place(&other, slots[1])]);
        for (half, parts) in halves.iter_mut().zip([one, other]) {
            half.stamp = stamp;
            parts.others.histories.push(core::mem::take(half));
        }
    }

    /// Begins with the pairs that were found, of cloths that have so many slots.
    pub fn begin(&mut self, bodies: &mut [impl Body], margin: f32, slots: [usize; 2]) {
        self.batches.begin(&self.pairs, margin, slots);
        for (side, of) in self.of.into_iter().enumerate() {
            if let Some(parts) = bodies[of].parts() {
                self.pairs.iter().for_each(|pair| parts.others.beads.note(pair.slots[side]));
            }
        }
    }

    /// Looks what touches, before anything is moved apart in a substep.
    pub fn look(&mut self, bodies: &mut [impl Body]) {
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(one), Some(other)) = (one.parts(), other.parts()) else { return };
        one.isa.run_transposing(LookAtPairs {
            pairs: &self.pairs,
            batches: &mut self.batches,
            beads: [&one.others.beads, &other.others.beads],
            shift: one.origin - other.origin,
            travelled: self.travelled.most,
            step: self.travelled.step,
        });
    }

    /// Moves apart what touches.
    pub fn meet(&mut self, bodies: &mut [impl Body], found: Found<'_>) {
        self.touched = self.respond(bodies, found, 1.0);
        if self.touched.count == 0 {
            return;
        }
        self.has_touched = true;
        for of in self.of {
            if let Some(parts) = bodies[of].parts() {
                parts.others.since_touch = 0;
                parts.others.tangles.is_suspected |= self.touched.is_deep();
            }
        }
    }

    /// Whether layers are pressed into each other, which are to be kept apart after the strain limit.
    pub fn is_pressed(&self) -> bool {
        self.touched.is_pressed()
    }

    /// Keeps apart what the strain limit has pulled together, after it met in the same substep.
    pub fn keep_apart(&mut self, bodies: &mut [impl Body], found: Found<'_>) {
        self.respond(bodies, found, AT_LEAST);
    }

    /// Moves pairs apart to a part of the distance at which they touch.
    fn respond(&mut self, bodies: &mut [impl Body], found: Found<'_>, part: f32) -> Touched {
        let Found { at, first } = found;
        let nothing = Touched::default();
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return nothing };
        let (Some(mut one), Some(mut other)) = (one.parts(), other.parts()) else { return nothing };
        let (isa, shift) = (one.isa, one.origin - other.origin);
        let drift = one.drift - other.drift;
        let most_push = smaller(one.most_push, other.most_push);
        let [a, b] = self.of.map(|of| first[of]);
        isa.run_transposing(Respond {
            batches: &mut self.batches,
            sides: &mut [one.side(a, at), other.side(b, at)],
            shift,
            drift,
            friction: self.friction,
            most_push,
            part,
        })
    }

    pub fn search_tangles(&self, bodies: &mut [impl Body]) {
        let Ok([one, other]) = bodies.get_disjoint_mut(self.of) else { return };
        let (Some(one), Some(other)) = (one.parts(), other.parts()) else { return };
        let shift = one.origin - other.origin;
        let (here, tangles) = one.places();
        let (there, theirs) = other.places();
        for pair in &self.pairs {
            let at = |slot| here.at(slot);
            tangles.search_with(theirs, pair, (at, shift), |slot| there.at(slot));
        }
    }
}
