//! Keeps an `SdfCollider` on each collider of an engine that cloths collide with.

use core::marker::PhantomData;
use std::sync::Arc;

use bevy::ecs::query::QueryData;
use bevy::ecs::schedule::SystemSet;
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;

use crate::collider::bake::BakeSdf;
use crate::collider::shape::SdfShape;
use crate::collider::tick_colliders::ColliderPose;
use crate::collider::{SdfCollider, SdfColliderDisabled};
use crate::engines::ClothCollider;
use crate::engines::adapted::Adapted;
use crate::engines::bakes::Bakes;
use crate::engines::bodies::{couple, is_in_ticks};
use crate::engines::changes::FrictionChanges;
use crate::engines::engine::{Adapting, Bodies, Engine};
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::ClothErrorKind;
use crate::error::engine::EngineProblem;
use crate::error::failures::{Blame, Failures};
use crate::plugin::ClothPlugin;
use crate::pose::OwnScale;
use crate::schedule::ClothSystems;
use crate::solver::ParameterError;

/// Coefficient of friction where nothing says one \[1\].
const FRICTION: f32 = 0.5;

/// Is in the world where colliders of an engine need no `ClothCollider`.
#[derive(Resource)]
struct All<E>(PhantomData<E>);

impl<E: Engine> FoundItem<'_, '_, E> {
    /// Whether it has what it is to have, unless its friction is another.
    fn is_settled(&self) -> bool {
        let Some(adapted) = self.adapted.as_ref() else { return false };
        let is_left_alone = self.collider.as_ref().is_none_or(|it| !it.is_changed());
        adapted.is_of(E::NAME)
            && adapted.wish == self.wish.copied().unwrap_or_default()
            && adapted.is_given(self.collider.is_some())
            && is_left_alone
            && !self.shape.is_changed()
    }
}

/// Registers what an engine's colliders need, apart from its system.
pub(crate) fn add_engine<E: Engine>(app: &mut App, all: bool) {
    app.register_type::<ClothCollider>().init_resource::<Bakes>().add_observer(forget::<E>);
    // Once, though there may be two engines.
    if app.world().get_resource::<Watched>().is_none() {
        app.insert_resource(Watched).add_observer(leave_alone);
    }
    if all {
        app.insert_resource(All::<E>(PhantomData));
    }
}

/// Is in the world where `leave_alone` is.
#[derive(Resource)]
struct Watched;

/// Adapts colliders in the schedule of cloths: after the engine, before anything looks at colliders.
pub(crate) fn schedule_engine<E: Engine>(app: &mut App, after: impl SystemSet + Clone) {
    // All plugins are there by now, in whatever order they were added.
    let Some(schedule) = app.get_added_plugins::<ClothPlugin>().first().map(|it| it.schedule())
    else {
        tracing::warn!("colliders of {} are nothing to cloths without `ClothPlugin`", E::NAME);
        return;
    };
    app.configure_sets(schedule, ClothSystems::Setup.after(after.clone()))
        // In this order, so that of two colliders on one entity the same is always kept.
        .configure_sets(schedule, (Adapting::Avian, Adapting::Rapier).chain())
        .add_systems(schedule, adapt::<E>.in_set(E::SET).after(after).before(ClothSystems::Setup));
}

/// Lets cloths move the bodies of an engine: `weigh` says how heavy they are, `give` gives them their impulses.
pub(crate) fn couple_engine<E: Engine, W, G>(
    app: &mut App,
    set: impl SystemSet + Clone,
    weigh: impl IntoScheduleConfigs<ScheduleSystem, W>,
    give: impl IntoScheduleConfigs<ScheduleSystem, G>,
) {
    let Some(schedule) = app.get_added_plugins::<ClothPlugin>().first().map(|it| it.schedule())
    else {
        return;
    };
    if !is_in_ticks(app, set) {
        tracing::info!(
            "{} moves bodies once a frame: cloths collide with them, and do not move them; let it run in a fixed schedule",
            E::NAME
        );
        return;
    }
    let (couple, weigh, give) = (couple::<E>, weigh.into_configs(), give.into_configs());
    app.configure_sets(
        schedule,
        (
            (Coupling(Adapting::Avian), Coupling(Adapting::Rapier))
                .chain()
                .after(Adapting::Rapier)
                .before(ClothSystems::Setup),
            (Giving(Adapting::Avian), Giving(Adapting::Rapier)).chain().after(ClothSystems::Finish),
        ),
    )
    .add_systems(
        schedule,
        ((couple, weigh).chain().in_set(Coupling(E::SET)), give.in_set(Giving(E::SET))),
    );
}

