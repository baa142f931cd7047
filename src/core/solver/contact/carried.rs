//! What lies on a body, as a tensor of inertia.

use bevy_math::{DMat3, DVec3, Vec3};

/// Tensor of inertia of particles that go with a body, by its linear and angular velocity. They go with it along some axes alone.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Carried {
    linear: DMat3,
    /// Angular momentum of what goes straight; transposed, linear momentum of what turns.
    between: DMat3,
    angular: DMat3,
}

impl Carried {
    /// Nothing.
    pub const NONE: Self = Self { linear: DMat3::ZERO, between: DMat3::ZERO, angular: DMat3::ZERO };

    /// Adds a `mass` \[kg\] at an `arm` from the centre \[m\] that goes with the body along the axis `n`, and across it as far as it
    /// `sticks`, from 0 to 1.
    pub fn add(&mut self, mass: f32, arm: Vec3, n: Vec3, sticks: f32) {
        let (mass, sticks) = (f64::from(mass), f64::from(sticks));
        let (arm, n) = (arm.as_dvec3(), n.as_dvec3());
        // sticks 1 + (1 - sticks) n n^T
        let along = n * (mass * (1.0 - sticks));
        let linear = DMat3::from_cols(along * n.x, along * n.y, along * n.z)
            + DMat3::from_diagonal(DVec3::splat(mass * sticks));
        let between = turned(arm, &linear);
        self.linear += linear;
        self.between += between;
        self.angular += turned(arm, &between.transpose());
    }

    /// Momentum of a unit of each component of the velocity: three linear ones, and three angular ones.
    pub fn columns(&self) -> [[Vec3; 2]; 6] {
        let Self { linear, between, angular } = self;
        let across = between.transpose();
        core::array::from_fn(|i| {
            let parts = if i < 3 { [linear, between] } else { [&across, angular] };
            parts.map(|part| part.col(i % 3).as_vec3())
        })
    }
}

/// The cross products of an arm with the columns of a matrix.
fn turned(arm: DVec3, matrix: &DMat3) -> DMat3 {
    let [x, y, z] = [0, 1, 2].map(|i| arm.cross(matrix.col(i)));
    DMat3::from_cols(x, y, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The momentum of a particle that goes with a body in every direction.
    #[test]
    fn what_sticks_has_the_momentum_of_its_velocity() {
        let (mass, arm, n) = (2.0, Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        let mut carried = Carried::NONE;
        carried.add(mass, arm, n, 1.0);
        for (i, [linear, angular]) in carried.columns().into_iter().enumerate() {
            let axis = Vec3::AXES[i % 3];
            let momentum = if i < 3 { axis } else { axis.cross(arm) } * mass;
            assert!(linear.distance(momentum) < 1e-6, "{i}: {linear}");
            assert!(angular.distance(arm.cross(momentum)) < 1e-6, "{i}: {angular}");
        }
    }

    /// What slides has momentum along its normal alone.
    #[test]
    fn what_slides_is_moved_along_its_normal() {
        let (arm, n) = (Vec3::new(1.0, -2.0, 0.5), Vec3::new(0.6, 0.0, 0.8));
        let mut carried = Carried::NONE;
        carried.add(2.0, arm, n, 0.0);
        for (i, [linear, angular]) in carried.columns().into_iter().enumerate() {
            let axis = Vec3::AXES[i % 3];
            let velocity = if i < 3 { axis } else { axis.cross(arm) };
            let momentum = n * (2.0 * velocity.dot(n));
            assert!(linear.distance(momentum) < 1e-6, "{i}: {linear}");
            assert!(angular.distance(arm.cross(momentum)) < 1e-6, "{i}: {angular}");
        }
    }
}
