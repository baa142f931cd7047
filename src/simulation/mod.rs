//! The running cloth: its solver, its pins' motion, and what others may read of it.
//!
//! | file | what it does |
//! | --- | --- |
//! | `setup`, `changes` | components become a running cloth; changed components change it |
//! | `attachments`, `pinning`, `anchors` | what is held, by what; anchors through a tick |
//! | `reference_frame` | teleports, resets, cloths that ride along |
//! | `grabbing`, `pushing` | particles that something leads; forces and impulses |
//! | `hanging` | cloths that are brought to rest where they hang, in the background |
//! | `sleeping` | which cloths take a tick |
//! | `snapshot` | the full state, taken out and put back |
//! | `tick_input`, `stage_times` | what a tick is given, and what its stages take |
//! | `ready` | tells that a cloth is there |

pub(crate) mod anchors;
pub(crate) mod attachments;
pub(crate) mod changes;
pub(crate) mod grabbing;
pub(crate) mod hanging;
pub(crate) mod pinning;
pub(crate) mod pushing;
pub(crate) mod ready;
pub(crate) mod reference_frame;
pub(crate) mod setup;
pub(crate) mod sleeping;
pub(crate) mod snapshot;
pub(crate) mod stage_times;
pub(crate) mod tick_input;

use std::sync::Arc;

use bevy::prelude::*;

use crate::cloth::ClothShape;
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::{Choices, ClothPins};
use crate::cloth::settings::ClothSettings;
use crate::cloth::weights::ClothWeights;
use crate::hang::RelaxReport;
use crate::mesh::intake::ClothIntake;
use crate::mesh::rest_shape::RestShape;
use crate::simulation::attachments::Attachments;
use crate::simulation::grabbing::Grabbed;
use crate::simulation::hanging::Hanging;
use crate::simulation::pushing::Pushing;
use crate::simulation::reference_frame::Following;
use crate::simulation::sleeping::Rest;
use crate::simulation::tick_input::ClothStep;
use crate::solver::{
    ClothSolver, Isa, Lattice, Plan, Pose, SolverError, StrainReport, TickReport, Topology,
};

/// A cloth that is being simulated. The plugin adds it to every [`Cloth`](crate::Cloth) as soon as
/// that has all it needs.
///
/// Positions are in world space, at the end of the last tick, row by row. Removing the component
/// starts the cloth anew.
///
/// An inspector sees the shape, material, settings and pins that are in force, the count of ticks, and whether it has diverged.
#[derive(Component, Reflect)]
#[reflect(Component, from_reflect = false)]
pub struct ClothSimulation {
    #[reflect(ignore)]
    pub(crate) solver: ClothSolver,
    #[reflect(ignore)]
    pub(crate) attachments: Attachments,
    #[reflect(ignore)]
    pub(crate) following: Following,
    #[reflect(ignore)]
    pub(crate) rest: Rest,
    /// Particles that are grabbed.
    #[reflect(ignore)]
    pub(crate) grab: Option<Box<Grabbed>>,
    #[reflect(ignore)]
    pub(crate) pushing: Pushing,
    /// Where it is to start hung from its pins.
    #[reflect(ignore)]
    pub(crate) hanging: Option<Box<Hanging>>,
    /// The shape that it was made from.
    pub(crate) shape: ClothShape,
    /// The material in force: the component may hold numbers that were refused.
    pub(crate) material: ClothMaterial,
    pub(crate) settings: ClothSettings,
    pub(crate) pins: ClothPins,
    /// The entity's pose at setup.
    #[reflect(ignore)]
    pub(crate) placed: Pose,
    /// Unscaled, in the entity's frame.
    #[reflect(ignore)]
    pub(crate) rest_shape: RestShape,
    /// The weights in force; `None` where the cloth is the same everywhere.
    #[reflect(ignore)]
    pub(crate) weights: Option<ClothWeights>,
    /// This tick's surroundings.
    #[reflect(ignore)]
    pub(crate) step: ClothStep,
    /// This tick's result, until it is looked at.
    #[reflect(ignore)]
    pub(crate) outcome: Option<Result<TickReport, SolverError>>,
    #[reflect(ignore)]
    pub(crate) last_tick: Option<TickReport>,
    pub(crate) tick_count: u64,
    /// `ClothReady` has been told.
    #[reflect(ignore)]
    pub(crate) told_ready: bool,
    /// The cloth diverged, and waits for other numbers.
    pub(crate) quarantined: bool,
    /// Counts what has moved the cloth, for those who show it.
    #[reflect(ignore)]
    pub(crate) shape_version: u64,
}

impl ClothSimulation {
    /// The solver's plan and its reason: springs or threads, and how many substeps.
    pub fn plan(&self) -> &Plan {
        self.solver.plan()
    }

    /// Measurements of the last tick; `None` before the first one.
    pub fn last_tick(&self) -> Option<&TickReport> {
        self.last_tick.as_ref()
    }

    /// Whether it took this tick, until that has been looked at.
    pub(crate) fn ran(&self) -> bool {
        matches!(self.outcome, Some(Ok(_)))
    }

    /// Ticks simulated so far.
    pub fn tick_count(&self) -> u64 {
        self.tick_count
    }

    /// Whether the cloth is held because it was no longer finite. See its `ClothFailure`.
    pub fn is_quarantined(&self) -> bool {
        self.quarantined
    }

