//! Which cloths take a tick: not those that are frozen, that sleep, or that have diverged.

use super::{ClothSimulation, attachment::gather_motions};
use crate::{
    collider::Disturbances,
    error::{Blame, ClothError, Failures},
    solver::ParameterError,
};
use bevy::prelude::*;

/// When a cloth goes to sleep: it then costs next to nothing until something could move it. A cloth
/// without this component has the default.
///
/// It is woken by pins and anchors that move, changed pins, material, settings or gravity, colliders
/// that move, appear, change or vanish near it, teleports, resets, and
/// [`ClothSimulation::wake`]. Cloth that nothing damps may swing for ever, and never sleeps.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothSleep {
    /// Speed along any axis below which a particle is still [m/s], taken over a tick. Higher sleeps
    /// sooner; 0 never. The default is 5 mm/s.
    pub speed: f32,
    /// Time for which all particles have to be still \[s\]. Higher sleeps later. The default of 0.5 s
    /// is far longer than a swing takes to turn.
    pub time: f32,
}

impl Default for ClothSleep {
    fn default() -> Self {
        Self { speed: 0.005, time: 0.5 }
    }
}

impl ClothSleep {
    /// The cloth never sleeps.
    pub const NEVER: Self = Self { speed: 0.0, time: 0.5 };

    fn validate(&self) -> Result<(), ParameterError> {
        if !(self.speed >= 0.0 && self.speed.is_finite()) {
            let range = "at least 0 m/s, and finite";
            return Err(ParameterError { name: "speed", value: self.speed, range });
        }
        if !(self.time >= 0.0 && self.time.is_finite()) {
            let range = "at least 0 s, and finite";
            return Err(ParameterError { name: "time", value: self.time, range });
        }
        Ok(())
    }
}

/// Stops a cloth for as long as it is on the entity.
///
/// The cloth keeps its shape. Its entity, or the anchor that leads it, carries it along rigidly. When the
/// component is removed the cloth goes on with the velocities that it had, turned with it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn step_once(mut frozen: Single<&mut ClothFrozen>) {
///     frozen.steps += 1;
/// }
/// # bevy::ecs::system::assert_is_system(step_once);
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothFrozen {
    /// Ticks that the cloth is to take all the same; each takes one off.
    pub steps: u32,
}

/// Whether a cloth has anything to do.
#[derive(Default)]
pub(crate) struct Rest {
    sleep: ClothSleep,
    /// How long all particles have been still \[s\].
    still: f32,
    asleep: bool,
    /// Something has happened that could move it.
    disturbed: bool,
    /// It took the last tick.
    stepped: bool,
    /// Gravity of the last tick.
    gravity: Option<Vec3>,
}

impl Rest {
    /// Something has happened that could move the cloth.
    pub fn disturb(&mut self) {
        self.disturbed = true;
    }

    pub fn is_asleep(&self) -> bool {
        self.asleep && !self.disturbed
    }

    /// Notes how far the cloth moved in a tick of `dt` seconds.
    pub fn note_tick(&mut self, largest_move: f32, dt: f32) {
        let still = largest_move < self.sleep.speed * dt;
        self.still = if still { self.still + dt } else { 0.0 };
    }

    fn set_sleep(&mut self, sleep: Option<&ClothSleep>) -> Result<(), ParameterError> {
        let sleep = sleep.copied().unwrap_or_default();
        sleep.validate()?;
        self.disturbed |= sleep != self.sleep;
        self.sleep = sleep;
        Ok(())
    }

    /// Falls asleep or wakes.
    fn choose(&mut self, gravity: Vec3) {
        self.disturbed |= self.gravity != Some(gravity);
        self.gravity = Some(gravity);
        if core::mem::take(&mut self.disturbed) {
            self.still = 0.0;
            self.asleep = false;
        } else {
            self.asleep |= self.still > 0.0 && self.still >= self.sleep.time;
        }
    }
}

/// Decides which cloths take this tick, and where the pins of those go.
pub(crate) fn choose_steps(
    mut cloths: Query<(
        Entity,
        &mut ClothSimulation,
        Option<&ClothSleep>,
        Option<&mut ClothFrozen>,
    )>,
    disturbances: Res<Disturbances>,
    mut failures: Failures,
) {
    for (entity, mut cloth, sleep, frozen) in &mut cloths {
        let cloth = &mut *cloth;
        match cloth.rest.set_sleep(sleep) {
            Ok(()) => failures.clear(entity, Blame::Sleep),
            Err(problem) => {
                let component = "ClothSleep";
                failures.report(entity, ClothError::Parameter { entity, component, problem });
            }
        }
        if disturbances.reach(cloth.solver.bounds(), cloth.material.thickness) {
            cloth.rest.disturb();
        }
        cloth.rest.choose(cloth.step.gravity);
        let stands = frozen.is_some_and(|mut frozen| {
            let stands = frozen.steps == 0;
            if !stands {
                frozen.steps -= 1;
            }
            stands
        });
        let steps = !(stands || cloth.quarantined || cloth.rest.asleep);
        if steps {
            cloth.step.gravity = cloth.following.gravity(cloth.step.gravity);
            gather_motions(cloth);
        } else if cloth.rest.stepped {
            cloth.solver.stand_still();
        }
        cloth.step.runs = steps;
        cloth.rest.stepped = steps;
    }
}
