//! Reading and writing the particles of a solver.

use std::sync::Arc;

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::cloth_contact::{crossing_edges, edges_through};
use crate::solver::error::SolverError;
use crate::solver::plan::Plan;
use crate::solver::settings::{Material, Settings, is_near};
use crate::solver::state::measure::{StrainReport, strains};
use crate::solver::topology::Topology;
use crate::solver::topology::lattice::Lattice;

impl ClothSolver {
    /// The rest shape.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The rest shape, where it is a lattice.
    pub fn lattice(&self) -> Option<&Arc<Lattice>> {
        self.topology.as_lattice()
    }

    /// The material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The plan that follows from material, settings and the tick's length.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Plans ticks of another length \[s\] than the last.
    ///
    /// # Errors
    /// [`SolverError::Tick`].
    pub fn plan_for(&mut self, tick: f32) -> Result<&Plan, SolverError> {
        if !(tick > 0.0 && tick <= 1.0) {
            return Err(SolverError::Tick(tick));
        }
        self.plan_ticks(tick);
        Ok(&self.plan)
    }

    /// Where the cloth's own coordinates begin, in world space \[m\].
    pub fn origin(&self) -> Vec3 {
        self.state.origin
    }

    /// A particle's position in world space \[m\], at the last tick's end.
    ///
    /// # Panics
    /// Where there is no such particle; so do the other readers of one particle.
    pub fn position(&self, particle: usize) -> Vec3 {
        self.state.origin + self.local_position(particle)
    }

    /// The same, relative to [`ClothSolver::origin`].
    pub fn local_position(&self, particle: usize) -> Vec3 {
        self.state.x.get(self.slot(particle))
    }

    /// The same, at the last tick's start.
    pub fn local_start_position(&self, particle: usize) -> Vec3 {
        self.state.start.get(self.slot(particle))
    }

    /// A particle's velocity \[m/s\], at the middle of the last substep.
    pub fn velocity(&self, particle: usize) -> Vec3 {
        self.state.d.get(self.slot(particle)) / self.state.unit
    }

    /// A particle's mass \[kg\].
    pub fn mass(&self, particle: usize) -> f32 {
        self.topology.area(self.slot(particle)) * self.material.area_density
    }

    /// Puts a particle elsewhere, in world space \[m\]. Where all are put, a cloth is reset.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`] or [`SolverError::NonFinite`].
    pub fn set_position(&mut self, particle: usize, position: Vec3) -> Result<(), SolverError> {
        self.check_particle(particle, "position", position)?;
        let slot = self.slot(particle);
        self.state.x.set(slot, position - self.state.origin);
        self.state.contacts.forget(slot);
        self.state.contacts.edges.forget(slot);
        self.forget_pairs();
        self.surveyed_before = true;
        self.stop_filtering();
        Ok(())
    }

    /// Gives a particle a velocity \[m/s\]. Before the first tick it is the one at that instant.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`] or [`SolverError::NonFinite`].
    pub fn set_velocity(&mut self, particle: usize, velocity: Vec3) -> Result<(), SolverError> {
        self.check_particle(particle, "velocity", velocity)?;
        let slot = self.slot(particle);
        self.state.d.set(slot, velocity * self.state.unit);
        self.stop_filtering();
        Ok(())
    }

    /// Whether any particle moved in the last tick, or was put elsewhere since.
    pub fn has_moved(&self) -> bool {
        self.largest_move() > 0.0
    }

    /// How far any particle moved along any axis in the last tick, at most \[m\].
    pub fn largest_move(&self) -> f32 {
        self.survey().moved
    }

    /// Corners of the box around all particles at present, in world space \[m\].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let survey = self.survey();
        (self.state.origin + survey.min, self.state.origin + survey.max)
    }

    /// Strains of the structural springs. Sorts them: for reports, not for every frame.
    pub fn strain(&self) -> StrainReport {
        StrainReport::new(&self.topology, &self.state.x)
    }

    /// Edges that pierce faces of the cloth, each with each. Looks at all of them: for reports, not for every frame.
    pub fn crossings(&self) -> u32 {
        self.crossing_edges().len() as u32
    }

    /// The particles of these edges. An edge is there once for each face that it pierces.
    pub fn crossing_edges(&self) -> Vec<[u32; 2]> {
        crossing_edges(&self.topology, &self.state.x)
    }

    /// Edges of either cloth that pierce faces of the other, each with each. Looks at all of both: for reports, not for every frame.
    pub fn crossings_with(&self, other: &Self) -> u32 {
        let [one, two] = [self, other].map(|it| (&it.topology, &it.state.x));
        let shift = other.state.origin - self.state.origin;
        (edges_through(one, two, shift).len() + edges_through(two, one, -shift).len()) as u32
    }

    /// Sum of their strains, and how many there are, without sorting anything.
    pub fn strain_sum(&self) -> (f64, usize) {
        let add = |(sum, count), strain| (sum + f64::from(strain), count + 1);
        strains(&self.topology, &self.state.x).fold((0.0, 0), add)
    }

    fn slot(&self, particle: usize) -> usize {
        assert!(particle < self.topology.particle_count(), "no particle {particle}");
        self.topology.slot(particle)
    }

    fn check_particle(
        &self,
        particle: usize,
        what: &'static str,
        value: Vec3,
    ) -> Result<(), SolverError> {
        let count = self.topology.particle_count();
        if particle >= count {
            return Err(SolverError::NoSuchParticle { particle, count });
        }
        if !is_near(value) {
            return Err(SolverError::NonFinite { what, particle });
        }
        Ok(())
    }
}
