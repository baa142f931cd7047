//! The way between: fast particles and fast colliders do not pass through each other.
//!
//! Seen from the collider, a particle goes straight from where it was to where it is. Sphere tracing
//! (Hart 1996) along that way finds the first place where it meets the surface. There the particle
//! loses what is left of its approach, keeps what is left of its sliding, less friction, and the rest
//! of its way is looked at again.

use bevy_math::Vec3;

use crate::solver::contact::collider::Motion;
use crate::solver::contact::push_out::Tally;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;

/// Places looked at on a way at most; no solid thinner than this part of it is met for certain.
const MOST_STEPS: u32 = 64;
/// Surfaces met on one way at most: in a corner, on to the next wall. At the last the particle stays.
const MOST_MEETINGS: u32 = 3;
/// Part of epsilon at which a surface is met.
const NEAR: f32 = 0.25;
/// Nearness that counts as contact for a cloth without thickness, as a part of the displacement.
const NEAR_ON_WAY: f32 = 1e-3;
/// Halvings of the last step, where it went in.
const HALVINGS: u32 = 16;

/// Looks at the ways of a block of particles past one collider.
pub(super) struct Sweep<'a> {
    pub motion: &'a Motion<'a>,
    /// Distance at which particles are held \[m\].
    pub epsilon: f32,
}

/// Where a way meets a surface.
struct Meeting {
    at: Vec3,
    /// Outward, of length one.
    normal: Vec3,
}

impl Sweep<'_> {
    /// Displacement up to which a particle does not pass the surface in the substep \[m\].
    #[inline(always)]
    pub fn slow(&self) -> f32 {
        (self.epsilon + self.motion.fast - self.motion.reach).max(0.0)
    }

    /// Changes the displacements of particles that would pass through the surface, and adds what the
    /// collider is given of their momentum, times the substep, to the `tally`. Tells whether there were any.
    ///
    /// Scalar, and never inlined: this is for the few that are fast.
    #[inline(never)]
    pub fn block(&self, w: &Block, x: &Block3, d: &mut Block3, tally: &mut Tally) -> bool {
        let mut met = false;
        let slow = self.epsilon + self.motion.fast;
        for lane in 0..LANES {
            let w = w.0[lane];
            if w <= 0.0 {
                continue;
            }
            let (start, way) = (x.at(lane), d.at(lane));
            let reach = way.dot(way).sqrt() + self.motion.reach;
            if reach <= slow {
                continue;
            }
            let from = self.motion.before.to_local(start);
            let to = self.motion.after.to_local(start + way);
            if let Some(end) = self.follow(from, to) {
                let changed = self.motion.after.to_world(end) - (start + way);
                d.set(lane, way + changed);
                met = true;
                if self.motion.measured {
                    let arm = start - self.motion.centre[0];
                    tally.give(lane, arm, changed / -w, Vec3::ZERO);
                }
            }
        }
        met
    }

    /// Where a particle ends, in the collider's frame, that would go from `from` to `to`; `None`
    /// where nothing is in its way.
    fn follow(&self, from: Vec3, to: Vec3) -> Option<Vec3> {
        let epsilon = self.epsilon / self.motion.after.scale;
        let (mut from, mut to) = (from, to);
        let mut end = None;
        for _ in 0..MOST_MEETINGS {
            // A short way ends where contact sees it.
            let way = to - from;
            if way.dot(way) <= epsilon * epsilon {
                return end;
            }
            let Some(Meeting { at, normal }) = self.trace(from, way) else {
                return end;
            };
            let rest = to - at;
            // Met at the way's very end, what is left may lead away again by rounding: then nothing is lost.
            let approach = (-rest.dot(normal)).max(0.0);
            let tangential = rest + normal * approach;
            let sliding = tangential.dot(tangential).sqrt();
            let braked = self.motion.friction * approach;
            let kept = if sliding > braked { 1.0 - braked / sliding } else { 0.0 };
            from = at;
            to = at + tangential * kept;
            end = Some(to);
        }
        Some(from)
    }

    /// The first place on a way where it goes into the surface.
    fn trace(&self, from: Vec3, way: Vec3) -> Option<Meeting> {
        let length = way.dot(way).sqrt();
        let scale = self.motion.after.scale;
        let near =
            if self.epsilon > 0.0 { NEAR * self.epsilon / scale } else { NEAR_ON_WAY * length };
        let overestimate = self.motion.overestimate / scale;
        let shortest = length / MOST_STEPS as f32;
        let distance = |t: f32| self.motion.shape.distance(from + way * t);
        let first = distance(0.0);
        if first.is_nan() || first <= 0.0 {
            // Inside already: contact pushes it out.
            return None;
        }
        let meeting = |t: f32| {
            let at = from + way * t;
            Meeting { at, normal: self.motion.shape.sample(at).normal }
        };
        let (mut t, mut here) = (0.0, first);
        while t < 1.0 {
            let step = (here - overestimate).max(shortest) / length;
            let next = (t + step).min(1.0);
            let there = distance(next);
            if there <= near {
                let last = if there < 0.0 { last_outside(t, next, distance) } else { next };
                let met = meeting(last);
                if way.dot(met.normal) < 0.0 {
                    return Some(met);
                }
                if there < 0.0 {
                    // It went in, whatever the normal says of where it did.
                    return Some(Meeting { normal: way / -length, ..met });
                }
            }
            (t, here) = (next, there);
        }
        None
    }
}

/// The last place of a way before it goes in, between one outside and one inside.
fn last_outside(outside: f32, inside: f32, distance: impl Fn(f32) -> f32) -> f32 {
    let (mut outside, mut inside) = (outside, inside);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (outside + inside);
        if distance(middle) < 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    outside
}
