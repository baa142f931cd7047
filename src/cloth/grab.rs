//! A hand on a cloth: particles that are drawn towards a place by a soft spring, with no more than so much
//! force, for as long as it holds.

use super::{ClothSimulation, attachment::hold_anew};
use crate::{
    error::{Blame, ClothError, Failures},
    solver::{ClothSolver, ParameterError, SoftPin},
};
use bevy::prelude::*;

/// Pulls a cloth towards a place, for as long as it is on the entity: what a mouse, a hand or a hook does.
/// Removing it lets go.
///
/// The particles are chosen when it comes and when [`hold`](ClothGrab::hold) changes, and keep their places
/// around their middle, which is drawn to the target. The target may be moved in the fixed schedule or once
/// a frame. What a pin holds, the pin keeps.
///
/// One that cannot be used is told as a [`ClothError::Grab`], and holds nothing.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn pull(mut commands: Commands, cloth: Single<(Entity, &ClothSimulation)>) {
///     let (entity, simulation) = *cloth;
///     if let Some(place) = simulation.position(0) {
///         let target = place + Vec3::Y;
///         commands.entity(entity).insert(ClothGrab::particle(0, target));
///     }
/// }
/// # bevy::ecs::system::assert_is_system(pull);
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Debug, PartialEq, Clone)]
pub struct ClothGrab {
    /// What is grabbed.
    pub hold: GrabHold,
    /// Where the middle of what is grabbed is drawn, in world space \[m\].
    pub target: Vec3,
    /// Constant of the spring \[N/m\], above 0, shared by all that is grabbed. Higher follows closer.
    pub stiffness: f32,
    /// Constant of the damper beside it \[N s/m\]. Higher swings less.
    pub damping: f32,
    /// Force that it does not exceed \[N\], above 0. Higher pulls harder, and drags what is pinned longer;
    /// infinite is no limit.
    pub max_force: f32,
}

/// What a [`ClothGrab`] grabs.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub enum GrabHold {
    /// One particle.
    Particle(u32),
    /// All that is within a ball as it is grabbed.
    Within {
        /// The ball's middle, in world space \[m\].
        centre: Vec3,
        /// Its radius \[m\], above 0. Larger grabs more.
        radius: f32,
    },
}

impl ClothGrab {
    /// Grabs one particle.
    pub fn particle(particle: u32, target: Vec3) -> Self {
        Self::new(GrabHold::Particle(particle), target)
    }

    /// Grabs what is within a ball in world space \[m\].
    pub fn within(centre: Vec3, radius: f32, target: Vec3) -> Self {
        Self::new(GrabHold::Within { centre, radius }, target)
    }

    /// 200 N/m, 1 N s/m, and 20 N at most: what a hand does to a garment.
    fn new(hold: GrabHold, target: Vec3) -> Self {
        Self { hold, target, stiffness: 200.0, damping: 1.0, max_force: 20.0 }
    }

    fn validate(&self) -> Result<(), GrabProblem> {
        SoftPin::check(self.stiffness, self.damping)?;
        if self.max_force.is_nan() || self.max_force <= 0.0 {
            let range = "above 0 N";
            let value = self.max_force;
            return Err(ParameterError { name: "max_force", value, range }.into());
        }
        let is_near = |p: Vec3| p.is_finite() && p.abs().max_element() <= 1e7;
        if !is_near(self.target) {
            return Err(GrabProblem::Place("target"));
        }
        if let GrabHold::Within { centre, radius } = self.hold {
            if !is_near(centre) {
                return Err(GrabProblem::Place("centre"));
            }
            if !(radius > 0.0 && radius <= 1e7) {
                let range = "above 0 and at most 1e7 m";
                return Err(ParameterError { name: "radius", value: radius, range }.into());
            }
        }
        Ok(())
    }

    /// Whether only the target is another.
    fn holds_as(&self, other: &Self) -> bool {
        Self { target: other.target, ..*self } == *other
    }
}

/// Why a [`ClothGrab`] holds nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GrabProblem {
    /// There is no such particle.
    #[error("there is no particle {particle}: the cloth has {count}")]
    NoSuchParticle {
        /// The particle asked for.
        particle: u32,
        /// Particles of the cloth.
        count: usize,
    },
    /// No particle is within the ball.
    #[error("no particle is within its ball: make it larger, or start it on the cloth")]
    Nothing,
    /// A place is not finite, or beyond 1e7 m.
    #[error("its {0} is not finite, or beyond 1e7 m")]
    Place(&'static str),
    /// A number is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// What is grabbed of a running cloth.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Grabbed {
    asked: ClothGrab,
    /// The particles, ascending, and where they are around their middle \[m\].
    chosen: Vec<(u32, Vec3)>,
    /// Those that no pin holds.
    held: Vec<(u32, Vec3)>,
    /// Where the target was at the last tick's end \[m\].
    from: Vec3,
}

