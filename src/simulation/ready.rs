//! Tells that cloths are there.

use bevy::prelude::*;

use crate::cloth::events::ClothReady;
use crate::simulation::ClothSimulation;

/// Tells of cloths that are ready now.
pub(crate) fn tell_ready(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    mut commands: Commands,
) {
    for (entity, mut cloth) in &mut cloths {
        if !cloth.start.told_ready && !cloth.is_hanging() {
            cloth.start.told_ready = true;
            commands.trigger(ClothReady { entity });
        }
    }
}
