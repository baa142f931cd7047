//! What lies on a body, as a tensor of inertia.

use bevy_math::Vec3;

use crate::solver::contact::touching::Touching;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;

/// Tensor of inertia of particles that go with a body, by its linear and angular velocity, summed up by lanes. They go with it along
/// some axes alone.
pub(super) struct Carried {
    /// Columns of the linear momentum of what goes straight.
    linear: [Block3; 3],
    /// Columns of its angular momentum; as rows, linear momentum of what turns.
    between: [Block3; 3],
    /// Columns of the angular momentum of what turns.
    angular: [Block3; 3],
}

impl Carried {
    /// Nothing.
    pub const NONE: Self =
        Self { linear: [Block3::ZERO; 3], between: [Block3::ZERO; 3], angular: [Block3::ZERO; 3] };

    /// Adds particles, which go with the body along the axes that they press along, and across them as far as they stick.
    #[inline(always)]
    pub fn add(&mut self, touching: &Touching) {
        let Touching { masses, arms, n, sticks, .. } = touching;
        let mut between = [Block3::ZERO; 3];
        for (column, axis) in Vec3::AXES.into_iter().enumerate() {
            // sticks 1 + (1 - sticks) n n^T
            let mut linear = Block3::ZERO;
            for i in 0..LANES {
                let (n, mass, sticks) = (n.at(i), masses.0[i], sticks.0[i]);
                let along = n * (mass * (1.0 - sticks) * n.dot(axis));
                linear.set(i, along + axis * (mass * sticks));
            }
            self.linear[column] = self.linear[column].plus(&linear);
            between[column] = arms.cross(&linear);
            self.between[column] = self.between[column].plus(&between[column]);
        }
        let [a, b, c] = &between;
        let row = |a: &Block, b: &Block, c: &Block| Block3 { x: *a, y: *b, z: *c };
        let rows = [row(&a.x, &b.x, &c.x), row(&a.y, &b.y, &c.y), row(&a.z, &b.z, &c.z)];
        for (column, row) in rows.into_iter().enumerate() {
            self.angular[column] = self.angular[column].plus(&arms.cross(&row));
        }
    }

    /// Momentum of a unit of each component of the velocity: three linear ones, and three angular ones.
    pub fn columns(&self) -> [[Vec3; 2]; 6] {
        let [linear, between, angular] =
            [&self.linear, &self.between, &self.angular].map(|columns| columns.map(|it| it.sum()));
        core::array::from_fn(|i| match i {
            0..3 => [linear[i], between[i]],
            _ => [Vec3::from(between.map(|column| column[i - 3])), angular[i - 3]],
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// One particle.
    pub fn one(mass: f32, arm: Vec3, n: Vec3, sticks: f32) -> Carried {
        let mut touching = Touching {
            slot: 0,
            masses: Block::ZERO,
            arms: Block3::splat(arm),
            n: Block3::splat(n),
            pressed: Block::ZERO,
            sticks: Block::splat(sticks),
        };
        touching.masses.0[3] = mass;
        let mut carried = Carried::NONE;
        carried.add(&touching);
        carried
    }

    /// The momentum of a particle that goes with a body in every direction.
    #[test]
    fn what_sticks_has_the_momentum_of_its_velocity() {
        let (mass, arm, n) = (2.0, Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        let carried = one(mass, arm, n, 1.0);
        for (i, [linear, angular]) in carried.columns().into_iter().enumerate() {
            let axis = Vec3::AXES[i % 3];
            let momentum = if i < 3 { axis } else { axis.cross(arm) } * mass;
            assert!(linear.distance(momentum) < 1e-5, "{i}: {linear}");
            assert!(angular.distance(arm.cross(momentum)) < 1e-5, "{i}: {angular}");
        }
    }

    /// What slides has momentum along its normal alone.
    #[test]
    fn what_slides_is_moved_along_its_normal() {
        let (arm, n) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        let carried = one(2.0, arm, n, 0.0);
        for (i, [linear, angular]) in carried.columns().into_iter().enumerate() {
            let axis = Vec3::AXES[i % 3];
            let velocity = if i < 3 { axis } else { axis.cross(arm) };
            let momentum = n * (2.0 * velocity.dot(n));
            assert!(linear.distance(momentum) < 1e-5, "{i}: {linear}");
            assert!(angular.distance(arm.cross(momentum)) < 1e-5, "{i}: {angular}");
        }
    }
}