    /// Whether the cloth sleeps, see [`ClothSleepThreshold`](crate::ClothSleepThreshold).
    pub fn is_asleep(&self) -> bool {
        self.rest.is_asleep()
    }

    /// Whether the cloth stands still because it is being brought to rest where it hangs, in the
    /// background. See [`HangOnStart`](crate::HangOnStart).
    pub fn is_hanging(&self) -> bool {
        self.hanging.as_ref().is_some_and(|hanging| hanging.is_pending())
    }

    /// How it came to rest before it started; `None` where it was not hung, or is not at rest yet.
    pub fn hung(&self) -> Option<&RelaxReport> {
        self.hanging.as_ref()?.report()
    }

    /// Wakes the cloth, for what it cannot know of.
    pub fn wake(&mut self) {
        self.rest.disturb();
    }

    /// Lets the next tick carry the cloth along to where its entity and anchors are then, without a
    /// velocity. See [`TeleportCloth`](crate::TeleportCloth).
    pub fn teleport(&mut self) {
        self.following.teleport_asked = true;
    }

    /// Lets the next tick put the cloth back to its rest shape where its entity is then, at rest. See
    /// [`ResetCloth`](crate::ResetCloth).
    pub fn reset(&mut self) {
        self.following.reset_asked = true;
    }

    /// The rest shape. Equal sheets share it.
    pub fn topology(&self) -> &Topology {
        self.solver.topology()
    }

    /// The rest shape, where it is a lattice.
    pub fn lattice(&self) -> Option<&Arc<Lattice>> {
        self.solver.lattice()
    }

    /// Rows of particles; one where they are not in rows.
    pub fn rows(&self) -> usize {
        self.solver.lattice().map_or(1, |lattice| lattice.rows())
    }

    /// Columns of particles; all of them where they are not in rows.
    pub fn columns(&self) -> usize {
        self.solver.lattice().map_or(self.particle_count(), |lattice| lattice.columns())
    }

    /// Number of particles.
    pub fn particle_count(&self) -> usize {
        self.solver.topology().particle_count()
    }

    /// Number of structural and shear springs.
    pub fn spring_count(&self) -> usize {
        self.solver.topology().spring_count()
    }

    /// The account of how the mesh was made this cloth; `None` for a sheet.
    pub fn intake(&self) -> Option<&ClothIntake> {
        self.rest_shape.intake()
    }

    /// The particle of a vertex of the mesh, `None` where there is no such vertex, or where no
    /// triangle of the cloth uses it.
    pub fn particle_of_vertex(&self, vertex: u32) -> Option<u32> {
        self.rest_shape.particle_of(vertex)
    }

    /// Position of a particle in the world \[m\], `None` where there is no such particle.
    pub fn position(&self, particle: usize) -> Option<Vec3> {
        (particle < self.particle_count()).then(|| self.solver.position(particle))
    }

    /// Mass of a particle \[kg\], `None` where there is no such particle.
    pub fn mass(&self, particle: usize) -> Option<f32> {
        (particle < self.particle_count()).then(|| self.solver.mass(particle))
    }

    /// Rest positions of all particles \[m\], in the entity's frame times its scale at setup.
    pub fn rest_positions(&self) -> &[Vec3] {
        self.topology().rest_positions()
    }

    /// Velocity of a particle in the world [m/s], `None` where there is no such particle.
    pub fn velocity(&self, particle: usize) -> Option<Vec3> {
        let place = self.position(particle)?;
        Some(self.solver.velocity(particle) + self.velocity_of_ride(place))
    }

    /// How fast the cloth is taken along at a place, where it rides along [m/s].
    fn velocity_of_ride(&self, place: Vec3) -> Vec3 {
        match self.following.ride {
            Some(ride) if self.step.runs => (place - ride.inverse().apply(place)) / self.step.dt,
            _ => Vec3::ZERO,
        }
    }

    /// Positions of all particles in the world \[m\].
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Vec3> + '_ {
        (0..self.particle_count()).map(|particle| self.solver.position(particle))
    }

    /// The particles that are held, in ascending order.
    pub fn pinned(&self) -> &[u32] {
        self.solver.pins()
    }

    /// Gives every free particle a velocity in the world [m/s], a function of its position there \[m\].
    pub fn set_velocities(&mut self, velocity: impl Fn(Vec3) -> Vec3) {
        self.wake();
        for particle in 0..self.particle_count() {
            let place = self.solver.position(particle);
            let velocity = velocity(place) - self.velocity_of_ride(place);
            if self.pinned().binary_search(&(particle as u32)).is_err() {
                // What is not finite is refused, and the particle keeps its own.
                let _ = self.solver.set_velocity(particle, velocity);
            }
        }
    }

    /// Strain of the threads. Looks at all of them and sorts: for reports, not for every tick.
    pub fn strain(&self) -> StrainReport {
        self.solver.strain()
    }

    /// Chooses how the kernels are compiled. Every choice gives the same bits.
    pub fn set_isa(&mut self, isa: Isa) {
        self.solver.set_isa(isa);
    }

    /// The facts that particles are chosen by.
    pub(crate) fn choices(&self) -> Choices<'_> {
        Choices {
            grid: self.lattice().map(|lattice| (lattice.rows(), lattice.columns())),
            shape: &self.rest_shape,
            rest: self.rest_positions(),
            inverse_scale: 1.0 / self.placed.scale,
        }
    }
}
