//! Tangles: faces that pierce each other. Their particles stand down, that is, no other pushes them.
//!
//! Balls keep layers on the sides that they are on. Where a cloth starts tangled, or was forced through itself, they would lock the
//! tangle in and shake it. What stands down can slip back, and meets others again once its faces pierce nothing.

use bevy_math::DVec3;

use crate::solver::self_contact::crossings::pierces;
use crate::solver::self_contact::faces::FacesAt;
use crate::solver::self_contact::find::Pair;
use crate::solver::simd::soa::Soa;
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
    pub faces: FacesAt,
    /// By slot.
    pub is_down: Vec<bool>,
    /// Whether any particle stands down.
    pub any: bool,
    /// Whether any pair is so deep that there may be a tangle.
    pub is_suspected: bool,
    /// Ticks until the next search.
    pub wait: u32,
}

impl Tangles {
    pub fn new(topology: &Topology) -> Self {
        let is_down = vec![false; topology.layout().len()];
        let faces = FacesAt::new(topology);
        Self { faces, is_down, any: false, is_suspected: true, wait: 0 }
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

    /// Searches among the faces at pairs that are near each other, where particles are at `x + d`.
    pub fn search(&mut self, pairs: &[Pair], x: &Soa, d: &Soa) {
        self.wait = EVERY;
        self.is_suspected = false;
        self.put_down(&[]);
        for pair in pairs {
            let [a, b] = pair.slots.map(|slot| slot as usize);
            let apart = x.get(a) - x.get(b) + (d.get(a) - d.get(b));
            let near = pair.reach * NEAR;
            if apart.dot(apart) < near * near {
                self.search_at([a, b], x, d);
            }
        }
    }

    fn search_at(&mut self, slots: [usize; 2], x: &Soa, d: &Soa) {
        let [here, there] = slots;
        for one in self.faces.of(here) {
            for other in self.faces.of(there) {
                if one.iter().any(|corner| other.contains(corner)) {
                    continue;
                }
                let place = |slot: u32| (x.get(slot as usize) + d.get(slot as usize)).as_dvec3();
                if meet(one.map(place), other.map(place)) {
                    for slot in one.into_iter().chain(other) {
                        self.is_down[slot as usize] = true;
                    }
                    self.any = true;
                }
            }
        }
    }
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
