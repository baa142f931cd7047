//! Bodies of an engine that cloths move.
//!
//! A body gets a [`ColliderMass`], as one of a game's own would have it, if it is dynamic, and has a collider that is not `one_way` or
//! holds a pin of a cloth. Its engine says how heavy it is before each tick, and gives it its `BodyImpulse` after it.

use core::marker::PhantomData;

use bevy::app::{FixedFirst, FixedLast, FixedPostUpdate, FixedPreUpdate, FixedUpdate};
use bevy::ecs::schedule::{InternedScheduleLabel, ScheduleLabel, SystemSet};
use bevy::prelude::*;

use crate::cloth::pins::ClothPins;
use crate::collider::mass::{BodyImpulse, BodyMemory, ColliderBody, ColliderMass};
use crate::engines::adapted::Adapted;
use crate::engines::changes::CouplingChanges;
use crate::engines::engine::{Bodies, Engine};
use crate::error::engine::EngineProblem;
use crate::error::failures::{Blame, Failures};
use crate::error::{ClothComponent, ClothErrorKind};
use crate::solver::Impulse;

/// Is on a body of an engine whose `ColliderMass` is kept here.
#[derive(Component)]
pub(crate) struct CoupledBody {
    engine: &'static str,
}

/// Is on bodies that an engine's own systems weigh and push.
#[derive(Component)]
pub(crate) struct BodyOf<E>(PhantomData<E>);

/// Whether the systems of a set run in each tick, and not once a frame.
pub(crate) fn is_in_ticks(app: &App, set: impl SystemSet + Clone) -> bool {
    let fixed: [InternedScheduleLabel; 5] = [
        FixedFirst.intern(),
        FixedPreUpdate.intern(),
        FixedUpdate.intern(),
        FixedPostUpdate.intern(),
        FixedLast.intern(),
    ];
    fixed.into_iter().filter_map(|label| app.get_schedule(label)).any(|schedule| {
        let sets = &schedule.graph().system_sets;
        sets.contains(set.clone())
    })
}

/// Finds the bodies that cloths move, where any may be others than before.
pub(crate) fn couple<E: Engine>(
    mut changes: CouplingChanges<E>,
    colliders: Query<(Entity, &Adapted, Option<&ColliderBody>)>,
    cloths: Query<&ClothPins>,
    bodies: Bodies<E>,
    coupled: Query<(Entity, &CoupledBody, Option<&BodyMemory>)>,
    masses: Query<(), With<ColliderMass>>,
    mut wanted: Local<Vec<Entity>>,
    mut is_unfinished: Local<bool>,
    mut commands: Commands,
    mut failures: Failures,
) {
    let is_same = !changes.any();
    if is_same && !*is_unfinished {
        return;
    }
    *is_unfinished = false;
    wanted.clear();
    for (entity, adapted, part) in &colliders {
        let body = if adapted.moves(E::NAME) { bodies.dynamic(entity) } else { None };
        wanted.extend(body);
        match (body.filter(|&body| body != entity), part) {
            (Some(body), part) if part.is_none_or(|part| part.0 != body) => {
                commands.entity(entity).try_insert(ColliderBody(body));
            }
            (None, Some(_)) if adapted.is_of(E::NAME) => {
                commands.entity(entity).try_remove::<ColliderBody>();
            }
            _ => {}
        }
    }
    let anchors = cloths.iter().flat_map(|pins| pins.pins.iter().filter_map(|pin| pin.anchor));
    wanted.extend(anchors.filter_map(|anchor| bodies.dynamic(anchor)));
    wanted.sort_unstable();
    wanted.dedup();
    for (entity, known, memory) in &coupled {
        if known.engine != E::NAME || wanted.binary_search(&entity).is_ok() {
            continue;
        }
        // It is told first that what it was given ahead of time is taken back. What has become kinematic has the velocity that its game
        // gives it.
        let moves = bodies.dynamic(entity) == Some(entity);
        let is_done = !moves || memory.is_none_or(|it| !it.informed || it.ahead == Impulse::ZERO);
        if !is_done {
            *is_unfinished = true;
        } else {
            E::wake(entity, &mut commands);
            commands
                .entity(entity)
                .try_remove::<(CoupledBody, BodyOf<E>, ColliderMass, BodyImpulse, BodyMemory)>();
            failures.clear(entity, Blame::Component(ClothComponent::ColliderMass));
            failures.clear(entity, Blame::EngineMass);
        }
    }
    // One that has a mass already is a body of the user's.
    for &entity in wanted.iter().filter(|&&it| !coupled.contains(it) && !masses.contains(it)) {
        let coupled = CoupledBody { engine: E::NAME };
        commands.entity(entity).try_insert((coupled, BodyOf::<E>(PhantomData)));
    }
}

/// Gives a body its mass, or says why it has none that can be used.
pub(crate) fn set_mass(
    entity: Entity,
    found: ColliderMass,
    known: Option<Mut<ColliderMass>>,
    commands: &mut Commands,
    failures: &mut Failures,
) {
    if let Err(problem) = found.check() {
        let problem = EngineProblem::Mass(problem);
        failures.report(entity, ClothErrorKind::Engine(problem));
        commands.entity(entity).try_remove::<ColliderMass>();
        return;
    }
    failures.clear(entity, Blame::EngineMass);
    match known {
        Some(mut known) => {
            known.set_if_neq(found);
        }
        None => {
            commands.entity(entity).try_insert(found);
        }
    }
}
