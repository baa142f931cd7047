//! The faces at a particle in a few numbers, by which most pairs are seen to be apart at a glance.

use bevy_math::Vec3;

use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::simd::block::{larger, smaller};

/// How much further apart faces are to be than rounding could have it, in their size.
const SLACK: f32 = 1e-4;

/// The faces at a particle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Where the particle is \[m\].
    pub at: Vec3,
    /// Of length one.
    normal: Vec3,
    /// How far corners reach along the normal, from the particle, and in any direction \[m\].
    low: f32,
    high: f32,
    radius: f32,
}

impl Ring {
    /// Of a slot, where `at` says where particles are.
    fn of(faces: &FacesAt, slot: usize, at: impl Fn(u32) -> Vec3) -> Self {
        let (here, normal) = (at(slot as u32), faces.normal(slot, &at));
        let (mut low, mut high, mut square) = (0.0, 0.0, 0.0);
        for corner in faces.of(slot).flatten() {
            let from = at(corner) - here;
            let along = normal.dot(from);
            (low, high) = (smaller(along, low), larger(along, high));
            square = larger(from.dot(from), square);
        }
        Self { at: here, normal, low, high, radius: square.sqrt() }
    }

    /// Whether faces here may pierce some of another particle, which is `apart` from this one: it is nearer than `near`, and no plane
    /// along this surface lies between all of them at a glance.
    pub fn may_meet(&self, other: &Self, apart: Vec3, near: f32) -> bool {
        apart.dot(apart) < near * near && !self.is_clear_of(other, apart)
    }

    fn is_clear_of(&self, other: &Self, apart: Vec3) -> bool {
        let cosine = self.normal.dot(other.normal);
        let sine = larger(1.0 - cosine * cosine, 0.0).sqrt();
        // Along the other normal as far as the other faces reach, and across it as far as they are wide.
        let thick = larger(other.high, -other.low) + other.radius * sine;
        let slack = (self.radius + other.radius) * SLACK;
        let middle = self.normal.dot(apart);
        middle - thick > self.high + slack || middle + thick < self.low - slack
    }
}

/// The faces at each particle of a cloth, worked out where they are asked for.
#[derive(Clone, Debug)]
pub(super) struct Rings(Vec<Option<Ring>>);

impl Rings {
    pub fn new(slots: usize) -> Self {
        Self(vec![None; slots])
    }

    /// Forgets all of them: particles have moved.
    pub fn forget(&mut self) {
        self.0.fill(None);
    }

    #[inline]
    pub fn get(&mut self, faces: &FacesAt, slot: u32, at: impl Fn(u32) -> Vec3) -> Ring {
        *self.0[slot as usize].get_or_insert_with(|| Ring::of(faces, slot as usize, at))
    }
}
