//! A body answers to what touches it: it and the particles that lie on it go on together.
//!
//! Particles meet a collider as if nothing could move it, and all at once: each takes the velocity of its surface. A body
//! that weighs little beside them would be given the momentum of all of them, and would leave faster than they came. So what it is
//! given is shared with the particles that press on it, as of an inelastic collision: they are one body for the moment,
//! along the normal, and along the surface as far as friction holds them.
//!
//! In the corrections of the next substep threads pull at these particles. A particle that lies on a collider has the mobility
//! `w (1 - n n^T)` there (`active_set`). One that lies on a body moves along the normal as well, as heavy as it and its part of the body
//! are together: the normal that corrections see is shorter. Each of `N` particles is taken to carry a part of the body's
//! mass (mass splitting: Tonge, Benevolenski and Voroshilov 2012, *Mass Splitting for Jitter-Free Parallel Rigid Body
//! Simulation*), so that threads of any stiffness carry a body of any mass.

use bevy_math::Vec3;

use crate::solver::contact::active_set::ActiveSet;
use crate::solver::contact::carried::Carried;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::linear::solve;
use crate::solver::contact::mobility::{Mobility, Twist};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// A body, after particles have met it in a substep.
pub(super) struct Answer<'a> {
    pub collider: usize,
    pub mobility: Mobility,
    pub motion: &'a Motion<'a>,
    /// What it was given in this contact.
    pub given: Impulse,
    /// Length of the substep \[s\].
    pub step: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a mut Soa,
    /// Pulls noted from before the corrections on (`integrate::houbolt`), of which contact is none.
    pub pull: Option<&'a mut Soa>,
    pub set: &'a mut ActiveSet,
    /// By block, the way at which its particles may touch the body, and the way that has been gone (`broad_phase`) \[m\].
    pub until: &'a [f32],
    pub gone: f32,
}

impl Answer<'_> {
    /// Shares with the particles what the body was given, and returns what it takes back of that.
    pub fn run(&mut self) -> Impulse {
        let mut slots = core::mem::take(&mut self.set.answering);
        slots.clear();
        slots.extend(self.touching());
        let mut carried = Carried::NONE;
        for &slot in &slots {
            let mass = 1.0 / self.inverse_mass[slot];
            carried.add(mass, self.arm(slot), self.normal(slot), self.sticks(slot));
        }
        let mut taken = Impulse::ZERO;
        if !slots.is_empty() {
            let together = self.mobility.motion_with(&carried, self.given);
            for &slot in &slots {
                taken += self.take_along(slot, &together);
            }
            let moves = self.mobility.motion(self.given + taken);
            for &slot in &slots {
                self.lighten(slot, &moves, slots.len());
                self.set.pressed.set(slot, Vec3::ZERO);
            }
        }
        self.set.answering = slots;
        taken
    }

    /// Slots of the particles that touch the body.
    fn touching(&self) -> impl Iterator<Item = usize> + '_ {
        let blocks = self.set.next.blocks.iter().zip(self.until).enumerate();
        // What touches has no way left to go.
        let blocks = blocks.filter(|&(_, (&touches, &until))| touches && until <= self.gone);
        let slots = blocks.flat_map(|(block, _)| block * LANES..(block + 1) * LANES);
        slots.filter(|&slot| {
            self.inverse_mass[slot] > 0.0
                && self.set.holder[slot] as usize == self.collider
                && self.set.pressed.get(slot) != Vec3::ZERO
        })
    }

    fn arm(&self, slot: usize) -> Vec3 {
        self.x.get(slot) - self.motion.centre[0]
    }

    /// The axis along which a particle presses on the body, and goes with it.
    fn normal(&self, slot: usize) -> Vec3 {
        self.set.pressed.get(slot).normalize_or(Vec3::Y)
    }

    /// How far it goes with it along the surface, from 0 to 1.
    fn sticks(&self, slot: usize) -> f32 {
        1.0 - self.set.next.loose[slot]
    }

    /// Takes a particle along with the body, no further than it was pressed, and returns what the body takes back for that.
    fn take_along(&mut self, slot: usize, together: &Twist) -> Impulse {
        let way = together.at(self.arm(slot)) * self.step;
        let (n, sticks) = (self.normal(slot), self.sticks(slot));
        let along = n.dot(way);
        let most = -self.set.pressed.get(slot).length();
        let by = (way - n * along) * sticks + n * along.max(most);
        self.d.set(slot, self.d.get(slot) + by);
        self.set.unpulled.set(slot, self.set.unpulled.get(slot) + by);
        if let Some(pull) = &mut self.pull {
            pull.set(slot, pull.get(slot) - by);
        }
        Impulse::at(self.arm(slot), by / (-self.inverse_mass[slot] * self.step))
    }

    /// Tells the next corrections how fast the surface is now, and how heavy the particle is there, with its part of the body.
    fn lighten(&mut self, slot: usize, moves: &Twist, count: usize) {
        let (arm, n) = (self.arm(slot), self.set.next.normal.get(slot));
        self.set.velocity.set(slot, self.set.velocity.get(slot) + moves.at(arm));
        let gives = self.mobility.along(arm, n);
        let ratio = count as f32 * gives / self.inverse_mass[slot];
        self.set.next.normal.set(slot, n * (1.0 / (1.0 + ratio)).sqrt());
    }
}

impl Mobility {
    /// The motion that an impulse makes of the body and of what it carries.
    fn motion_with(&self, carried: &Carried, impulse: Impulse) -> Twist {
        let alone = self.motion(impulse);
        // (1 + K A) v = K j, with the body's own mobility K: it may be none along some axes.
        let mut matrix = [[0.0; 6]; 6];
        for (column, [linear, angular]) in carried.columns().into_iter().enumerate() {
            let moved = self.motion(Impulse { linear, angular });
            for (row, value) in components(&moved).into_iter().enumerate() {
                matrix[row][column] = value + if row == column { 1.0 } else { 0.0 };
            }
        }
        let moves = solve(matrix, components(&alone)).map(|v| v as f32);
        Twist {
            linear: Vec3::new(moves[0], moves[1], moves[2]),
            angular: Vec3::new(moves[3], moves[4], moves[5]),
        }
    }
}

fn components(twist: &Twist) -> [f64; 6] {
    let Twist { linear: v, angular: w } = twist;
    [v.x, v.y, v.z, w.x, w.y, w.z].map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_math::Mat3;

    #[test]
    fn a_body_that_carries_its_own_mass_is_half_as_fast() {
        let body = Mobility {
            inverse_mass: 0.5,
            inverse_inertia: Mat3::from_diagonal(Vec3::new(1.0, 2.0, 0.0)),
            informed: true,
        };
        // Two kilograms at its centre.
        let mut carried = Carried::NONE;
        carried.add(2.0, Vec3::ZERO, Vec3::Y, 1.0);
        let impulse = Impulse { linear: Vec3::new(4.0, 0.0, -8.0), angular: Vec3::ONE };
        let moves = body.motion_with(&carried, impulse);
        assert_eq!(moves.linear, Vec3::new(1.0, 0.0, -2.0));
        assert_eq!(moves.angular, Vec3::new(1.0, 2.0, 0.0));
    }
}
