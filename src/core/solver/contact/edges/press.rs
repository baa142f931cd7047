//! An edge that a collider presses on.

use bevy_math::Vec3;

use super::super::super::lanes::{Soa, larger};
use super::super::LEAST_SLIDING;
use super::{HELD, HoldEdges, WarmStart};

/// Cosine between the normal of an end and the way in, from which on it lies beyond the solid.
const BEYOND: f32 = 0.25;
/// An end goes at most this many times as far as the place of its edge that is moved.
const MOST_SHARE: f32 = 2.0;
/// Places that are looked at on a way of an end that is pushed by what is fast.
const LOOKS: u32 = 8;

/// An edge that a collider presses on at a place of it. Ways are those of that place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Press {
    /// Slots of its ends, the lower one first.
    pub ends: [usize; 2],
    /// Parts of the ends in the place.
    pub parts: [f32; 2],
    /// How far the ends go for a push of one.
    pub shares: [f32; 2],
    /// Impulse for a push of one \[kg\].
    pub mass: f32,
    /// Outward, of length one.
    pub normal: Vec3,
    /// How far the collider moves there in the substep \[m\].
    pub surface: Vec3,
    /// Where the place is, before anything is moved \[m\].
    pub place: Vec3,
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
    /// Whether it was expected.
    pub was_expected: bool,
}

impl Press {
    /// What is between the values of the ends.
    pub fn between(&self, of: &Soa) -> Vec3 {
        of.get(self.ends[0]) * self.parts[0] + of.get(self.ends[1]) * self.parts[1]
    }

    /// How far the place goes in the substep, beside the collider \[m\].
    pub fn goes(&self, d: &Soa) -> Vec3 {
        self.between(d) - self.surface
    }

    /// Begins with the push that was expected, which the displacements have been given.
    fn begin_with(&mut self, warm: &WarmStart) {
        let push = warm.impulse / self.mass;
        self.push = push.dot(self.normal);
        self.brake = push - self.normal * self.push;
        self.was_expected = true;
    }
}

impl HoldEdges<'_> {
    /// The edges that the collider presses on, or was expected to, in the order of their ends.
    pub(super) fn presses(&mut self) -> Vec<Press> {
        let mut presses = core::mem::take(&mut self.nearby.presses);
        presses.clear();
        let from = |warm: &WarmStart| (warm.collider as usize) < self.collider;
        let first = self.set.edges.warm.partition_point(from);
        let mut next = first;
        let places = core::mem::take(&mut self.nearby.places);
        for &(edge, at) in &places {
            let ends = self.edges.ends(edge).map(|slot| slot as u32);
            // Those that have left it since.
            while let Some(warm) = self.expected(next).filter(|warm| warm.ends < ends) {
                presses.extend(self.take_back(&warm));
                next += 1;
            }
            let warm = self.expected(next).filter(|warm| warm.ends == ends);
            next += usize::from(warm.is_some());
            match (self.press(edge, at, false), warm) {
                (Some(press), None) => presses.push(press),
                (Some(mut press), Some(warm)) => {
                    press.begin_with(&warm);
                    presses.push(press);
                }
                (None, Some(warm)) => presses.extend(self.take_back(&warm)),
                (None, None) => {}
            }
        }
        while let Some(warm) = self.expected(next) {
            presses.extend(self.take_back(&warm));
            next += 1;
        }
        self.nearby.places = places;
        self.nearby.places.clear();
        presses
    }

    /// What was expected of this collider, from a place in the list on.
    fn expected(&self, at: usize) -> Option<WarmStart> {
        let warm = self.set.edges.warm.get(at);
        warm.filter(|warm| warm.collider as usize == self.collider).copied()
    }

    /// An edge that was expected to be pressed and is not any more: the push is taken back as far as it is too much.
    fn take_back(&mut self, warm: &WarmStart) -> Option<Press> {
        let edge = self.edges.between(warm.ends)?;
        let mut press = self.press(edge, warm.at, true)?;
        press.begin_with(warm);
        Some(press)
    }

    /// Looks at an edge at a place of it; `None` where it is not to be moved. It is inside, unless it `was_expected` to be.
    fn press(&mut self, edge: u32, at: f32, was_expected: bool) -> Option<Press> {
        let (motion, skin) = (self.motion, self.skin);
        let ends @ [a, b] = self.edges.ends(edge);
        let parts = [1.0 - at, at];
        let w = [self.inverse_mass[a], self.inverse_mass[b]];
        let mobility = parts[0] * parts[0] * w[0] + parts[1] * parts[1] * w[1];
        if mobility <= 0.0 {
            return None;
        }
        let between = |of: &Soa| of.get(a) * parts[0] + of.get(b) * parts[1];
        let moved = between(self.d);
        let place = between(self.x) + moved;
        let local = motion.after.to_local(place);
        let sample = motion.shape.sample(local);
        let depth = HELD * skin.epsilon - sample.distance * motion.after.scale;
        if depth.is_nan() || (depth <= 0.0 && !was_expected) {
            return None;
        }
        // At the nearest place exactly the normal is across the edge. What the search is off by would drive it along.
        let outward = motion.after.rotate(sample.normal);
        let along = (self.x.get(b) + self.d.get(b)) - (self.x.get(a) + self.d.get(a));
        let square = along.dot(along);
        let across = outward - along * (outward.dot(along) / larger(square, LEAST_SLIDING));
        let normal = across.normalize_or(outward);
        let memory = &self.set.edges;
        let passes = memory.is_freed(a, self.collider) || memory.is_freed(b, self.collider);
        // An end beyond the solid would be moved into it.
        let faces = |slot| self.nearby.normal.get(slot).dot(normal);
        let is_beyond = larger(-faces(a), -faces(b)) > BEYOND;
        if self.is_hooked(edge, depth, square.sqrt()) || passes || is_beyond {
            return None;
        }
        let surface = if motion.moves { place - motion.before.to_world(local) } else { Vec3::ZERO };
        let goes = (moved - surface).dot(normal);
        let shares = [parts[0] * w[0] / mobility, parts[1] * w[1] / mobility];
        // Next to an end that is held, the other would be thrown about.
        let share = larger(shares[0], shares[1]);
        let is_held = share > MOST_SHARE;
        let part = if is_held { MOST_SHARE / share } else { 1.0 };
        let shares = shares.map(|share| share * part);
        let least = -larger(-depth - goes, 0.0);
        // A push that moves the place by less is not to be made up for.
        let most = if is_held { larger(least - goes, 0.0) } else { f32::INFINITY };
        if !self.is_slow() && self.goes_through(ends, shares.map(|share| normal * (depth * share)))
        {
            return None;
        }
        Some(Press {
            ends,
            parts,
            shares,
            mass: part / mobility,
            normal,
            surface,
            place,
            depth,
            least,
            most,
            push: 0.0,
            brake: Vec3::ZERO,
            was_expected: false,
        })
    }

    /// Whether what is fast would push an end through itself, on a way that nothing looks at any more.
    fn goes_through(&self, ends: [usize; 2], pushes: [Vec3; 2]) -> bool {
        let motion = self.motion;
        ends.into_iter().zip(pushes).any(|(slot, push)| {
            let (from, way) = (self.x.get(slot), self.d.get(slot) + push);
            let (from, to) = (motion.before.to_local(from), motion.after.to_local(from + way));
            let looks = (1..=LOOKS).map(|i| from.lerp(to, i as f32 / LOOKS as f32));
            looks.fold(f32::INFINITY, |least, at| least.min(motion.shape.distance(at))) < 0.0
        })
    }
}
