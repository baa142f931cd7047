//! Pairs in batches, of which no two share a particle: the pairs of a batch are met side by side, as the lanes of blocks.
//!
//! Pairs that were nearest when they were found come first. Batches are made of no more of them than are awake. A batch that was
//! looked at, and did not touch, sleeps until the path that particles have come since is as long as its least gap was.

use bevy_math::Vec3;

use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::friction::Anchors;
use crate::solver::cloth_contact::history::AnchorTable;
use crate::solver::simd::block::{Block, smaller};
use crate::solver::simd::lanes::LANES;

/// Steps in which pairs are sorted by their gaps.
const STEPS: usize = 16;

/// Pairs that share no particle. A lane without a pair has a reach of zero.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Slots of the first particles, and of the second ones.
    pub slots: [[u32; LANES]; 2],
    /// Distances at which they touch \[m\].
    pub reach: Block,
    /// Where pairs of two cloths that touch began to.
    pub anchors: Anchors,
}

/// The part of a batch that is asked for before it is looked at. The rest takes some cache lines.
#[derive(Clone, Copy, Debug)]
struct State {
    /// Length of the path until which none of its pairs touches \[m\]; [`TOUCHES`] where one did when it was looked at last.
    until: f32,
    /// How many lanes hold a pair.
    count: u32,
}

/// Where a batch touches.
const TOUCHES: f32 = f32::NEG_INFINITY;
/// How much longer a path becomes in each step, in the gaps up to which there are pairs: more than rounding loses of it.
const LOST: f32 = 1e-7;

/// A batch that may touch.
pub(super) struct Awake<'a> {
    pub batch: &'a mut Batch,
    state: &'a mut State,
    path: f32,
}

/// Pairs of one cloth, or of two.
#[derive(Clone, Debug, Default)]
pub(super) struct Batches {
    all: Vec<Batch>,
    states: Vec<State>,
    /// Batches before this one are full.
    first_free: usize,
    /// Pairs by their gaps, and where each step of them ends.
    order: Vec<u32>,
    ends: [usize; STEPS + 1],
    /// How many of them are in batches.
    made: usize,
    /// Gap up to which there are pairs \[m\].
    margin: f32,
    /// Length of the path that particles have come relative to each other, since a moment before the last batch was looked at \[m\].
    path: f32,
    /// By particle, the batch after the last one that it is in. Those of a second cloth come after those of the first.
    next: Vec<u32>,
    /// Where those of a second cloth begin.
    second: usize,
    /// The anchors that pairs of two cloths are put into batches with.
    anchors: AnchorTable,
}

impl Batches {
    /// Begins anew with pairs that have gaps of up to `margin`, of cloths that have so many slots; none where both are the same cloth.
    pub fn begin(&mut self, pairs: &[Pair], margin: f32, [slots, others]: [usize; 2]) {
        self.all.clear();
        self.states.clear();
        (self.first_free, self.made, self.margin, self.path) = (0, 0, margin, 0.0);
        self.next.clear();
        self.next.resize(slots + others, 0);
        self.second = if others > 0 { slots } else { 0 };
        self.sort(pairs);
    }

    /// Lets pairs that are put into batches from now on have some anchors, and no others; `slots` is how many the first cloth has.
    pub fn take_anchors(
        &mut self,
        slots: usize,
        anchors: impl Iterator<Item = ([u32; 2], Vec3)> + Clone,
    ) {
        self.anchors.fill(slots, anchors);
    }

    /// Lets pairs that are put into batches from now on have the anchors that they have now.
    pub fn keep_anchors(&mut self, slots: usize) {
        let Self { all, anchors, .. } = self;
        anchors.fill(slots, anchored(all));
    }

    /// The pairs that touch and have anchors: their slots, and the anchor from the second particle to the first \[m\].
    pub fn anchored(&self) -> impl Iterator<Item = ([u32; 2], Vec3)> + Clone {
        anchored(&self.all)
    }

    /// Sorts pairs by their gaps, in steps; within a step they keep their order.
    fn sort(&mut self, pairs: &[Pair]) {
        let Self { order, ends, margin, .. } = self;
        ends.fill(0);
        for pair in pairs {
            ends[step_of(pair.gap, *margin)] += 1;
        }
        let mut before = 0;
        for end in ends.iter_mut() {
            (*end, before) = (before, before + *end);
        }
        order.clear();
        order.resize(pairs.len(), 0);
        for (at, pair) in pairs.iter().enumerate() {
            let end = &mut ends[step_of(pair.gap, *margin)];
            order[*end] = at as u32;
            *end += 1;
        }
    }