/// The systems that find the bodies of an engine which cloths move, and say how heavy they are.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Coupling(Adapting);

/// The systems that give bodies of an engine their impulses.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Giving(Adapting);

/// A collider of an engine, and all that says whether and how cloths collide with it.
#[derive(QueryData)]
#[query_data(mutable)]
struct Found<E: Engine> {
    entity: Entity,
    shape: Ref<'static, E::Collider>,
    wish: Option<&'static ClothCollider>,
    friction: Option<&'static E::Friction>,
    sensor: Has<E::Sensor>,
    disabled: Has<E::ColliderDisabled>,
    passed: Has<SdfColliderDisabled>,
    bakes: Has<BakeSdf>,
    adapted: Option<&'static mut Adapted>,
    collider: Option<&'static mut SdfCollider>,
    scale: Option<&'static mut OwnScale>,
    pose: Option<&'static mut ColliderPose>,
}

/// Gives colliders of an engine an `SdfCollider`, changes it, and takes it off.
fn adapt<E: Engine>(
    mut colliders: Query<Found<E>, With<E::Known>>,
    bodies: Bodies<E>,
    mut frictions: FrictionChanges<E>,
    all: Option<Res<All<E>>>,
    mut bakes: ResMut<Bakes>,
    mut commands: Commands,
    mut failures: Failures,
) {
    let mut untidy = false;
    let is_rubbed_as_before = !frictions.any();
    for found in &mut colliders {
        let entity = found.entity;
        let is_wanted = (all.is_some() || found.wish.is_some())
            && !(found.sensor || found.disabled || found.bakes)
            && !(found.passed && found.adapted.is_none())
            && !bodies.is_disabled(entity);
        let is_ours = found.adapted.as_ref().is_none_or(|it| it.engine == E::NAME);
        match (is_wanted, &found.adapted) {
            (false, Some(_)) if is_ours => {
                commands.entity(entity).try_remove::<(SdfCollider, Adapted, OwnScale)>();
                failures.clear(entity, Blame::Engine);
                untidy = true;
            }
            (false, _) => {}
            (true, Some(adapted)) if !is_ours => {
                let problem = EngineProblem::TwoEngines { kept: adapted.engine };
                failures.report(entity, ClothErrorKind::Engine(problem));
            }
            (true, Some(_)) if is_rubbed_as_before && found.is_settled() => {}
            // One of the user's own.
            (true, None) if found.collider.is_some() => {}
            (true, _) => {
                untidy |= keep::<E>(found, &bodies, &mut bakes, &mut commands, &mut failures);
            }
        }
    }
    if untidy {
        bakes.tidy();
    }
}

