//! Threads that a collider is hooked in are let through.
//!
//! Where a fast collider has pierced the cloth, no particle is inside it: a thread spans it from side to side, each end is
//! held outside on its own side, and nothing would ever undo that. So the ends of such an edge pass through the
//! collider, and the thread pulls them to one side. They pass until they are outside and their threads are short again, or short for
//! so long that nothing pulls them out. What their threads are still long to, and what touches the collider there, passes with them.

use bevy_math::Vec3;

use crate::solver::contact::LEAST_SLIDING;
use crate::solver::contact::edges::{EdgeMemory, Freed, HELD, HoldEdges};
use crate::solver::contact::impulse::Impulse;
use crate::solver::simd::block::larger;

/// Strain beyond which an edge inside a collider is hooked in it, and how many times the strain limit it is at least.
const HOOKED_STRAIN: f32 = 1.0;
const HOOKED_LIMITS: f32 = 4.0;
/// Strain beyond which a thread is hooked that would be moved further in at one end, however thin the collider is, and how many
/// times the strain limit it is at least.
const THROUGH_STRAIN: f32 = 0.2;
const THROUGH_LIMITS: f32 = 2.0;
/// Multiple of the length of a hooked edge from which on one is hooked in a body that the cloth moves.
const CARRYING: f32 = 2.5;
/// Strain of a thread from which on its ends pass on, and how many times the strain limit it is at least.
const PASSING_STRAIN: f32 = 0.1;
const PASSING_LIMITS: f32 = 1.05;
/// How long a particle passes on whose threads are short \[s\].
const PASSING_TIME: f32 = 0.5;
/// How deep in a collider an edge is hooked, as a multiple of epsilon.
const HOOKED_DEPTH: f32 = 2.0;

impl HoldEdges<'_> {
    /// Particles that pass through the collider go on doing so until they are out of it. Their edges are looked at, though
    /// they may be inside. Returns what the collider is given as it slows them down, times the substep \[kg m\].
    pub(super) fn keep_passing(&mut self) -> Impulse {
        let longest = 1.0 + (PASSING_LIMITS * self.max_strain).max(PASSING_STRAIN);
        let (collider, epsilon) = (self.collider as u32, self.settings.epsilon);
        let EdgeMemory { freed, next_freed, .. } = &mut self.set.edges;
        let mine = freed.iter().filter(|freed| freed.collider == collider);
        for &Freed { slot, left, .. } in mine.clone() {
            // Infinite where nothing is known: it is far away.
            let gap = self.nearby.gap[slot as usize];
            if gap == f32::INFINITY {
                continue;
            }
            let here = self.x.get(slot as usize) + self.d.get(slot as usize);
            let mut is_pulled = false;
            self.edges.visit_threads(slot as usize, |other, rest| {
                let way = self.x.get(other) + self.d.get(other) - here;
                let bound = longest * rest;
                if way.dot(way) <= bound * bound {
                    return;
                }
                is_pulled = true;
                if self.nearby.gap[other] < epsilon {
                    next_freed.push(Freed { slot: other as u32, collider, left: PASSING_TIME });
                }
            });
            let left = if is_pulled { PASSING_TIME } else { left - self.settings.step };
            if is_pulled || (gap < 0.0 && left > 0.0) {
                next_freed.push(Freed { slot, collider, left });
            }
        }
        let mut given = Impulse::ZERO;
        for i in 0..self.set.edges.freed.len() {
            let Freed { slot, collider: of, .. } = self.set.edges.freed[i];
            let slot = slot as usize;
            if of == collider && self.nearby.gap[slot] < f32::INFINITY {
                self.nearby.gap[slot] = 0.0;
                let w = self.inverse_mass[slot];
                // What is pinned goes where its pin does.
                if w > 0.0 {
                    let arm = self.x.get(slot) - self.motion.centre[0];
                    given += Impulse::at(arm, self.slow_down(slot) / -w);
                }
            }
        }
        given
    }

    /// Slows a particle that passes through a collider to the speed of what is pushed out of one: the threads that were
    /// stretched by that would make it a shot. Beside a collider that moves it may be faster by the collider's own speed, which
    /// lets it stay behind. Returns by how much its displacement changes \[m\].
    fn slow_down(&mut self, slot: usize) -> Vec3 {
        let motion = self.motion;
        let d = self.d.get(slot);
        let at = self.x.get(slot) + d;
        let moved = at - motion.before.to_world(motion.after.to_local(at));
        let surface = if motion.moves { moved } else { Vec3::ZERO };
        let relative = d - surface;
        let way = larger(relative.length(), LEAST_SLIDING);
        let most = self.settings.most_push + surface.length();
        let by = -relative * larger(1.0 - most / way, 0.0);
        self.displace(slot, by);
        by
    }

    /// Whether an edge is hooked that is so deep inside the collider and so long: its ends pass from the next substep on. One
    /// that `is_beyond` has an end that the way out of the collider would lead further in.
    pub(super) fn is_hooked(
        &mut self,
        edge: u32,
        depth: f32,
        length: f32,
        is_beyond: bool,
    ) -> bool {
        let yields = self.motion.yields;
        let (least, strain, limits) = if is_beyond && !yields && self.edges.is_thread(edge) {
            (HELD, THROUGH_STRAIN, THROUGH_LIMITS)
        } else {
            (HOOKED_DEPTH, HOOKED_STRAIN, HOOKED_LIMITS)
        };
        let longest = 1.0 + (limits * self.max_strain).max(strain);
        // A body that a cloth carries may stretch threads as far, and goes where they pull it.
        let longest = if yields { CARRYING * longest } else { longest };
        let hooked = self.rule.is_slow
            && depth > least * self.settings.epsilon
            && length > longest * self.edges.rest(edge);
        if hooked {
            let collider = self.collider as u32;
            let freed = |slot| Freed { slot: slot as u32, collider, left: PASSING_TIME };
            let ends = self.edges.ends(edge).map(freed);
            self.set.edges.next_freed.extend(ends);
        }
        hooked
    }
}
