//! Loads from outside: forces through the next tick, impulses, changes of velocity.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::error::SolverError;
use crate::solver::forces::external::{MOST_ACCELERATION, PushOn, PushWith, Pushes};
use crate::solver::settings::{FARTHEST, is_near};
use crate::solver::simd::soa::Soa;

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
            PushWith::Force(vector) => vector * (1.0 / mass) as f32,
            PushWith::Impulse(vector) => {
                vector * (1.0 / (mass * f64::from(self.pins.mass_scale))) as f32
            }
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
    pub(crate) fn check_each(
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

    pub(crate) fn add_velocities(
        &mut self,
        particles: core::ops::Range<usize>,
        on: PushOn,
        whole: Vec3,
    ) {
        for particle in particles {
            let slot = self.topology.slot(particle);
            if self.pins.inverse_mass[slot] > 0.0 {
                let part = on.part_at(self.position(particle));
                let d = self.state.d.get(slot) + whole * (part * self.state.unit);
                self.state.d.set(slot, d);
            }
        }
    }

    pub(crate) fn add_forces(
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

    pub(crate) fn take_room_for_forces(&mut self) -> Box<Pushes> {
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
    pub(crate) fn is_pushed(&self) -> bool {
        self.pushes.as_ref().is_some_and(|pushes| pushes.strength > 0.0)
    }

    /// Load that forces add to the tethers, in the direction of gravity \[m/s2\]: rounded up to a power of two, so
    /// that the tethers' bounds do not change with every force.
    pub(crate) fn load_of_pushes(&self, gravity: Vec3) -> Vec3 {
        let Some(pushes) = self.pushes.as_ref().filter(|pushes| pushes.strength > 0.0) else {
            return Vec3::ZERO;
        };
        let mass = self.topology.total_area() * self.material.area_density;
        let load = f32::from_bits((pushes.strength / mass).to_bits() & 0x7f80_0000) * 2.0;
        gravity.normalize_or(Vec3::NEG_Y) * load.min(MOST_ACCELERATION)
    }

    /// Forces begin to act where a tick begins, which is half a substep after the middle that velocities
    /// are of: the next kick would reach back before it.
    pub(crate) fn begin_pushes(&mut self) {
        self.kick_by_pushes(-0.5);
    }

    /// Forces act through one tick, to its end, which is half a substep after the last kick.
    pub(crate) fn end_pushes(&mut self) {
        self.kick_by_pushes(0.5);
        if let Some(pushes) = self.pushes.as_mut().filter(|pushes| pushes.strength > 0.0) {
            pushes.forces.clear();
            pushes.strength = 0.0;
        }
    }

    /// Changes velocities by what the forces do in a part of the last substep. Integrators whose velocities
    /// are those of the instant have none.
    pub(crate) fn kick_by_pushes(&mut self, part: f32) {
        if let Some(pushes) = &self.pushes {
            let part = part * self.state.last_step * self.state.unit;
            let (layout, w) = (self.topology.layout(), &self.pins.inverse_mass);
            pushes.add_part(part, self.isa, layout, w, &mut self.state.d);
        }
    }
}
