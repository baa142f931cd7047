//! What cloths do to colliders.

use super::ColliderSnapshot;
use crate::{cloth::ClothSimulation, sdf::DistanceField};
use bevy::prelude::*;

/// Momentum that all cloths gave a collider in the last tick \[kg m/s\], in world axes: divided by the
/// tick's length, the mean force on it \[N\].
///
/// Add it to a collider to have it measured. A cloth that did not run in the tick gave nothing.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Deref)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ColliderImpulse(pub Vec3);

/// Sums up what the cloths of the tick gave, before their outcomes are taken.
pub(crate) fn sum_impulses(
    cloths: Query<(Entity, &ClothSimulation)>,
    mut measured: Query<&mut ColliderImpulse>,
    snapshot: Res<ColliderSnapshot>,
    fields: Option<Res<Assets<DistanceField>>>,
    mut order: Local<Vec<Entity>>,
) {
    if measured.is_empty() {
        return;
    }
    order.clear();
    order.extend(cloths.iter().filter(|(_, cloth)| cloth.ran()).map(|(entity, _)| entity));
    // Floating point sums depend on their order, which must not on that of archetypes.
    order.sort_unstable();
    let present = snapshot.present().filter(|(it, _)| it.shape.get(fields.as_deref()).is_some());
    for (place, (collider, _)) in present.enumerate() {
        if !collider.measured {
            continue;
        }
        let Ok(mut impulse) = measured.get_mut(collider.entity) else {
            continue;
        };
        let given = cloths
            .iter_many(order.iter())
            .map(|(_, cloth)| cloth.following.in_world(cloth.solver.impulse(place)));
        let sum = given.sum();
        impulse.set_if_neq(ColliderImpulse(sum));
    }
}
