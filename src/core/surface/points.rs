//! The particles as points of a frame.

use crate::solver::ClothSolver;
use bevy_math::{Mat3, Vec3};

/// How a cloth's own coordinates become those of the frame that it is drawn in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// Part of the last tick: 0 is its start, 1 its end.
    pub blend: f32,
    /// Turns, and scales, what is relative to [`ClothSolver::origin`].
    pub turn: Mat3,
    /// Added to it \[m\].
    pub shift: Vec3,
}

impl Placing {
    /// Writes the point of every particle.
    ///
    /// # Panics
    /// If `points` are fewer than the particles.
    pub fn write(&self, solver: &ClothSolver, points: &mut [Vec3]) {
        let &Self { blend, turn, shift } = self;
        let (x, y, z) = (turn.x_axis, turn.y_axis, turn.z_axis);
        solver.for_each_blended(blend, |particle, p| {
            points[particle] = x * p.x + y * p.y + z * p.z + shift;
        });
    }
}

/// The corners of the box around points; infinite and the wrong way round without any.
pub fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    points.iter().fold(none, |(min, max), &point| (min.min(point), max.max(point)))
}

/// Whether any point is further than this from where it was; so is what is NaN.
pub fn has_moved(points: &[Vec3], before: &[Vec3], distance: f32) -> bool {
    let square = distance * distance;
    !points.iter().zip(before).all(|(a, b)| a.distance_squared(*b) <= square)
}
