//! Which cloths collide with others.

use bevy::prelude::*;

use crate::cloth::inter_collision::ClothInterCollision;
use crate::error::ClothComponent;
use crate::error::failures::{Blame, Failures};
use crate::simulation::ClothSimulation;
use crate::simulation::complaints::component_error;
use crate::solver::InterCollision;

const COMPONENT: ClothComponent = ClothComponent::ClothInterCollision;
const BLAME: Blame = Blame::Component(COMPONENT);

/// Lets cloths collide with others as their components say. What cannot be is refused, the last good numbers stay.
pub(crate) fn apply_inter_collision(
    mut cloths: Query<(Entity, &mut ClothSimulation, Option<Ref<ClothInterCollision>>)>,
    mut failures: Failures,
) {
    for (entity, mut cloth, component) in &mut cloths {
        let asked = component.as_deref().map(|asked| InterCollision::from(*asked));
        let was = cloth.solver.inter_collision();
        let is_refused = failures.blames(entity, BLAME);
        if was == asked && !is_refused {
            continue;
        }
        // What was refused is looked at again only after a change: to find out what a cloth allows looks at all of it.
        if is_refused && component.as_ref().is_some_and(|it| !it.is_changed()) {
            continue;
        }
        let outcome = cloth.solver.set_inter_collision(asked);
        failures.tell(
            entity,
            BLAME,
            outcome.map_err(|problem| component_error(COMPONENT, problem)),
        );
        if outcome.is_ok() && was != asked {
            cloth.wake();
        }
    }
}
