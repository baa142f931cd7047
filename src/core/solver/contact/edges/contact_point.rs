//! An edge or a face that a collider presses on.

use bevy_math::Vec3;

use crate::solver::contact::LEAST_SLIDING;
use crate::solver::contact::edges::body::Body;
use crate::solver::contact::edges::{HELD, HoldEdges, WarmStart};
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::Twist;
use crate::solver::simd::block::larger;
use crate::solver::simd::soa::Soa;

/// Cosine between the normal of an end and the way in, from which on it lies beyond the solid.
const BEYOND: f32 = 0.25;
/// An end goes at most this many times as far as the place of its edge that is moved.
const MOST_SHARE: f32 = 2.0;
/// Places that are looked at on a way of an end that is pushed by what is fast.
const LOOKS: u32 = 8;

/// A place on an edge or a face. Of an edge, the last corner is the first again and has no part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Slots of the corners; the first two ascend.
    pub corners: [u32; 3],
    /// Barycentric weights of the corners.
    pub parts: [f32; 3],
    /// The edge, where it is one.
    pub edge: Option<u32>,
}

impl Place {
    /// The place at a part of the way along an edge.
    #[inline(always)]
    pub fn on_edge(edge: u32, [a, b]: [usize; 2], at: f32) -> Self {
        let corners = [a, b, a].map(|slot| slot as u32);
        Self { corners, parts: [1.0 - at, at, 0.0], edge: Some(edge) }
    }

    /// Where something was expected.
    fn of(warm: &WarmStart) -> Self {
        Self { corners: warm.corners, parts: warm.parts, edge: None }
    }

    /// The value at the place, from those of the corners.
    pub fn between(&self, of: &Soa) -> Vec3 {
        let [a, b, c] = self.corners.map(|slot| of.get(slot as usize));
        a * self.parts[0] + b * self.parts[1] + c * self.parts[2]
    }

    /// The ends of an edge, or the corners of a face.
    pub fn corners(&self) -> &[u32] {
        &self.corners[..self.count()]
    }

    #[inline(always)]
    fn is_on_edge(&self) -> bool {
        self.corners[2] == self.corners[0]
    }

    #[inline(always)]
    fn count(&self) -> usize {
        if self.is_on_edge() { 2 } else { 3 }
    }
}

/// An edge or a face that a collider presses on. Ways are those of its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Press {
    pub place: Place,
    /// The corners' places among the bodies.
    pub bodies: [u32; 3],
    /// How far the corners go for a push of one.
    shares: [f32; 3],
    /// Impulse for a push of one \[kg\].
    pub mass: f32,
    /// How far the place is from the collider's centre, as the substep begins \[m\].
    pub arm: Vec3,
    /// Outward, of length one.
    pub normal: Vec3,
    /// How far the collider was planned to move there in the substep \[m\].
    planned: Vec3,
    /// How far it moves there, with what it has yielded up to now \[m\].
    surface: Vec3,
    /// Where the place is, before anything is moved \[m\].
    from: Vec3,
    /// How far it is to come out from there \[m\].
    pub depth: f32,
    /// Least way that it may go along the normal, beside the collider: what is left of the gap \[m\].
    pub least: f32,
    /// Longest push along the normal \[m\].
    pub most: f32,
    /// The push along the normal, up to now \[m\].
    pub push: f32,
    /// The push of friction, up to now \[m\].
    pub brake: Vec3,
    /// The push that it began with \[m\].
    began: Vec3,
    /// Whether it was expected.
    pub was_expected: bool,
}

impl Press {
    /// The corners' places among the bodies, their parts, and how far they go for a push of one.
    #[inline(always)]
    pub fn corners(&self) -> impl Iterator<Item = (usize, f32, f32)> {
        let count = self.place.count();
        (0..3).take(count).map(|i| (self.bodies[i] as usize, self.place.parts[i], self.shares[i]))
    }

    /// Notes how far the collider has yielded in the substep.
    #[inline(always)]
    pub fn follow(&mut self, yielded: &Twist) {
        self.surface = self.planned + yielded.at(self.arm);
    }

    /// How far the place goes in the substep, beside the collider \[m\].
    #[inline(always)]
    pub fn goes(&self, bodies: &[Body]) -> Vec3 {
        let mut goes = -self.surface;
        for (body, part, _) in self.corners() {
            goes += bodies[body].d * part;
        }
        goes
    }

    /// How far it is still inside \[m\].
    #[inline(always)]
    pub fn depth(&self, bodies: &[Body]) -> f32 {
        let mut goes = self.planned - self.surface - self.from;
        for (body, part, _) in self.corners() {
            goes += bodies[body].at() * part;
        }
        self.depth - goes.dot(self.normal)
    }

    /// The impulse that it has given the collider about its centre, times the substep.
    pub fn given(&self) -> Impulse {
        let by = self.began - self.normal * self.push - self.brake;
        Impulse::at(self.arm, by * self.mass)
    }

    /// Begins with the push that was expected, which the displacements have been given.
    fn begin_with(mut self, warm: &WarmStart) -> Self {
        let push = warm.impulse / self.mass;
        self.push = push.dot(self.normal);
        self.brake = push - self.normal * self.push;
        self.began = push;
        self.was_expected = true;
        self
    }
}