impl Grabbed {
    /// Grabs what is asked for, where it is now.
    fn new(asked: ClothGrab, solver: &ClothSolver) -> Result<Self, GrabProblem> {
        asked.validate()?;
        let count = solver.topology().particle_count();
        let particles: Vec<u32> = match asked.hold {
            GrabHold::Particle(particle) if particle as usize >= count => {
                return Err(GrabProblem::NoSuchParticle { particle, count });
            }
            GrabHold::Particle(particle) => vec![particle],
            GrabHold::Within { centre, radius } => {
                let is_in = |&particle: &u32| {
                    let away = solver.position(particle as usize) - centre;
                    away.length_squared() <= radius * radius
                };
                (0..count as u32).filter(is_in).collect()
            }
        };
        if particles.is_empty() {
            return Err(GrabProblem::Nothing);
        }
        let place = |particle: u32| solver.position(particle as usize);
        let sum: Vec3 = particles.iter().map(|&particle| place(particle)).sum();
        let middle = sum / particles.len() as f32;
        let chosen = particles.into_iter().map(|particle| (particle, place(particle) - middle));
        Ok(Self { asked, chosen: chosen.collect(), held: Vec::new(), from: asked.target })
    }

    /// Whether it could be that of a cloth of so many particles.
    pub fn is_sound(&self, particles: usize) -> bool {
        let Self { asked, chosen, held, from } = self;
        let is_sound = |list: &[(u32, Vec3)]| {
            list.is_sorted_by(|(a, _), (b, _)| a < b)
                && list.iter().all(|&(i, at)| (i as usize) < particles && at.is_finite())
        };
        let chosen_too = |it: &(u32, Vec3)| chosen.binary_search_by_key(&it.0, |it| it.0).is_ok();
        asked.validate().is_ok()
            && !chosen.is_empty()
            && is_sound(chosen)
            && is_sound(held)
            && held.iter().all(chosen_too)
            && from.is_finite()
    }

    /// Takes all that no pin holds.
    pub fn take_hold(&mut self, is_pinned: impl Fn(u32) -> bool) {
        self.held.clear();
        self.held.extend(self.chosen.iter().filter(|(particle, _)| !is_pinned(*particle)));
    }

    /// Its springs, in ascending order of the particles.
    pub fn springs(&self) -> impl Iterator<Item = SoftPin> + '_ {
        let part = self.part();
        let stiffness = (self.asked.stiffness * part).max(f32::MIN_POSITIVE);
        let damping = self.asked.damping * part;
        self.held.iter().map(move |&(particle, _)| SoftPin { particle, stiffness, damping })
    }

    /// Force that none of them exceeds \[N\].
    pub fn most_force(&self) -> f32 {
        self.asked.max_force * self.part()
    }

    fn part(&self) -> f32 {
        1.0 / self.chosen.len() as f32
    }

    /// The held particles, and where they are drawn from the tick's start to its end \[m\].
    pub fn ways(&self) -> impl Iterator<Item = (u32, Vec3, Vec3)> + '_ {
        let (from, to) = (self.from, self.asked.target);
        self.held.iter().map(move |&(particle, around)| (particle, from + around, to + around))
    }

    /// The tick's targets have been taken.
    pub fn advance(&mut self) {
        self.from = self.asked.target;
    }
}

/// Grabs, drags and lets go.
pub(crate) fn apply_grabs(
    mut cloths: Query<(Entity, Option<&ClothGrab>, &mut ClothSimulation)>,
    mut failures: Failures,
) {
    for (entity, grab, mut cloth) in &mut cloths {
        let Some(&grab) = grab else {
            if cloth.grab.is_some() {
                let_go(&mut cloth);
            }
            failures.clear(entity, Blame::Grab);
            continue;
        };
        // What is being hung has no hands on it.
        if cloth.tick_count == 0 && cloth.hanging.is_some() {
            continue;
        }
        if let Some(running) = &mut cloth.grab
            && running.asked.holds_as(&grab)
            && grab.validate().is_ok()
        {
            let moved = running.asked.target != grab.target;
            running.asked = grab;
            if moved {
                cloth.rest.disturb();
            }
            continue;
        }
        match Grabbed::new(grab, &cloth.solver) {
            Ok(grabbed) => {
                cloth.grab = Some(Box::new(grabbed));
                hold_anew(&mut cloth);
                failures.clear(entity, Blame::Grab);
            }
            Err(problem) => {
                if cloth.grab.is_some() {
                    let_go(&mut cloth);
                }
                failures.report(entity, ClothError::Grab { entity, problem });
            }
        }
    }
}

fn let_go(cloth: &mut ClothSimulation) {
    cloth.grab = None;
    hold_anew(cloth);
}
