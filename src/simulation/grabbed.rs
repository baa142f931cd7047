//! A hand on a cloth: particles that are drawn towards a place by a soft spring, with no more than so much
//! force, for as long as it holds.

use bevy::prelude::*;

use crate::cloth::grab::{ClothGrab, GrabHold};
use crate::error::problems::GrabProblem;
use crate::solver::{ClothSolver, SoftPin};

/// The grabbed particles of a running cloth.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Grabbed {
    pub(crate) asked: ClothGrab,
    /// The particles, ascending, and where they are around their middle \[m\].
    chosen: Vec<(u32, Vec3)>,
    /// Grabbed particles that no pin holds, and their places.
    held: Vec<(u32, Vec3)>,
    /// Where the target was at the last tick's end \[m\].
    from: Vec3,
}

/// The middle of some particles, of which there are any \[m\].
fn middle(particles: impl ExactSizeIterator<Item = u32>, solver: &ClothSolver) -> Vec3 {
    let count = particles.len() as f32;
    particles.map(|particle| solver.position(particle as usize)).sum::<Vec3>() / count
}

impl Grabbed {
    /// Grabs what is asked for, where it is now.
    pub fn new(asked: ClothGrab, solver: &ClothSolver) -> Result<Self, GrabProblem> {
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
        Ok(Self::with(asked, particles, solver))
    }

    /// Grabs particles where they are now.
    fn with(asked: ClothGrab, particles: Vec<u32>, solver: &ClothSolver) -> Self {
        let middle = middle(particles.iter().copied(), solver);
        let around = |particle: u32| solver.position(particle as usize) - middle;
        let chosen = particles.into_iter().map(|particle| (particle, around(particle)));
        Self { asked, chosen: chosen.collect(), held: Vec::new(), from: asked.target }
    }

    /// Grabs a cloth that goes on with other particles, where they were grabbed: all as near to the middle as was asked for, or the
    /// nearest.
    pub fn go_on(&self, before: &ClothSolver, now: &ClothSolver) -> Self {
        let middle = middle(self.chosen.iter().map(|&(particle, _)| particle), before);
        let away = |particle: u32| now.position(particle as usize).distance_squared(middle);
        let all = 0..now.topology().particle_count() as u32;
        let mut particles: Vec<_> = match self.asked.hold {
            GrabHold::Within { radius, .. } => {
                all.clone().filter(|&particle| away(particle) <= radius * radius).collect()
            }
            GrabHold::Particle(_) => Vec::new(),
        };
        if particles.is_empty() {
            particles.extend(all.min_by(|&a, &b| away(a).total_cmp(&away(b))));
        }
        Self { from: self.from, ..Self::with(self.asked, particles, now) }
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

    /// The grab's springs, in ascending order of the particles.
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
