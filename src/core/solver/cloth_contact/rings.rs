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
    /// The normal of the surface, of length one.
    normal: Vec3,
    /// How far corners reach along the normal, from the particle, and in any direction \[m\].
    low: f32,
    high: f32,
    radius: f32,
}

impl Ring {
    /// The ring of a slot, where `at` says where particles are.
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_math::{Quat, Vec2};

    use super::*;
    use crate::solver::settings::MassLumping;
    use crate::solver::topology::Topology;
    use crate::solver::topology::lattice::Lattice;

    /// Numbers from -1 to 1.
    fn dice() -> impl FnMut() -> f32 {
        let mut state = 7_u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    #[test]
    fn what_is_clear_at_a_glance_has_a_plane_between() {
        let sheet = Lattice::sheet(Vec2::splat(2.0), 3, 3, MassLumping::Lumped).unwrap();
        let topology = Topology::from(Arc::new(sheet));
        let faces = FacesAt::new(&topology);
        let mut roll = dice();
        let mut clear = 0;
        for _ in 0..2000 {
            let mut crumpled = |turn: Quat, by: f32, place: Vec3| {
                let mut all = vec![Vec3::ZERO; topology.layout().len()];
                for (particle, &rest) in topology.rest_positions().iter().enumerate() {
                    let off = Vec3::new(roll(), roll(), roll()) * by;
                    all[topology.slot(particle)] = place + turn * (rest + off);
                }
                all
            };
            let one = crumpled(Quat::IDENTITY, 0.2, Vec3::ZERO);
            let turn = Quat::from_rotation_x(one[topology.slot(4)].x * 4.0);
            let other = crumpled(turn, 0.2, Vec3::Y * (1.0 + one[topology.slot(4)].y * 5.0));
            let middle = topology.slot(4);
            let ring = |all: &[Vec3]| Ring::of(&faces, middle, |slot| all[slot as usize]);
            let (a, b) = (ring(&one), ring(&other));
            if !a.is_clear_of(&b, b.at - a.at) {
                continue;
            }
            clear += 1;
            let along = |all: &[Vec3]| {
                let reaches =
                    faces.of(middle).flatten().map(|slot| a.normal.dot(all[slot as usize]));
                reaches.fold([f32::MAX, f32::MIN], |[low, high], it| [low.min(it), high.max(it)])
            };
            let ([low, high], [their_low, their_high]) = (along(&one), along(&other));
            assert!(
                high < their_low || their_high < low,
                "{low} to {high}, {their_low} to {their_high}"
            );
        }
        assert!((200..1900).contains(&clear), "{clear} of 2000 are clear");
    }
}
