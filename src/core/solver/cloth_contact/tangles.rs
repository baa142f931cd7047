//! Tangles: faces that pierce each other. Their particles stand down, that is, no other pushes them.
//!
//! Balls keep layers on the sides that they are on. Where a cloth starts tangled, or was forced through itself, they would lock the
//! tangle in and shake it. What stands down can slip back, and meets others again once its faces pierce nothing.

use std::sync::Arc;

use bevy_math::{DVec3, Vec3};

use crate::solver::cloth_contact::crossings::pierces;
use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::rings::Rings;
use crate::solver::cloth_contact::{CALM, Memory};
use crate::solver::simd::block::{larger, smaller};
use crate::solver::topology::Topology;

/// Depth of a pair, in distances at which it touches, from which on its faces may pierce each other: layers that lie on each
/// other, and press, stay well below.
pub(super) const DEEP: f32 = 0.4;
/// Ticks from one search to the next, while there is a tangle or a suspicion.
const EVERY: u32 = 4;
/// Distance of the nearest corners of two faces that pierce each other, in distances at which they touch, at most: an edge and a
/// face of a square sheet meet within half an edge of the one and half a diagonal of the other, and threads are stretched.
const NEAR: f32 = 1.45;

/// Which particles stand down.
#[derive(Clone, Debug)]
pub(super) struct Tangles {
    pub faces: Arc<FacesAt>,
    /// By slot.
    pub is_down: Vec<bool>,
    /// Whether any particle stands down.
    pub any: bool,
    /// Whether any pair is so deep that there may be a tangle.
    pub is_suspected: bool,
    /// Ticks until the next search.
    pub wait: u32,
    rings: Rings,
}

impl Tangles {
    pub fn new(topology: &Topology, faces: Arc<FacesAt>) -> Self {
        let slots = topology.layout().len();
        let (is_down, rings) = (vec![false; slots], Rings::new(slots));
        Self { faces, is_down, any: false, is_suspected: true, wait: 0, rings }
    }

    /// Takes out all that later bits of tangles depend on. The rest is left as it is where nothing has touched.
    pub fn memory(&self) -> Memory {
        let Self { is_down, any: _, is_suspected, wait, faces: _, rings: _ } = self;
        Memory {
            found_at: None,
            since_touch: CALM,
            down: (0..is_down.len()).filter(|&slot| is_down[slot]).collect(),
            is_suspected: *is_suspected,
            wait: *wait,
            histories: Vec::new(),
        }
    }

    /// Takes over another's memory.
    pub fn remember(&mut self, memory: &Memory) {
        self.put_down(&memory.down);
        (self.is_suspected, self.wait) = (memory.is_suspected, memory.wait);
    }

    /// Lets the next tick search: particles have been put elsewhere.
    pub fn suspect(&mut self) {
        self.is_suspected = true;
        self.wait = 0;
    }

    /// Lets the particles of some slots stand down, and no others.
    pub fn put_down(&mut self, slots: &[usize]) {
        self.is_down.fill(false);
        for &slot in slots {
            self.is_down[slot] = true;
        }
        self.any = !slots.is_empty();
    }

    /// Begins a tick.
    pub fn begin_tick(&mut self) {
        self.wait = self.wait.saturating_sub(1);
    }

    /// Whether it is time to search.
    pub fn is_due(&self) -> bool {
        self.wait == 0 && (self.any || self.is_suspected)
    }

    /// Begins a search: none stands down until it is found to be tangled.
    pub fn begin_search(&mut self) {
        self.wait = EVERY;
        self.is_suspected = false;
        self.put_down(&[]);
        self.rings.forget();
    }

    /// Searches among the faces at two particles of the cloth's own that are a pair, where `at` says where particles are.
    pub fn search(&mut self, pair: &Pair, at: impl Fn(u32) -> Vec3 + Copy) {
        let [one, two] = pair.slots.map(|slot| self.rings.get(&self.faces, slot, at));
        if !one.may_meet(&two, two.at - one.at, pair.reach * NEAR) {
            return;
        }
        let faces = self.faces.clone();
        let shares = |one: &[u32; 3], two: &[u32; 3]| one.iter().any(|corner| two.contains(corner));
        for [one, two] in piercing([&faces, &faces], pair, at, at, shares) {
            self.stand_down(one);
            self.stand_down(two);
        }
    }

