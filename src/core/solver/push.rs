//! Pushes: forces through the next tick, impulses and changes of velocity at its start.
//!
//! A push on many particles is shared out by their mass, times how near they are: what is pushed as a whole
//! moves as a whole, and a finer cloth moves alike. What falls to a held particle, its pin bears.

use bevy_math::Vec3;

use super::ClothSolver;
use super::error::SolverError;
use super::input::{FARTHEST, is_near};
use super::isa::{Isa, Kernel};
use super::lanes::{Block, Block3, LANES, Soa};
use super::lattice::Layout;
use super::parameters::ParameterError;

/// Acceleration that no push may give a particle \[m/s2\].
const MOST_ACCELERATION: f32 = 1e9;

/// The particles that are pushed.
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum PushOn {
    /// One particle.
    Particle(u32),
    /// What is within a ball.
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

/// What particles are pushed with.
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
    fn validate(&self, particles: usize) -> Result<(), SolverError> {
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
    fn part_at(&self, place: Vec3) -> f32 {
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
    fn vector(self) -> Vec3 {
        match self {
            Self::Force(vector) | Self::Impulse(vector) | Self::Velocity(vector) => vector,
        }
    }

    /// The same push with another vector.
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
pub(super) struct Pushes {
    /// Force on each particle \[N\]; zero where it has none.
    pub forces: Soa,
    /// Their magnitudes, added up as they came \[N\]; 0 where there are none.
    pub strength: f32,
}

impl Pushes {
    /// Adds the forces to accelerations.
    pub fn add(&self, isa: Isa, layout: Layout, inverse_mass: &[f32], a: &mut Soa) {
        self.add_part(1.0, isa, layout, inverse_mass, a);
    }

    fn add_part(&self, part: f32, isa: Isa, layout: Layout, inverse_mass: &[f32], to: &mut Soa) {
        if self.strength > 0.0 {
            isa.run(AddForces { layout, inverse_mass, part, forces: &self.forces, to });
        }
    }
}

impl ClothSolver {
    /// Checks a push without doing it.
    ///
    /// # Errors
    /// As [`ClothSolver::push`], but for what a push does to single particles.
    pub fn check_push(&self, on: PushOn, with: PushWith) -> Result<(), SolverError> {
        on.validate(self.topology.particle_count())?;
        if is_near(with.vector()) {
            return Ok(());
        }
        Err(SolverError::Push {
            what: match with {
                PushWith::Force(_) => "force",
                PushWith::Impulse(_) => "impulse",
                PushWith::Velocity(_) => "velocity",
            },
        })
    }

    /// Pushes particles: by a force that acts through the next tick, in all its substeps, and no longer; or
    /// by an impulse or a change of velocity, at once. Pushes add up. Held particles do not move. Returns
    /// how many particles it reached.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`], [`SolverError::Parameter`] for a radius or falloff out of its range,
    /// or [`SolverError::Push`] for a vector that is not finite or too large for the mass that it pushes;
    /// nothing is pushed then.
    pub fn push(&mut self, on: PushOn, with: PushWith) -> Result<usize, SolverError> {
        self.check_push(on, with)?;
        let particles = match on {
            PushOn::Particle(particle) => particle as usize..particle as usize + 1,
            PushOn::Within { .. } | PushOn::All => 0..self.topology.particle_count(),
        };
        let (mut reached, mut mass) = (0, 0.0_f64);
        for particle in particles.clone() {
            let part = on.part_at(self.position(particle));
            mass += f64::from(part) * f64::from(self.mass(particle));
            reached += usize::from(part > 0.0);
        }
        if reached == 0 || mass <= 0.0 {
            return Ok(0);
        }
        // What a particle that feels the whole push is accelerated by, or how its velocity changes.
        let whole = match with {
            PushWith::Velocity(velocity) => velocity,
            PushWith::Force(vector) | PushWith::Impulse(vector) => vector * (1.0 / mass) as f32,
        };
        match with {
            PushWith::Force(force) => {
                self.check_each(particles.clone(), "force", MOST_ACCELERATION, |_| whole)?;
                self.add_forces(particles, on, whole, force.dot(force).sqrt());
            }
            PushWith::Impulse(_) | PushWith::Velocity(_) => {
                let velocity = |particle| self.velocity(particle);
                self.check_each(particles.clone(), "velocity", FARTHEST, |i| velocity(i) + whole)?;
                self.add_velocities(particles, on, whole);
            }
        }
        Ok(reached)
    }

    /// Whether a vector of each free particle can be used.
    fn check_each(
        &self,
        mut particles: core::ops::Range<usize>,
        what: &'static str,
        most: f32,
        vector: impl Fn(usize) -> Vec3,
    ) -> Result<(), SolverError> {
        let good = particles.all(|particle| {
            let vector = vector(particle);
            vector.is_finite() && vector.abs().max_element() <= most
        });
        if good { Ok(()) } else { Err(SolverError::Push { what }) }
    }

    fn add_velocities(&mut self, particles: core::ops::Range<usize>, on: PushOn, whole: Vec3) {
        for particle in particles {
            let slot = self.topology.slot(particle);
            if self.held.inverse_mass[slot] > 0.0 {
                let part = on.part_at(self.position(particle));
                let d = self.state.d.get(slot) + whole * (part * self.state.unit);
                self.state.d.set(slot, d);
            }
        }
    }

    fn add_forces(
        &mut self,
        particles: core::ops::Range<usize>,
        on: PushOn,
        whole: Vec3,
        strength: f32,
    ) {
        let mut pushes = self.take_room_for_forces();
        for particle in particles {
            let slot = self.topology.slot(particle);
            let part = on.part_at(self.position(particle)) * self.mass(particle);
            pushes.forces.set(slot, pushes.forces.get(slot) + whole * part);
        }
        pushes.strength += strength;
        self.pushes = Some(pushes);
    }

    fn take_room_for_forces(&mut self) -> Box<Pushes> {
        self.pushes.take().unwrap_or_else(|| {
            let forces = Soa::zeros(self.topology.layout().len());
            Box::new(Pushes { forces, strength: 0.0 })
        })
    }

    /// Makes room for forces now, so that no push allocates.
    pub fn make_room_for_forces(&mut self) {
        self.pushes = Some(self.take_room_for_forces());
    }

    /// Whether forces push in this tick.
    pub(super) fn is_pushed(&self) -> bool {
        self.pushes.as_ref().is_some_and(|pushes| pushes.strength > 0.0)
    }

    /// What forces add to the load on the tethers, in the direction of gravity \[m/s2\]: to the next power
    /// of two, so that their bounds need not change with every one.
    pub(super) fn load_of_pushes(&self, gravity: Vec3) -> Vec3 {
        let Some(pushes) = self.pushes.as_ref().filter(|pushes| pushes.strength > 0.0) else {
            return Vec3::ZERO;
        };
        let mass = self.topology.total_area() * self.material.area_density;
        let load = f32::from_bits((pushes.strength / mass).to_bits() & 0x7f80_0000) * 2.0;
        gravity.normalize_or(Vec3::NEG_Y) * load.min(MOST_ACCELERATION)
    }

    /// Forces begin to act where a tick begins, which is half a substep after the middle that velocities
    /// are of: the next kick would reach back before it.
    pub(super) fn begin_pushes(&mut self) {
        self.kick_by_pushes(-0.5);
    }

    /// Forces act through one tick, to its end, which is half a substep after the last kick.
    pub(super) fn end_pushes(&mut self) {
        self.kick_by_pushes(0.5);
        if let Some(pushes) = self.pushes.as_mut().filter(|pushes| pushes.strength > 0.0) {
            pushes.forces.clear();
            pushes.strength = 0.0;
        }
    }

    /// Changes velocities by what the forces do in a part of the last substep. Integrators whose velocities
    /// are those of the instant have none.
    fn kick_by_pushes(&mut self, part: f32) {
        if let Some(pushes) = &self.pushes {
            let part = part * self.state.last_step * self.state.unit;
            let (layout, w) = (self.topology.layout(), &self.held.inverse_mass);
            pushes.add_part(part, self.isa, layout, w, &mut self.state.d);
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