impl HoldEdges<'_> {
    /// Finds what the collider presses on, or was expected to, in the order of their corners.
    pub(super) fn find_pressed(&mut self, presses: &mut Vec<Press>) {
        presses.clear();
        let before = |warm: &WarmStart| (warm.collider as usize) < self.collider;
        let mut next = self.set.edges.warm.partition_point(before);
        let mut places = core::mem::take(&mut self.nearby.places);
        places.sort_unstable_by_key(|place| place.corners);
        for place in places.drain(..) {
            // Those that have left it since.
            while let Some(warm) = self.expected(next).filter(|warm| warm.corners < place.corners) {
                presses.extend(self.take_back(&warm));
                next += 1;
            }
            let warm = self.expected(next).filter(|warm| warm.corners == place.corners);
            next += usize::from(warm.is_some());
            let press = self.press(place, false);
            presses.extend(match (press, warm) {
                (Some(press), Some(warm)) => Some(press.begin_with(&warm)),
                (None, Some(warm)) => self.take_back(&warm),
                (press, None) => press,
            });
        }
        while let Some(warm) = self.expected(next) {
            presses.extend(self.take_back(&warm));
            next += 1;
        }
        self.nearby.places = places;
    }

    /// The next impulse that was expected of this collider, from a place in the list on.
    fn expected(&self, at: usize) -> Option<WarmStart> {
        let warm = self.set.edges.warm.get(at);
        warm.filter(|warm| warm.collider as usize == self.collider).copied()
    }

    /// Takes back the push that was expected at a place that is not pressed any more, as far as it is too much.
    fn take_back(&mut self, warm: &WarmStart) -> Option<Press> {
        Some(self.press(Place::of(warm), true)?.begin_with(warm))
    }

    /// Looks at a place; `None` where it is not to be moved. It is inside, unless it `was_expected` to be.
    fn press(&mut self, place: Place, was_expected: bool) -> Option<Press> {
        let (motion, settings) = (self.motion, self.settings);
        let Place { corners, parts, edge } = place;
        let slots = corners.map(|slot| slot as usize);
        let w = slots.map(|slot| self.inverse_mass[slot]);
        let mobility = (0..3).map(|i| parts[i] * parts[i] * w[i]).sum::<f32>();
        if mobility <= 0.0 {
            return None;
        }
        let moved = place.between(self.d);
        let from = place.between(self.x) + moved;
        let local = motion.after.to_local(from);
        let sample = motion.shape.sample(local);
        let depth = HELD * settings.epsilon - sample.distance * motion.after.scale;
        if depth.is_nan() || (depth <= 0.0 && !was_expected) {
            return None;
        }
        let outward = motion.after.rotate(sample.normal);
        let [a, b, c] = slots.map(|slot| self.x.get(slot) + self.d.get(slot));
        // At the nearest place the normal is across it, but for an end, where the way out is across it too. What a search is off by would
        // drive it along.
        let normal = if place.is_on_edge() {
            let along = b - a;
            let across = along * (outward.dot(along) / larger(along.dot(along), LEAST_SLIDING));
            (outward - across).normalize_or(outward)
        } else {
            let across = (b - a).cross(c - a);
            (across * outward.dot(across)).normalize_or(outward)
        };
        let memory = &self.set.edges;
        let passes = slots.iter().any(|&slot| memory.is_freed(slot, self.collider));
        // An end beyond the solid would be moved into it.
        let faces = |slot: usize| self.nearby.normal.get(slot).dot(normal);
        let is_beyond = slots.iter().any(|&slot| faces(slot) < -BEYOND);
        let length = (b - a).length();
        let is_hooked = edge.is_some_and(|edge| self.is_hooked(edge, depth, length, is_beyond));
        if is_hooked || passes || is_beyond {
            return None;
        }
        // A body yields to a push as well as the place does.
        let arm = place.between(self.x) - motion.centre[0];
        let mobility = mobility + self.mobility.map_or(0.0, |body| body.along(arm, normal));
        let planned = if motion.moves { from - motion.before.to_world(local) } else { Vec3::ZERO };
        let goes = (moved - planned).dot(normal);
        let shares: [f32; 3] = core::array::from_fn(|i| parts[i] * w[i] / mobility);
        // Next to an end that is held, the other would be thrown about.
        let share = shares.into_iter().fold(0.0, larger);
        let is_held = share > MOST_SHARE;
        let part = if is_held { MOST_SHARE / share } else { 1.0 };
        let shares = shares.map(|share| share * part);
        let least = -larger(-depth - goes, 0.0);
        // A push that moves the place by less is not to be made up for.
        let most = if is_held { larger(least - goes, 0.0) } else { f32::INFINITY };
        let mass = part / mobility;
        let (push, brake, began, was_expected) = (0.0, Vec3::ZERO, Vec3::ZERO, false);
        Some(Press {
            place,
            bodies: [0; 3],
            shares,
            mass,
            arm,
            normal,
            planned,
            surface: planned,
            from,
            depth,
            least,
            most,
            push,
            brake,
            began,
            was_expected,
        })
    }

    /// Whether what is fast would push a corner through itself, on a way that nothing looks at any more: by `push`, and out as far as
    /// it is then inside.
    pub(super) fn goes_through(&self, press: &Press, push: Vec3, bodies: &[Body]) -> bool {
        let motion = self.motion;
        // As far as where the collider is looked at, which has not yielded.
        let yielded = (press.surface - press.planned).dot(press.normal);
        let left = press.depth(bodies) - yielded - push.dot(press.normal);
        let push = push + press.normal * larger(left, 0.0);
        press.corners().any(|(body, _, share)| {
            let (from, way) = (bodies[body].x, bodies[body].d + push * share);
            let (from, to) = (motion.before.to_local(from), motion.after.to_local(from + way));
            let looks = (1..=LOOKS).map(|i| from.lerp(to, i as f32 / LOOKS as f32));
            looks.fold(f32::INFINITY, |least, at| least.min(motion.shape.distance(at))) < 0.0
        })
    }
}
