//! Pressed edges are solved together, by sequential impulses: each in turn is given what it lacks or has too much of, up to
//! now (Catto 2005, *Iterative Dynamics with Temporal Coherence*). The strain limit of the threads that meet at their ends
//! is solved with them: what is pulled over a tip has to lift the cloth, and must not be stretched over it.

use bevy_math::Vec3;

use super::super::super::lanes::larger;
use super::super::{BLOW, LEAST_SLIDING};
use super::press::Press;
use super::{EdgesHeld, HoldEdges, WarmStart};

/// Rounds of the solution.
const ROUNDS: usize = 6;
/// Part of an impulse that is expected again in the next substep.
const EXPECTED: f32 = 0.75;
/// Part of the strain limit that threads beside pressed edges are held to, as other corrections follow, and from which on
/// they are looked at.
const LIMIT: f32 = 0.75;
const STRAINED: f32 = 0.25;
/// Part of Coulomb's limit up to which an edge is braked that turns about where it is held.
const TURNING: f32 = 0.6;

/// Inverse mass that stands for that of what is held \[1/kg\].
const LEAST_INVERSE_MASS: f32 = 1e-12;

/// A thread that meets the end of a pressed edge, and is to be held to the strain limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limited {
    /// Slots of its ends.
    ends: [u32; 2],
    /// Longest that it may be \[m\].
    longest: f32,
}

/// Where a particle was before edges were held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    slot: u32,
    from: Vec3,
}

