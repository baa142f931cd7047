//! Cloths that come together within each other are told of, once, in the log.

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, TaskPool};

use crate::simulation::ClothSimulation;
use crate::solver::ClothSolver;
use crate::step::islands::Islands;

/// Looks whether cloths that are near others for the first time are within them.
pub(crate) fn tell_entangled(
    cloths: Query<&ClothSimulation>,
    islands: Res<Islands>,
    mut looked_at: Local<EntityHashSet>,
) {
    looked_at.retain(|&entity| {
        cloths.get(entity).is_ok_and(|cloth| cloth.solver.inter_collision().is_some())
    });
    for island in islands.members.chunk_by(|(a, _), (b, _)| a == b) {
        if island.iter().all(|(_, entity)| looked_at.contains(entity)) {
            continue;
        }
        let solver = |entity| cloths.get(entity).ok().map(|cloth| cloth.solver.clone());
        let members = island.iter().filter_map(|&(_, entity)| {
            Some(Member { entity, is_new: looked_at.insert(entity), solver: solver(entity)? })
        });
        let members: Vec<_> = members.collect();
        // In the background, as it looks at all of them.
        let look = async move {
            for (place, one) in members.iter().enumerate() {
                for other in &members[..place] {
                    one.tell_if_within(other);
                }
            }
        };
        AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(look).detach();
    }
}

/// A cloth as it was when it came near another.
struct Member {
    entity: Entity,
    is_new: bool,
    solver: ClothSolver,
}

impl Member {
    fn tell_if_within(&self, other: &Self) {
        let layers = [self, other].map(|it| it.solver.inter_collision().map_or(0, |it| it.layers));
        let [(low, high), (their_low, their_high)] = [self, other].map(|it| it.solver.bounds());
        let are_apart = (low - their_high).max(their_low - high).max_element() > 0.0;
        if are_apart || layers[0] & layers[1] == 0 || !(self.is_new || other.is_new) {
            return;
        }
        let crossings = self.solver.crossings_with(&other.solver);
        if crossings > 0 {
            tracing::warn!(
                "cloths {} and {}: they are within each other as they begin to collide: {crossings} times an edge of one pierces \
                 a face of the other. They stay calm, and come apart slowly or not at all; let them begin apart",
                self.entity,
                other.entity,
            );
        }
    }
}
