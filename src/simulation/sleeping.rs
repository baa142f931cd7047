//! Which cloths take a tick: not those that are frozen, that sleep, or that have diverged.

use bevy::prelude::*;

use crate::cloth::events::{ClothSlept, ClothWoke};
use crate::cloth::forces::ClothForces;
use crate::cloth::sleep::{ClothPaused, ClothSleepThreshold};
use crate::collider::disturbance::Disturbances;
use crate::collider::mass::{ColliderBody, ColliderMass};
use crate::error::ClothComponent;
use crate::error::failures::Failures;
use crate::simulation::ClothSimulation;
use crate::simulation::tick_state::TickState;
use crate::solver::{ClothSolver, ParameterError};

/// Part of the time that a cloth has to be still for. A cloth that hardly moves goes no further in it than one that is still, and is braked
/// after it.
const BRAKED_AFTER: f32 = 0.05;
/// Times its drag by which it is braked then, beside its drag, and the most that both may be together \[1/s\]. More would hinder it on its
/// way to rest.
const BRAKING: f32 = 4.0;
const MOST_BRAKED: f32 = 5.0;

/// Whether a cloth has anything to do.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SleepState {
    sleep: ClothSleepThreshold,
    /// How long all particles have been near where they were marked \[s\].
    still: f32,
    /// How long it has hardly moved \[s\]. It goes on whatever disturbs the cloth: one that is saved and loaded has the same bits.
    slow: f32,
    asleep: bool,
    /// Something has happened that could move it.
    disturbed: bool,
    /// The cloth took the last tick.
    stepped: bool,
    /// In the last tick it touched a cloth that is not ready to sleep, be it by way of others.
    kept_awake: bool,
    /// Gravity of the last tick.
    gravity: Option<Vec3>,
}

impl SleepState {
    /// Something has happened that could move the cloth.
    pub fn disturb(&mut self) {
        self.disturbed = true;
    }

    pub fn is_asleep(&self) -> bool {
        self.asleep && !self.disturbed
    }

    /// Notes how far the cloth has gone in a tick of `dt` seconds.
    pub fn note_tick(&mut self, solver: &mut ClothSolver, dt: f32) {
        let most = self.sleep.distance * dt / (BRAKED_AFTER * self.sleep.time).max(dt);
        let is_slow = self.sleep.distance > 0.0 && solver.largest_move() <= most;
        self.slow = if is_slow { self.slow + dt } else { 0.0 };
        if self.sleep.distance == 0.0 {
            self.still = 0.0;
        } else if self.still == 0.0 || solver.distance_from_mark() > self.sleep.distance {
            solver.mark();
            self.still = dt;
        } else {
            self.still += dt;
        }
    }

    /// Drag beside the material's, of a cloth of a `drag`, so that what hardly moves comes to rest \[1/s\].
    fn braking(&self, drag: f32) -> f32 {
        let is_braked = self.slow > 0.0 && self.slow >= BRAKED_AFTER * self.sleep.time;
        if is_braked { (BRAKING * drag).min((MOST_BRAKED - drag).max(0.0)) } else { 0.0 }
    }

    /// Whether the cloth has been still for long enough to sleep.
    pub fn is_ready(&self) -> bool {
        self.still > 0.0 && self.still >= self.sleep.time
    }

    /// Says whether what it lies on, or what lies on it, keeps it awake.
    pub fn keep_awake(&mut self, kept_awake: bool) {
        self.kept_awake = kept_awake;
    }

    /// Whether it could be that of any cloth.
    pub fn is_sound(&self) -> bool {
        let is_time = |time| (0.0..f32::INFINITY).contains(&time);
        is_time(self.still)
            && is_time(self.slow)
            && self.sleep.validate().is_ok()
            && self.gravity.is_none_or(Vec3::is_finite)
    }

