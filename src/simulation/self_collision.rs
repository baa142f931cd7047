//! Which cloths collide with themselves.

use bevy::prelude::*;
use bevy::tasks::{AsyncComputeTaskPool, TaskPool};

use crate::cloth::ClothShape;
use crate::cloth::self_collision::ClothSelfCollision;
use crate::error::ClothComponent;
use crate::error::failures::{Blame, Failures};
use crate::simulation::ClothSimulation;
use crate::simulation::complaints::component_error;
use crate::solver::SelfCollision;

const COMPONENT: ClothComponent = ClothComponent::ClothSelfCollision;
const BLAME: Blame = Blame::Component(COMPONENT);

/// Lets cloths collide with themselves as their components say. Numbers out of range are refused, the last good ones stay.
pub(crate) fn apply_self_collision(
    mut cloths: Query<(Entity, &mut ClothSimulation, Option<Ref<ClothSelfCollision>>)>,
    mut failures: Failures,
) {
    for (entity, mut cloth, component) in &mut cloths {
        let asked = component.as_deref().map(|asked| SelfCollision::from(*asked));
        let was = cloth.solver.self_collision();
        let is_refused = failures.blames(entity, BLAME);
        if was == asked && !is_refused {
            continue;
        }
        // What was refused is looked at again only after a change: to find out what a cloth allows looks at all of it.
        if is_refused && component.as_ref().is_some_and(|it| !it.is_changed()) {
            continue;
        }
        let cloth = &mut *cloth;
        let outcome = cloth.solver.set_self_collision(asked);
        failures.tell(
            entity,
            BLAME,
            outcome.map_err(|problem| component_error(COMPONENT, problem)),
        );
        if outcome.is_err() || was == asked {
            continue;
        }
        cloth.wake();
        if core::mem::take(&mut cloth.progress.quarantined) {
            failures.clear(entity, Blame::Motion);
        }
        if was.is_none() {
            tell_tangled(entity, cloth);
        }
    }
}

/// Says whether the cloth is tangled, once, when that is known. It is found out in the background, as all of the cloth is looked at.
fn tell_tangled(entity: Entity, cloth: &ClothSimulation) {
    // A sheet is flat before its first tick.
    if cloth.in_force.shape != ClothShape::Mesh && cloth.tick_count() == 0 {
        return;
    }
    let solver = cloth.solver.clone();
    let look = async move {
        let crossings = solver.crossings();
        if crossings > 0 {
            tracing::warn!(
                "cloth {entity}: it is tangled as it begins to collide with itself: {crossings} times an edge pierces a face. \
                 Layers that have passed through each other come apart slowly or not at all; start from a shape without \
                 crossings, or with `ClothSelfCollision` from its first tick on"
            );
        }
    };
    AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(look).detach();
}