impl HoldEdges<'_> {
    /// Solves for all of them, and remembers what is to be expected.
    pub(super) fn solve(&mut self, presses: &mut [Press]) -> EdgesHeld {
        let mut held = EdgesHeld::default();
        if presses.is_empty() {
            return held;
        }
        let mut moved = core::mem::take(&mut self.nearby.moved);
        let mut limited = core::mem::take(&mut self.nearby.limited);
        self.note_ends(presses, &mut moved);
        // What is fast is met once, as what moves is looked at on its way.
        let rounds = if self.is_slow() { ROUNDS } else { 1 };
        for round in 0..rounds {
            // What the first pushes stretch is among them.
            if round == 1 {
                self.find_limited(&mut limited, &mut moved);
            }
            for thread in &limited {
                self.limit(thread);
            }
            for press in &mut *presses {
                held.given -= self.push(press);
            }
        }
        for press in &*presses {
            self.move_out(press);
            self.brake_turning(press);
            self.expect(press);
        }
        held.touching = self.count_touching(presses);
        for Moved { slot, from } in moved.drain(..) {
            held.pushed = larger((self.at(slot as usize) - from).length(), held.pushed);
        }
        limited.clear();
        (self.nearby.moved, self.nearby.limited) = (moved, limited);
        held
    }

    /// Where a particle is to be.
    fn at(&self, slot: usize) -> Vec3 {
        self.x.get(slot) + self.d.get(slot)
    }

    /// Notes where the ends are, each once, ascending.
    fn note_ends(&self, presses: &[Press], moved: &mut Vec<Moved>) {
        let slots = presses.iter().flat_map(Press::corners);
        moved.extend(slots.map(|&slot| Moved { slot, from: self.at(slot as usize) }));
        moved.sort_unstable_by_key(|moved| moved.slot);
        moved.dedup_by_key(|moved| moved.slot);
    }

    /// Finds the threads at the ends that the first pushes have stretched too far, and notes where their other ends are. No
    /// thread is made shorter than it was before.
    fn find_limited(&self, limited: &mut Vec<Limited>, moved: &mut Vec<Moved>) {
        let strained = 1.0 + STRAINED * self.max_strain;
        let limit = 1.0 + LIMIT * self.max_strain;
        let ends = moved.len();
        for i in 0..ends {
            let Moved { slot, from } = moved[i];
            let here = self.at(slot as usize);
            self.edges.visit_threads(slot as usize, |other, rest| {
                let there = self.at(other);
                if here.distance_squared(there) <= (strained * rest) * (strained * rest) {
                    return;
                }
                let end = moved[..ends].binary_search_by_key(&(other as u32), |it| it.slot);
                let other_from = end.map_or(there, |end| moved[end].from);
                if end.is_err() {
                    moved.push(Moved { slot: other as u32, from: there });
                }
                // One between two ends is met twice.
                if end.is_err() || (slot as usize) < other {
                    let longest = larger(limit * rest, from.distance(other_from));
                    limited.push(Limited { ends: [slot, other as u32], longest });
                }
            });
        }
    }

    /// Holds a thread to its limit.
    fn limit(&mut self, thread: &Limited) {
        let [a, b] = thread.ends.map(|slot| slot as usize);
        let way = self.at(b) - self.at(a);
        let length = way.dot(way).sqrt();
        let w = [self.inverse_mass[a], self.inverse_mass[b]];
        let all = w[0] + w[1];
        if length <= thread.longest || all == 0.0 {
            return;
        }
        let by = way * ((length - thread.longest) / (length * all));
        self.displace(a, by * w[0]);
        self.displace(b, by * -w[1]);
    }

    /// Gives an edge what it lacks of the push along the normal and of friction, or takes back what it has too much of. Returns
    /// the impulse, times the substep.
    fn push(&mut self, press: &mut Press) -> Vec3 {
        let goes = press.goes(self.d);
        let along = goes.dot(press.normal);
        let push = larger(press.push + press.least - along, 0.0);
        let push = if push < press.most { push } else { press.most };
        let most = self.motion.friction * push;
        let brake = press.brake - (goes - press.normal * along);
        let length = larger(brake.dot(brake).sqrt(), LEAST_SLIDING);
        let brake = brake * if most < length { most / length } else { 1.0 };
        let by = press.normal * (push - press.push) + (brake - press.brake);
        if !self.is_slow() && self.goes_through(press, by) {
            press.depth = 0.0;
            return Vec3::ZERO;
        }
        (press.push, press.brake) = (push, brake);
        for (slot, share) in press.shares() {
            self.displace(slot, by * share);
        }
        by * press.mass
    }

    /// Moves an edge out as far as it is still inside. It gets no speed by that.
    fn move_out(&mut self, press: &Press) {
        let depth = press.depth(self.x, self.d);
        let leaves = larger(press.goes(self.d).dot(press.normal), 0.0);
        let allowed = larger(self.skin.most_push - leaves, 0.0);
        let depth = larger(if depth < allowed { depth } else { allowed }, 0.0);
        for (slot, share) in press.shares() {
            self.x.set(slot, self.x.get(slot) + press.normal * (depth * share));
        }
    }

    /// Brakes the turning of an edge or a face about where it is held, which nothing else stops.
    fn brake_turning(&mut self, press: &Press) {
        if !self.is_slow() {
            return;
        }
        let along = |slot: u32| press.normal.dot(self.d.get(slot as usize));
        let mass = |slot: u32| 1.0 / larger(self.inverse_mass[slot as usize], LEAST_INVERSE_MASS);
        let (mut all, mut momentum) = (0.0, 0.0);
        for &slot in press.corners() {
            all += mass(slot);
            momentum += mass(slot) * along(slot);
        }
        let mean = momentum / all;
        // Half of what each goes beside the others, as far as friction does it.
        let turning = |slot: u32| 0.5 * mass(slot) * (along(slot) - mean);
        let largest =
            press.corners().iter().fold(0.0, |most, &slot| larger(turning(slot).abs(), most));
        let most = TURNING * self.motion.friction * press.push * press.mass;
        let part = if largest > most { most / largest } else { 1.0 };
        let mut by = [0.0; 3];
        for (by, &slot) in by.iter_mut().zip(press.corners()) {
            *by = -part * turning(slot) * self.inverse_mass[slot as usize];
        }
        for (by, &slot) in by.into_iter().zip(press.corners()) {
            self.displace(slot as usize, press.normal * by);
        }
    }

    /// Remembers what is to be expected of an edge in the next substep. Of what is struck, nothing is.
    fn expect(&mut self, press: &Press) {
        if press.push <= 0.0 || !self.is_slow() {
            return;
        }
        let blow = press.push * self.skin.per_weight * (1.0 / BLOW);
        let struck = if press.was_expected { 0.0 } else { blow * blow };
        let push = press.normal * press.push + press.brake;
        self.set.edges.next_warm.push(WarmStart {
            collider: self.collider as u32,
            corners: press.place.corners,
            parts: press.place.parts,
            impulse: push * (press.mass * EXPECTED / (1.0 + struck)),
        });
    }

    /// How many ends are held that do not lie on a collider by themselves.
    fn count_touching(&mut self, presses: &[Press]) -> u32 {
        let counted = &mut self.nearby.counted;
        let pressed = presses.iter().filter(|press| press.push > 0.0);
        counted.extend(pressed.flat_map(Press::corners));
        counted.sort_unstable();
        counted.dedup();
        let next = &self.set.next.normal;
        let touching = counted.drain(..).filter(|&slot| next.get(slot as usize) == Vec3::ZERO);
        touching.count() as u32
    }

    /// Moves a particle with its velocity.
    fn displace(&mut self, slot: usize, by: Vec3) {
        self.d.set(slot, self.d.get(slot) + by);
        // It is no pull of the cloth.
        self.set.unpulled.set(slot, self.set.unpulled.get(slot) + by);
        if let Some(pull) = &mut self.pull {
            pull.set(slot, pull.get(slot) - by);
        }
    }
}
