//! The particles of a cloth that are near a collider: for gizmos and panel, never in a tick.

use bevy::prelude::*;

use crate::pose::{to_local, to_world};
use crate::simulation::ClothSimulation;
use crate::solver::Collider;

/// A particle beside a collider.
pub(crate) struct Near {
    /// Where it is \[m\].
    pub place: Vec3,
    /// Its distance from the collider's surface \[m\], below zero inside.
    #[cfg_attr(not(feature = "panel"), expect(dead_code, reason = "the panel alone shows depths"))]
    pub distance: f32,
    /// The collider's normal there.
    pub normal: Vec3,
}

/// Calls `act` with every particle within `reach` of a collider \[m\], where both are at the last tick's end,
/// if they meet at all.
pub(crate) fn for_each_near(
    cloth: &ClothSimulation,
    collider: &Collider<'_>,
    reach: f32,
    mut act: impl FnMut(Near),
) {
    if collider.layers & cloth.in_force.settings.layers.0 == 0 {
        return;
    }
    let pose = collider.motion.end();
    let (min, max) = cloth.solver.bounds();
    // Most colliders are nowhere near.
    let middle = to_local(&pose, 0.5 * (min + max));
    let away = pose.scale * (collider.shape.distance(middle) - collider.shape.overestimate());
    if away > 0.5 * min.distance(max) + reach {
        return;
    }
    for place in cloth.positions() {
        let sample = collider.shape.sample(to_local(&pose, place));
        let distance = pose.scale * sample.distance;
        if distance <= reach {
            let tip = to_world(&pose, sample.normal) - pose.translation;
            act(Near { place, distance, normal: tip / pose.scale });
        }
    }
}
