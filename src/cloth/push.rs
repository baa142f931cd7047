//! Pushing a cloth from a game: forces that go on, and pushes of one tick.

use super::ClothSimulation;
use crate::{
    error::{Blame, ClothError, Failures},
    solver::{PushOn, PushWith, SolverError},
};
use bevy::prelude::*;

/// Forces that act on a cloth in every tick, for as long as they are here: a thrust, a weight hung from a
/// corner, the stream of a hose. May be changed at any time.
///
/// It is the same in the fixed schedule and in `Update`, at any frame rate. For what happens once there
/// are [`ClothSimulation::push`] and [`PushCloth`]; for wind there is [`ClothAir`](super::ClothAir).
///
/// A force that cannot be used is told as a [`ClothError::Forces`] and left out; the others act.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// // A weight of 50 g on one corner.
/// let weight = ClothForce { on: PushOn::Particle(0), force: Vec3::NEG_Y * 0.05 * 9.81 };
/// commands.spawn((
///     Cloth::sheet(Vec2::ONE, UVec2::splat(32)),
///     ClothPins::from(PinSelection::LastRow),
///     ClothForces::from(weight),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothForces {
    /// The forces. They add up.
    pub forces: Vec<ClothForce>,
}

/// A force on some particles of a cloth.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub struct ClothForce {
    /// What it acts on. A ball is looked at anew in each tick.
    pub on: PushOn,
    /// The force \[N\], in world axes, shared by all that it acts on. Longer pushes harder.
    pub force: Vec3,
}

impl From<ClothForce> for ClothForces {
    fn from(force: ClothForce) -> Self {
        Self { forces: vec![force] }
    }
}

/// Pushes a cloth in its next tick, once: [`ClothSimulation::push`] from where there are only `Commands`.
///
/// What cannot be used is told as a [`ClothError::Push`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn explode(mut commands: Commands, cloths: Query<Entity, With<Cloth>>) {
///     for entity in &cloths {
///         let on = PushOn::Within { centre: Vec3::ZERO, radius: 2.0, falloff: 1.0 };
///         commands.trigger(PushCloth { entity, on, with: PushWith::Velocity(Vec3::Y * 5.0) });
///     }
/// }
/// # bevy::ecs::system::assert_is_system(explode);
/// ```
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq)]
pub struct PushCloth {
    /// The cloth.
    pub entity: Entity,
    /// The particles.
    pub on: PushOn,
    /// What they are pushed with.
    pub with: PushWith,
}

/// Passes a push on to the running cloth.
pub(crate) fn ask_for_push(
    event: On<PushCloth>,
    mut cloths: Query<&mut ClothSimulation>,
    mut failures: Failures,
) {
    let PushCloth { entity, on, with } = *event;
    match cloths.get_mut(entity).map(|mut cloth| cloth.push(on, with)) {
        Ok(Ok(())) => failures.clear(entity, Blame::Push),
        Ok(Err(problem)) => failures.report(entity, ClothError::Push { entity, problem }),
        Err(_) => tracing::warn!(
            "{entity} is no running cloth, so that nothing was pushed; a new one can be from its `ClothReady` on"
        ),
    }
}

/// What pushes a cloth.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pushing {
    /// What was asked for since the last tick, in that order.
    pub asked: Vec<(PushOn, PushWith)>,
    /// The forces that went on in the last tick.
    pub forces: Vec<ClothForce>,
}

impl ClothSimulation {
    /// Pushes particles in the next tick, once: by a force through that tick, or by an impulse or a change of
    /// velocity at its start. Pushes add up, and wake the cloth. What is pinned does not move.
    ///
    /// May be called from any system. From one that runs once a frame, give impulses or velocities: a force
    /// that is to go on is a [`ClothForces`], at any frame rate. A cloth that takes no step in the next tick
    /// (see [`ClothFrozen`](super::ClothFrozen)) is not pushed, nor later.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`], [`SolverError::Parameter`] for a radius or falloff that is out of its
    /// range, [`SolverError::Push`] for what is not finite or too large; nothing is pushed then.
    pub fn push(&mut self, on: PushOn, with: PushWith) -> Result<(), SolverError> {
        self.solver.check_push(on, with)?;
        if matches!(with, PushWith::Force(_)) {
            self.solver.make_room_for_forces();
        }
        self.pushing.asked.push((on, with));
        self.wake();
        Ok(())
    }
}

/// Wakes what is pushed otherwise than before.
pub(crate) fn disturb(cloth: &mut ClothSimulation, forces: Option<&ClothForces>) {
    let forces = forces.map_or(&[][..], |forces| &forces.forces);
    if cloth.pushing.forces != forces {
        cloth.pushing.forces.clear();
        cloth.pushing.forces.extend_from_slice(forces);
        cloth.rest.disturb();
    }
}

/// Forgets what was asked for, as the cloth stands.
pub(crate) fn forget(cloth: &mut ClothSimulation) {
    cloth.pushing.asked.clear();
}

/// Gives the solver what pushes in this tick.
pub(crate) fn push(entity: Entity, cloth: &mut ClothSimulation, failures: &mut Failures) {
    let ClothSimulation { solver, following, pushing, .. } = cloth;
    // In the ride, directions are those that are seen from it.
    let mut give = |on, with: PushWith| solver.push(on, with.map(|vector| following.seen(vector)));
    for (on, with) in pushing.asked.drain(..) {
        if let Err(problem) = give(on, with) {
            failures.report(entity, ClothError::Push { entity, problem });
        }
    }
    let mut good = true;
    for (force, &ClothForce { on, force: vector }) in pushing.forces.iter().enumerate() {
        if let Err(problem) = give(on, PushWith::Force(vector)) {
            good = false;
            failures.report(entity, ClothError::Forces { entity, force, problem });
        }
    }
    if good {
        failures.clear(entity, Blame::Forces);
    }
}