    /// Searches among the faces at two particles that are a pair, of which the second one is another cloth's. Either function tells
    /// where particles are; those of the first cloth are a shift further.
    pub fn search_with(
        &mut self,
        other: &mut Self,
        pair: &Pair,
        (at, shift): (impl Fn(u32) -> Vec3 + Copy, Vec3),
        there: impl Fn(u32) -> Vec3 + Copy,
    ) {
        let [a, b] = pair.slots;
        let one = self.rings.get(&self.faces, a, at);
        let two = other.rings.get(&other.faces, b, there);
        if !one.may_meet(&two, two.at - (one.at + shift), pair.reach * NEAR) {
            return;
        }
        let at = |slot| at(slot) + shift;
        let (faces, others) = (self.faces.clone(), other.faces.clone());
        for [one, two] in piercing([&faces, &others], pair, at, there, |_, _| false) {
            self.stand_down(one);
            other.stand_down(two);
        }
    }

    fn stand_down(&mut self, corners: [u32; 3]) {
        for slot in corners {
            self.is_down[slot as usize] = true;
        }
        self.any = true;
    }
}

/// The faces at two particles that pierce each other. Those that share a corner do not count.
fn piercing<'a>(
    [faces, others]: [&'a FacesAt; 2],
    pair: &Pair,
    at: impl Fn(u32) -> Vec3 + Copy + 'a,
    there: impl Fn(u32) -> Vec3 + Copy + 'a,
    shares: impl Fn(&[u32; 3], &[u32; 3]) -> bool + Copy + 'a,
) -> impl Iterator<Item = [[u32; 3]; 2]> + 'a {
    let [a, b] = pair.slots.map(|slot| slot as usize);
    let may = !are_apart(faces, a, at, others, b, there);
    let ones = may.then(|| faces.of(a)).into_iter().flatten();
    ones.flat_map(move |one| others.of(b).map(move |two| [one, two])).filter(move |[one, two]| {
        !shares(one, two) && meet(one.map(|c| at(c).as_dvec3()), two.map(|c| there(c).as_dvec3()))
    })
}

/// Whether a plane along the surface at one slot lies between all faces there and all faces at another.
fn are_apart(
    faces: &FacesAt,
    slot: usize,
    at: impl Fn(u32) -> Vec3 + Copy,
    others: &FacesAt,
    other: usize,
    there: impl Fn(u32) -> Vec3 + Copy,
) -> bool {
    let normal = faces.normal(slot, at);
    let [low, high] = range(faces, slot, normal, at);
    let [their_low, their_high] = range(others, other, normal, there);
    high < their_low || their_high < low
}

/// How far the faces at a slot reach along a direction.
fn range(faces: &FacesAt, slot: usize, direction: Vec3, at: impl Fn(u32) -> Vec3) -> [f32; 2] {
    let along = faces.of(slot).flatten().map(|corner| direction.dot(at(corner)));
    along.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], along| {
        [smaller(low, along), larger(high, along)]
    })
}

/// Whether an edge of either face pierces the other.
fn meet(one: [DVec3; 3], other: [DVec3; 3]) -> bool {
    let low = |face: [DVec3; 3]| face[0].min(face[1]).min(face[2]);
    let high = |face: [DVec3; 3]| face[0].max(face[1]).max(face[2]);
    if low(one).cmpgt(high(other)).any() || low(other).cmpgt(high(one)).any() {
        return false;
    }
    let edges = |[a, b, c]: [DVec3; 3]| [[a, b], [b, c], [c, a]];
    edges(one).into_iter().any(|edge| pierces(edge, other))
        || edges(other).into_iter().any(|edge| pierces(edge, one))
}
