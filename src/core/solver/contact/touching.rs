//! Particles that touch a body, block by block.

use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::Twist;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;

/// The particles of a block that touch a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touching {
    pub slot: usize,
    /// Their masses \[kg\]; zero where a particle does not touch.
    pub masses: Block,
    /// From the body's centre \[m\].
    pub arms: Block3,
    /// The axes along which they press on it, and how far they were pressed \[m\].
    pub n: Block3,
    pub pressed: Block,
    /// How far they go with it along the surface, from 0 to 1.
    pub sticks: Block,
}

impl Touching {
    /// None of any block.
    pub const NONE: Self = Self {
        slot: 0,
        masses: Block::ZERO,
        arms: Block3::ZERO,
        n: Block3::ZERO,
        pressed: Block::ZERO,
        sticks: Block::ZERO,
    };
}

/// Momentum of particles as they go with a body, about its centre.
#[inline(always)]
pub(super) fn momentum(all: &[Touching], body: &Twist) -> Impulse {
    let (mut linear, mut angular) = (Block3::ZERO, Block3::ZERO);
    for Touching { masses, arms, n, sticks, .. } in all {
        let (mut way, mut along) = (Block3::ZERO, Block::ZERO);
        for i in 0..LANES {
            way.set(i, body.at(arms.at(i)));
        }
        for i in 0..LANES {
            along.0[i] = n.at(i).dot(way.at(i)) * (1.0 - sticks.0[i]);
        }
        // Along the axis that it presses along wholly, and across it as far as it sticks.
        let mut goes = Block3::ZERO;
        for i in 0..LANES {
            goes.set(i, (n.at(i) * along.0[i] + way.at(i) * sticks.0[i]) * masses.0[i]);
        }
        linear = linear.plus(&goes);
        angular = angular.plus(&arms.cross(&goes));
    }
    Impulse { linear: linear.sum(), angular: angular.sum() }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use bevy_math::Vec3;

    /// One particle.
    pub fn one(mass: f32, arm: Vec3, n: Vec3, sticks: f32) -> Touching {
        let mut touching = Touching {
            arms: Block3::splat(arm),
            n: Block3::splat(n),
            sticks: Block::splat(sticks),
            ..Touching::NONE
        };
        touching.masses.0[3] = mass;
        touching
    }

    /// Velocities of one along and about each axis.
    fn twists() -> impl Iterator<Item = Twist> {
        let of = |linear, angular| Twist { linear, angular };
        Vec3::AXES.into_iter().flat_map(move |axis| [of(axis, Vec3::ZERO), of(Vec3::ZERO, axis)])
    }

    #[test]
    fn what_sticks_has_the_momentum_of_its_velocity() {
        let (mass, arm, n) = (2.0, Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        for twist in twists() {
            let Impulse { linear, angular } = momentum(&[one(mass, arm, n, 1.0)], &twist);
            let expected = (twist.linear + twist.angular.cross(arm)) * mass;
            assert!(linear.distance(expected) < 1e-5, "{twist:?}: {linear}");
            assert!(angular.distance(arm.cross(expected)) < 1e-5, "{twist:?}: {angular}");
        }
    }

    #[test]
    fn what_slides_is_moved_along_its_normal() {
        let (arm, n) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        for twist in twists() {
            let Impulse { linear, angular } = momentum(&[one(2.0, arm, n, 0.0)], &twist);
            let velocity = twist.linear + twist.angular.cross(arm);
            let expected = n * (2.0 * velocity.dot(n));
            assert!(linear.distance(expected) < 1e-5, "{twist:?}: {linear}");
            assert!(angular.distance(arm.cross(expected)) < 1e-5, "{twist:?}: {angular}");
        }
    }
}
