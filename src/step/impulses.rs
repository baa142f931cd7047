//! Momentum that cloths gave the colliders in a tick.

use bevy::prelude::*;

use crate::collider::impulse::ColliderImpulse;
use crate::collider::tick_colliders::{Gathered, TickColliders};
use crate::sdf::DistanceField;
use crate::simulation::ClothSimulation;
use crate::solver::Impulse;

/// Sums up what the cloths of the tick gave, before their outcomes are taken.
pub(crate) fn sum_impulses(
    cloths: Query<(Entity, &ClothSimulation)>,
    mut measured: Query<(Entity, &mut ColliderImpulse)>,
    snapshot: Res<TickColliders>,
    fields: Option<Res<Assets<DistanceField>>>,
    mut order: Local<Vec<Entity>>,
) {
    if measured.is_empty() {
        return;
    }
    order.clear();
    order.extend(cloths.iter().filter(|(_, cloth)| cloth.tick.ran()).map(|(entity, _)| entity));
    // Floating point sums depend on their order, which must not on that of archetypes.
    order.sort_unstable();
    let fields = fields.as_deref();
    let present = |it: &Gathered| it.motion.is_some() && it.shape.get(fields).is_some();
    // Nothing is given to a collider that no cloth can meet.
    for (entity, mut impulse) in &mut measured {
        let known = snapshot.known(entity);
        if !known.is_some_and(|it| it.measured && present(it)) {
            impulse.set_if_neq(ColliderImpulse::default());
        }
    }
    let present = snapshot.colliders.iter().filter(|it| present(it));
    for (place, collider) in present.enumerate() {
        if !collider.measured {
            continue;
        }
        let Ok((_, mut impulse)) = measured.get_mut(collider.entity) else {
            continue;
        };
        let given = cloths
            .iter_many(order.iter())
            .map(|(_, cloth)| cloth.frame.impulse_in_world(cloth.solver.impulse(place)));
        let sum: Impulse = given.sum();
        impulse.set_if_neq(sum.into());
    }
}
