//! Pushes: forces through the next tick, impulses and changes of velocity at its start.
//!
//! A push on many particles is shared out by their mass, times how near they are: what is pushed as a whole
//! moves as a whole, and a finer cloth moves alike. What falls to a held particle, its pin bears.

use bevy_math::Vec3;

use crate::solver::error::SolverError;
use crate::solver::settings::{ParameterError, is_near};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Acceleration that no push may give a particle \[m/s2\].
pub(crate) const MOST_ACCELERATION: f32 = 1e9;

/// The particles that are pushed.
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum PushOn {
    /// One particle.
    Particle(u32),
    /// All particles within a ball.
    Within {
        /// Its middle, in world space \[m\].
        centre: Vec3,
        /// Its radius \[m\], above 0. Larger reaches more.
        radius: f32,
        /// Depth below its surface from which the push is whole \[m\]; towards the surface it fades
        /// smoothly. Higher is softer: 0 is a hard border, from `radius` on it is whole in the middle
        /// alone.
        falloff: f32,
    },
    /// All of the cloth.
    All,
}

/// The force, impulse or change of velocity that particles are pushed with.
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum PushWith {
    /// A force through the whole of the next tick \[N\], shared by all that is pushed.
    Force(Vec3),
    /// An impulse at the next tick's start [N s], shared by all that is pushed.
    Impulse(Vec3),
    /// A change of velocity at the next tick's start [m/s], the same for all that is pushed, but for the
    /// falloff.
    Velocity(Vec3),
}

impl PushOn {
    /// Checks the numbers.
    pub(crate) fn validate(&self, particles: usize) -> Result<(), SolverError> {
        match *self {
            Self::All => Ok(()),
            Self::Particle(particle) if (particle as usize) < particles => Ok(()),
            Self::Particle(particle) => {
                Err(SolverError::NoSuchParticle { particle: particle as usize, count: particles })
            }
            Self::Within { centre, .. } if !is_near(centre) => {
                Err(SolverError::Push { what: "centre" })
            }
            Self::Within { radius, falloff, .. } => {
                if !(radius > 0.0 && radius <= 1e7) {
                    let range = "above 0 and at most 1e7 m";
                    return Err(ParameterError { name: "radius", value: radius, range }.into());
                }
                if !(0.0..=1e7).contains(&falloff) {
                    let range = "from 0 to 1e7 m";
                    return Err(ParameterError { name: "falloff", value: falloff, range }.into());
                }
                Ok(())
            }
        }
    }

    /// Part of the push that a place of the world feels, from 0 to 1.
    pub(crate) fn part_at(&self, place: Vec3) -> f32 {
        let Self::Within { centre, radius, falloff } = *self else {
            return 1.0;
        };
        let away = place - centre;
        let depth = radius - away.dot(away).sqrt();
        if depth < 0.0 {
            return 0.0;
        }
        // A falloff beyond the radius would leave nothing whole.
        let falloff = falloff.min(radius);
        let part = if depth < falloff { depth / falloff } else { 1.0 };
        part * part * (3.0 - 2.0 * part)
    }
}

impl PushWith {
    /// The vector.
    pub(crate) fn vector(self) -> Vec3 {
        match self {
            Self::Force(vector) | Self::Impulse(vector) | Self::Velocity(vector) => vector,
        }
    }

    /// Changes the vector of a push.
    #[must_use]
    pub fn map(self, change: impl FnOnce(Vec3) -> Vec3) -> Self {
        match self {
            Self::Force(force) => Self::Force(change(force)),
            Self::Impulse(impulse) => Self::Impulse(change(impulse)),
            Self::Velocity(velocity) => Self::Velocity(change(velocity)),
        }
    }
}

/// Forces on particles in the next tick.
#[derive(Clone, Debug)]
pub(crate) struct Pushes {
    /// Force on each particle \[N\]; zero where it has none.
    pub forces: Soa,
    /// Sum of the forces' magnitudes, in the order in which they came \[N\]; 0 where there are none.
    pub strength: f32,
}

impl Pushes {
    /// Adds the forces to accelerations.
    pub fn add(&self, isa: Isa, layout: Layout, inverse_mass: &[f32], a: &mut Soa) {
        self.add_part(1.0, isa, layout, inverse_mass, a);
    }

    pub(crate) fn add_part(
        &self,
        part: f32,
        isa: Isa,
        layout: Layout,
        inverse_mass: &[f32],
        to: &mut Soa,
    ) {
        if self.strength > 0.0 {
            isa.run(AddForces { layout, inverse_mass, part, forces: &self.forces, to });
        }
    }
}

/// Adds a part of the accelerations that forces make.
struct AddForces<'a> {
    layout: Layout,
    inverse_mass: &'a [f32],
    part: f32,
    forces: &'a Soa,
    to: &'a mut Soa,
}

impl Kernel for AddForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let w = Block::load(self.inverse_mass, slot);
                let (force, mut to) =
                    (Block3::load(self.forces, slot), Block3::load(self.to, slot));
                for i in 0..LANES {
                    to.set(i, to.at(i) + force.at(i) * (w.0[i] * self.part));
                }
                to.store(self.to, slot);
            }
        }
    }
}
