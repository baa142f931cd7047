//! Solids against what another knows of the same shape.

use bevy::math::{
    Vec3,
    bounding::{Aabb3d, BoundingVolume},
};
use bevy_drape::sdf::SignedDistance;

use super::dice::Dice;

/// Points at which solids are compared.
pub const POINTS: usize = 10_000;

/// The largest difference of two signed distances over points in a box, and where it is \[m\].
/// What the truth does not know (`None`) is left out.
pub fn largest_difference(
    solid: &dyn SignedDistance,
    around: Aabb3d,
    truth: impl Fn(Vec3) -> Option<f32>,
) -> (f32, Vec3) {
    let (centre, half) = (Vec3::from(around.center()), Vec3::from(around.half_size()));
    let mut dice = Dice(1);
    let mut worst = (0.0, Vec3::ZERO);
    let mut known = 0;
    for _ in 0..POINTS {
        let point = centre + dice.vector() * half;
        let Some(expected) = truth(point) else { continue };
        known += 1;
        let difference = (solid.distance(point) - expected).abs();
        if difference.is_nan() || difference > worst.0 {
            worst = (difference, point);
        }
    }
    assert!(known > POINTS / 10, "only {known} points are known");
    worst
}