/// Gives a collider its `SdfCollider`, or changes it. Returns whether a field may have been let go of.
fn keep<E: Engine>(
    mut found: FoundItem<E>,
    bodies: &Bodies<E>,
    bakes: &mut Bakes,
    commands: &mut Commands,
    failures: &mut Failures,
) -> bool {
    let wish = found.wish.copied().unwrap_or_default();
    let own = found.friction.or_else(|| bodies.friction(found.entity)).map(E::friction);
    let friction = wish.friction.or(own).unwrap_or(FRICTION);
    let known = found.adapted.as_mut().filter(|it| it.wish == wish && !found.shape.is_changed());
    if let Some(known) = &known
        && (known.is_waiting() || known.is_given(found.collider.is_some()))
    {
        if let Some(collider) = &mut found.collider {
            set_surface(collider, friction, wish);
        }
        return false;
    }
    let solid = match known {
        Some(known) => known.solid.take(),
        None => None,
    };
    let (solid, outcome) = match solid.map_or_else(|| read::<E>(&found.shape, wish, bakes), Ok) {
        Ok((solid, scale)) => {
            let outcome = solid.shape().map(|shape| shape.map(|shape| (shape, scale)));
            (outcome.is_ok().then_some((solid, scale)), outcome)
        }
        Err(problem) => (None, Err(problem)),
    };
    let waits = matches!(outcome, Ok(None));
    let adapted = Adapted { engine: E::NAME, wish, solid, waits, brings: false };
    let mut entity = commands.entity(found.entity);
    match (outcome, found.collider, found.scale) {
        (Ok(Some((shape, scale))), Some(mut collider), Some(mut own)) => {
            // Another solid of another scale has not grown from the one before.
            if own.0 != scale
                && !is_same(&collider.shape, &shape)
                && let Some(mut pose) = found.pose
            {
                *pose = default();
            }
            (collider.shape, own.0) = (shape, scale);
            set_surface(&mut collider, friction, wish);
            entity.try_insert(adapted);
        }
        (Ok(Some((shape, scale))), ..) => {
            let collider = SdfCollider { shape, friction, layers: wish.layers };
            // In one go: each change of its components would move the entity.
            let adapted = Adapted { brings: true, ..adapted };
            entity.try_insert((collider, OwnScale(scale), adapted));
        }
        (Ok(None), ..) => {
            entity.try_insert(adapted);
        }
        (Err(problem), ..) => {
            entity.try_remove::<(SdfCollider, OwnScale)>().try_insert(adapted);
            failures.report(found.entity, ClothErrorKind::Engine(problem));
            return true;
        }
    }
    failures.clear(found.entity, Blame::Engine);
    true
}

/// Whether two shapes are one field.
fn is_same(a: &SdfShape, b: &SdfShape) -> bool {
    let (SdfShape::Custom(a), SdfShape::Custom(b)) = (a, b) else {
        return false;
    };
    Arc::ptr_eq(&a.0, &b.0)
}

/// Friction and layers, where they have changed.
fn set_surface(collider: &mut Mut<SdfCollider>, friction: f32, wish: ClothCollider) {
    if collider.friction.to_bits() != friction.to_bits() || collider.layers != wish.layers {
        (collider.friction, collider.layers) = (friction, wish.layers);
    }
}

fn read<E: Engine>(
    collider: &E::Collider,
    wish: ClothCollider,
    bakes: &mut Bakes,
) -> Result<(EngineSolid, f32), EngineProblem> {
    let ClothCollider { friction, thickness, cells, .. } = wish;
    check("the friction", friction.unwrap_or_default(), 1e3, "from 0 to 1000")?;
    check("the thickness", thickness, 1e7, "from 0 to 1e7 m")?;
    E::read(collider, &mut Reader { bakes, cells, thickness })
}

fn check(
    name: &'static str,
    value: f32,
    most: f32,
    range: &'static str,
) -> Result<(), EngineProblem> {
    let is_sound = (0.0..=most).contains(&value);
    let problem = ParameterError { name, value, range };
    if is_sound { Ok(()) } else { Err(EngineProblem::Parameter(problem)) }
}

/// When the engine's collider is removed, so is its `SdfCollider`.
fn forget<E: Engine>(
    removed: On<Remove, E::Collider>,
    adapted: Query<&Adapted>,
    mut commands: Commands,
    mut failures: Failures,
) {
    failures.clear(removed.entity, Blame::Engine);
    if adapted.get(removed.entity).is_ok_and(|it| it.engine == E::NAME) {
        commands.entity(removed.entity).try_remove::<(SdfCollider, Adapted, OwnScale)>();
    }
}

/// An `SdfCollider` of the user's takes the place of one that is kept here.
fn leave_alone(
    inserted: On<Insert, SdfCollider>,
    mut adapted: Query<&mut Adapted>,
    mut commands: Commands,
    mut failures: Failures,
) {
    if let Ok(mut adapted) = adapted.get_mut(inserted.entity)
        && !core::mem::take(&mut adapted.bypass_change_detection().brings)
    {
        commands.entity(inserted.entity).try_remove::<(Adapted, OwnScale)>();
        failures.clear(inserted.entity, Blame::Engine);
    }
}