    fn set_sleep(&mut self, sleep: Option<&ClothSleepThreshold>) -> Result<(), ParameterError> {
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
            self.asleep |= self.is_ready() && !self.kept_awake;
        }
        if self.asleep {
            self.slow = 0.0;
        }
    }
}

/// Decides which cloths take this tick, and where the pins of those go.
pub(crate) fn choose_steps(
    mut cloths: Query<(
        Entity,
        &mut ClothSimulation,
        Option<&ClothSleepThreshold>,
        Option<&mut ClothPaused>,
        Option<&ClothForces>,
    )>,
    bodies: Query<(Has<ColliderMass>, Option<&ColliderBody>, Option<&ChildOf>)>,
    masses: Query<(), With<ColliderMass>>,
    disturbances: Res<Disturbances>,
    mut commands: Commands,
    mut failures: Failures,
) {
    let has_bodies = !masses.is_empty();
    // The body that an anchor is of, or is below. A cloth that holds to its own entity goes along with what that is below.
    let body_of = |cloth, anchor| {
        let mut at = has_bodies.then_some(anchor);
        while let Some(entity) = at {
            match bodies.get(entity).ok()? {
                (_, Some(part), _) => return Some(part.0),
                (true, ..) => return Some(entity),
                (.., parent) => at = parent.filter(|_| anchor != cloth).map(ChildOf::parent),
            }
        }
        None
    };
    for (entity, mut cloth, sleep, frozen, forces) in &mut cloths {
        let cloth = &mut *cloth;
        let outcome = cloth.sleep.set_sleep(sleep);
        failures.tell_numbers(entity, ClothComponent::ClothSleepThreshold, outcome);
        if disturbances.reach(cloth.solver.bounds(), cloth.in_force.material.thickness) {
            cloth.sleep.disturb();
        }
        if cloth.pushing.set_forces(forces) {
            cloth.sleep.disturb();
        }
        let slept = cloth.sleep.asleep;
        cloth.sleep.choose(cloth.tick.step.gravity);
        match (slept, cloth.sleep.asleep) {
            (false, true) => commands.trigger(ClothSlept { entity }),
            (true, false) => commands.trigger(ClothWoke { entity }),
            _ => {}
        }
        if let Some(hanging) = &mut cloth.start.hanging {
            hanging.begin();
        }
        let takes_no_step = |mut frozen: Mut<ClothPaused>| {
            let stands = frozen.steps == 0;
            if !stands {
                frozen.steps -= 1;
            }
            stands
        };
        let stands = cloth.is_hanging() || cloth.is_culled() || frozen.is_some_and(takes_no_step);
        let steps = !(stands || cloth.progress.quarantined || cloth.sleep.asleep);
        if steps {
            let ClothSimulation { solver, held, skin, frame, pushing, sleep, tick, .. } =
                &mut *cloth;
            let TickState { step, motions, .. } = tick;
            let body = |anchor| body_of(entity, anchor);
            step.gravity = frame.seen(step.gravity);
            step.wind.velocity = frame.seen(step.wind.velocity);
            held.gather_motions(solver, skin.as_deref(), frame.ride, body, motions);
            if let Some(skin) = skin {
                skin.gather_motions(frame.ride, &mut motions.skin);
            }
            pushing.push(entity, solver, frame, &mut failures);
            // Few hardly move: those alone are looked at for what leads them.
            let braking = sleep.braking(solver.material().drag);
            let is_free = |tick: &TickState| skin.is_none() && tick.way_of_pins() == 0.0;
            let is_braked = braking > 0.0 && solver.air().is_none() && is_free(tick);
            tick.step.braking = if is_braked { braking } else { 0.0 };
        } else if cloth.sleep.stepped {
            cloth.solver.stand_still();
        }
        cloth.pushing.forget();
        cloth.tick.step.runs = steps;
        cloth.tick.step.begins = steps && !cloth.sleep.stepped;
        cloth.sleep.stepped = steps;
    }
}
