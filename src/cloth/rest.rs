//! Which cloths take a tick: not those that are frozen, that sleep, or that have diverged.

use super::{
    ClothForces, ClothSimulation, ClothSlept, ClothWoke, attachment::gather_motions, push,
};
use crate::{
    collider::Disturbances,
    error::{Blame, ClothError, Failures},
    solver::{ClothSolver, ParameterError},
};
use bevy::prelude::*;

/// When a cloth goes to sleep: it then costs next to nothing until something could move it. A cloth
/// without this component has the default.
///
/// It is woken by pins and anchors that move, changed pins, material, settings or gravity, colliders
/// that move, appear, change or vanish near it, pushes, forces that change, grabs, teleports, resets, and
/// [`ClothSimulation::wake`]. In wind a cloth with [`ClothAir`](crate::ClothAir) does not sleep. Cloth that nothing damps may swing for ever, and never sleeps.
///
/// It is places that are looked at, not speeds: what trembles on the spot is at rest, and what turns at
/// the end of a swing is not.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothSleep {
    /// How far along any axis a particle may go from where it is and still be at rest \[m\]. Higher
    /// sleeps sooner; 0 never. The default is 3 mm.
    pub distance: f32,
    /// Time for which all particles have to stay that near \[s\]. Higher sleeps later. The default is
    /// 1 s, in which a small pendulum has been at both its ends.
    pub time: f32,
}

impl Default for ClothSleep {
    fn default() -> Self {
        Self { distance: 0.003, time: 1.0 }
    }
}

impl ClothSleep {
    /// The cloth never sleeps.
    pub const NEVER: Self = Self { distance: 0.0, time: 1.0 };

    fn validate(&self) -> Result<(), ParameterError> {
        if !(self.distance >= 0.0 && self.distance.is_finite()) {
            let range = "at least 0 m, and finite";
            return Err(ParameterError { name: "distance", value: self.distance, range });
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
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothFrozen {
    /// Ticks that the cloth is to take all the same; each takes one off.
    pub steps: u32,
}

/// Whether a cloth has anything to do.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Rest {
    sleep: ClothSleep,
    /// How long all particles have been near where they were marked \[s\].
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

    /// Notes how far the cloth has gone in a tick of `dt` seconds.
    pub fn note_tick(&mut self, solver: &mut ClothSolver, dt: f32) {
        if self.sleep.distance == 0.0 {
            self.still = 0.0;
        } else if self.still == 0.0 || solver.distance_from_mark() > self.sleep.distance {
            solver.mark();
            self.still = dt;
        } else {
            self.still += dt;
        }
    }

    /// Whether it could be that of any cloth.
    pub fn is_sound(&self) -> bool {
        let time = (0.0..f32::INFINITY).contains(&self.still);
        time && self.sleep.validate().is_ok() && self.gravity.is_none_or(Vec3::is_finite)
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
        Option<&ClothForces>,
    )>,
    disturbances: Res<Disturbances>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for (entity, mut cloth, sleep, frozen, forces) in &mut cloths {
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
        push::disturb(cloth, forces);
        let slept = cloth.rest.asleep;
        cloth.rest.choose(cloth.step.gravity);
        match (slept, cloth.rest.asleep) {
            (false, true) => commands.trigger(ClothSlept { entity }),
            (true, false) => commands.trigger(ClothWoke { entity }),
            _ => {}
        }
        if let Some(hanging) = &mut cloth.hanging {
            hanging.begin();
        }
        let takes_no_step = |mut frozen: Mut<ClothFrozen>| {
            let stands = frozen.steps == 0;
            if !stands {
                frozen.steps -= 1;
            }
            stands
        };
        let stands = cloth.is_hanging() || frozen.is_some_and(takes_no_step);
        let steps = !(stands || cloth.quarantined || cloth.rest.asleep);
        if steps {
            cloth.step.gravity = cloth.following.seen(cloth.step.gravity);
            cloth.step.wind.velocity = cloth.following.seen(cloth.step.wind.velocity);
            gather_motions(cloth);
            push::push(entity, cloth, &mut failures);
        } else if cloth.rest.stepped {
            cloth.solver.stand_still();
        }
        push::forget(cloth);
        cloth.step.runs = steps;
        cloth.rest.stepped = steps;
    }
}