    /// The batches of pairs that may touch, where particles have moved so far relative to each other since pairs were found, and since
    /// this was asked before. Each is to be told whether it touches.
    pub fn awake(
        &mut self,
        pairs: &[Pair],
        travelled: f32,
        step: f32,
    ) -> impl Iterator<Item = Awake<'_>> {
        let end = self.ends[step_of(travelled, self.margin)];
        for at in self.made..end {
            self.put(&pairs[self.order[at] as usize]);
        }
        self.made = self.made.max(end);
        self.path += step + self.margin * LOST;
        if self.path > 2.0 * self.margin {
            // A short path is an exact one.
            for state in &mut self.states {
                state.until -= self.path;
            }
            self.path = 0.0;
        }
        let path = self.path;
        let batches = self.states.iter_mut().zip(&mut self.all);
        let may_touch = batches.filter(move |(state, _)| state.until <= path);
        may_touch.map(move |(state, batch)| Awake { batch, state, path })
    }

    /// The batches that touched when they were looked at last.
    pub fn touching(&mut self) -> impl Iterator<Item = &mut Batch> {
        let batches = self.states.iter().zip(&mut self.all);
        batches.filter(|(state, _)| state.until == TOUCHES).map(|(_, batch)| batch)
    }

    /// Puts a pair into the first batch that has room for it, after all that hold one of its particles.
    fn put(&mut self, pair: &Pair) {
        let Self { all, states, first_free, next, second, anchors, path, .. } = self;
        let particles = [pair.slots[0] as usize, *second + pair.slots[1] as usize];
        let [a, b] = particles.map(|particle| next[particle] as usize);
        let is_full = |state: &State| state.count == LANES as u32;
        let mut at = (*first_free).max(a).max(b);
        while states.get(at).is_some_and(is_full) {
            at += 1;
        }
        if at == all.len() {
            all.push(Batch::EMPTY);
            states.push(State { until: f32::INFINITY, count: 0 });
        }
        let state = &mut states[at];
        all[at].put(state.count as usize, pair, anchors.get(pair.slots));
        // It wakes.
        state.until = smaller(*path, state.until);
        state.count += 1;
        for particle in particles {
            next[particle] = at as u32 + 1;
        }
        while states.get(*first_free).is_some_and(is_full) {
            *first_free += 1;
        }
    }
}

/// The pairs of batches that have anchors.
fn anchored(all: &[Batch]) -> impl Iterator<Item = ([u32; 2], Vec3)> + Clone {
    all.iter().flat_map(Batch::anchored)
}

/// The step of a gap; the first one is of pairs that touch.
#[inline(always)]
fn step_of(gap: f32, margin: f32) -> usize {
    let part = gap / margin * STEPS as f32;
    if part > 0.0 { (part as usize + 1).min(STEPS) } else { 0 }
}

impl Awake<'_> {
    /// It touches, and is awake in the next substep.
    #[inline(always)]
    pub fn touches(self) {
        self.state.until = TOUCHES;
    }

    /// None of its pairs touches before particles have come by a gap further.
    #[inline(always)]
    pub fn sleeps(self, gap: f32) {
        self.state.until = self.path + gap;
    }
}

impl Batch {
    /// Its pairs that have anchors.
    fn anchored(&self) -> impl Iterator<Item = ([u32; 2], Vec3)> + Clone {
        // A lane without a pair has no anchor.
        let pair = |i: usize| self.slots.map(|slots| slots[i]);
        (0..LANES).filter_map(move |i| Some((pair(i), self.anchors.get(i)?)))
    }

    const EMPTY: Self = Self { slots: [[0; LANES]; 2], reach: Block::ZERO, anchors: Anchors::NONE };

    /// Puts a pair into a lane.
    fn put(&mut self, lane: usize, pair: &Pair, anchor: Option<Vec3>) {
        for (slots, slot) in self.slots.iter_mut().zip(pair.slots) {
            slots[lane] = slot;
        }
        self.reach.0[lane] = pair.reach;
        if let Some(anchor) = anchor {
            self.anchors.set(lane, anchor);
        }
    }
}
