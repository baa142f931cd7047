//! The cloth itself: its threads, where they pierce it, what holds it, its box.

use bevy::color::palettes::css;
use bevy::math::bounding::Aabb3d;
use bevy::prelude::*;

use crate::cloth::grab::ClothGrab;
use crate::gizmos::ClothGizmos;
use crate::pose::to_world;
use crate::simulation::ClothSimulation;

/// Threads, coloured by their strain.
pub(super) fn draw_threads(cloths: Query<&ClothSimulation>, mut gizmos: Gizmos<ClothGizmos>) {
    let full = gizmos.config_ext.full_strain.max(f32::MIN_POSITIVE);
    for cloth in &cloths {
        for (first, second, rest) in cloth.topology().structural_springs() {
            let (a, b) = (cloth.solver.position(first), cloth.solver.position(second));
            let strain = a.distance(b) / rest - 1.0;
            let towards = if strain > 0.0 { css::RED } else { css::BLUE };
            let part = (strain.abs() / full).min(1.0);
            gizmos.line(a, b, css::GRAY.mix(&towards, part));
        }
    }
}

/// Edges that pierce faces of their own cloth.
pub(super) fn draw_crossings(cloths: Query<&ClothSimulation>, mut gizmos: Gizmos<ClothGizmos>) {
    for cloth in &cloths {
        for ends in cloth.solver.crossing_edges() {
            let [a, b] = ends.map(|end| cloth.solver.position(end as usize));
            gizmos.line(a, b, css::RED);
        }
    }
}

/// Draws held particles, and the places that they are drawn to.
pub(super) fn draw_pins(
    cloths: Query<(&ClothSimulation, Option<&ClothGrab>)>,
    mut gizmos: Gizmos<ClothGizmos>,
) {
    for (cloth, grab) in &cloths {
        let (low, high) = cloth.solver.bounds();
        let half_size = 0.01 * low.distance(high);
        for at in cloth.held.attachments.held() {
            let anchor = &cloth.held.attachments.anchors[at.anchor as usize];
            let pose = anchor.pose.end();
            let place = cloth.solver.position(at.particle as usize);
            let hard = cloth.pinned().binary_search(&at.particle).is_ok();
            let color = if hard { css::YELLOW } else { css::ORANGE };
            gizmos.cross(place, half_size, color);
            if !hard {
                gizmos.line(place, to_world(&pose, at.local), color);
            }
            if Some(anchor.entity) != cloth.held.attachments.own_entity {
                gizmos.line(place, pose.translation, color.with_alpha(0.3));
            }
        }
        if let (Some(grabbed), Some(_)) = (&cloth.held.grab, grab) {
            for (particle, _, target) in grabbed.ways() {
                let place = cloth.solver.position(particle as usize);
                gizmos.cross(place, half_size, css::LIME);
                gizmos.line(place, target, css::LIME);
            }
        }
    }
}

/// The box around each cloth.
pub(super) fn draw_bounds(cloths: Query<&ClothSimulation>, mut gizmos: Gizmos<ClothGizmos>) {
    for cloth in &cloths {
        let (min, max) = cloth.solver.bounds();
        let color = if cloth.is_asleep() { css::GRAY } else { css::AQUA };
        let bounds = Aabb3d { min: min.into(), max: max.into() };
        gizmos.aabb_3d(bounds, Transform::IDENTITY, color);
    }
}
