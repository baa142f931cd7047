//! Where cloths touch colliders.

use bevy::color::palettes::css;
use bevy::prelude::*;

use crate::collider::tick_colliders::{ColliderRoom, TickColliders};
use crate::gizmos::ClothGizmos;
use crate::proximity::for_each_near;
use crate::sdf::DistanceField;
use crate::simulation::ClothSimulation;

/// Distance beyond the cloth's thickness at which a particle still counts as touching \[m\]: what holds it
/// there is rounded.
const ROUNDING: f32 = 1e-4;

/// A line from each particle that touches a collider, along the normal there.
pub(super) fn draw_contacts(
    cloths: Query<&ClothSimulation>,
    snapshot: Option<Res<TickColliders>>,
    fields: Option<Res<Assets<DistanceField>>>,
    mut gizmos: Gizmos<ClothGizmos>,
) {
    let Some(snapshot) = snapshot else { return };
    let length = gizmos.config_ext.normal_length;
    let colliders = snapshot.colliders(fields.as_deref(), ColliderRoom::default());
    for cloth in &cloths {
        let reach = cloth.in_force.material.thickness + ROUNDING;
        for collider in &colliders {
            for_each_near(cloth, collider, reach, |near| {
                let tip = near.place + length * near.normal;
                gizmos.line_gradient(near.place, tip, css::MAGENTA, css::WHITE);
            });
        }
    }
}
