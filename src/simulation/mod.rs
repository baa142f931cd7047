//! The running cloth: its solver, its pins' motion, and what others may read of it.
//!
//! A cloth is one component, as its measurements and requests go across its parts: a velocity is the solver's
//! and the frame's, a push is checked by the solver and wakes. Each part has a file, and what works on it alone
//! takes nothing else.
//!
//! | part | what it is | worked on by |
//! | --- | --- | --- |
//! | `in_force` | shapes, material, settings, pins and weights that are in force | `shaping`, `setup`, `changes`, `resizing` |
//! | `start` | whether the cloth waits to be hung, and has been told of | `hanging`, `ready` |
//! | `skin` | where the skeleton of a worn cloth moves it | `anchors`, `wear` |
//! | `holding` | what holds and leads particles: `attachments`, `grabbed` | `pinning`, `anchors`, `grabbing` |
//! | `reference_frame` | teleports, resets, cloths that ride along | `anchors` |
//! | `pushing` | forces and impulses | |
//! | `culling` | whether the cloth is seen, where that is asked for | `culling` |
//! | `lod` | its level of detail | `lod` |
//! | `sleeping` | whether the cloth has anything to do, and takes a tick | |
//! | `tick_state` | the tick's input and its result | `step` |
//! | `progress` | the ticks so far | `step` |
//!
//! The files about what is held:
//!
//! | file | what it does |
//! | --- | --- |
//! | `attachments` | data: the anchors, which particle each holds, and where in its frame |
//! | `pinning` | system: makes attachments of new and changed `ClothPins` |
//! | `anchors` | system: moves anchors on by a tick, lets go where one is gone, carries or resets the cloth with them |
//! | `grabbed` | data: the particles that a `ClothGrab` holds, and its target's way |
//! | `grabbing` | system: begins, drags and ends grabs |
//! | `holding` | attachments and grab together, as the solver takes them: pins, springs, and the motion of each in a tick |
//!
//! `self_collision` and `inter_collision` hand on how the cloth collides with itself and with others. `snapshot` takes the full state out and puts it back. `complaints` tells the solver's errors to the components they are about. `stage_times` is a component of its own, on cloths that
//! are measured.

pub(crate) mod anchors;
pub(crate) mod attachments;
pub(crate) mod changes;
pub(crate) mod complaints;
pub(crate) mod culling;
pub(crate) mod grabbed;
pub(crate) mod grabbing;
pub(crate) mod hanging;
pub(crate) mod holding;
pub(crate) mod in_force;
pub(crate) mod inter_collision;
pub(crate) mod lod;
pub(crate) mod pinning;
pub(crate) mod progress;
pub(crate) mod pushing;
pub(crate) mod ready;
pub(crate) mod reference_frame;
pub(crate) mod resizing;
pub(crate) mod self_collision;
pub(crate) mod setup;
pub(crate) mod shaping;
pub(crate) mod skin;
pub(crate) mod sleeping;
pub(crate) mod snapshot;
pub(crate) mod stage_times;
pub(crate) mod start;
pub(crate) mod tick_state;

use std::sync::Arc;

use bevy::prelude::*;

use crate::cloth::pins::Choices;
use crate::hang::RelaxReport;
use crate::mesh::intake::ClothIntake;
use crate::simulation::culling::Culling;
use crate::simulation::holding::Holding;
use crate::simulation::in_force::InForce;
use crate::simulation::lod::Lod;
use crate::simulation::progress::Progress;
use crate::simulation::pushing::Pushing;
use crate::simulation::reference_frame::ReferenceFrame;
use crate::simulation::skin::Skin;
use crate::simulation::sleeping::SleepState;
use crate::simulation::start::Start;
use crate::simulation::tick_state::TickState;
use crate::solver::{
    ClothSolver, Isa, Lattice, Plan, SkinLimit, StrainReport, TickReport, Topology,
};

/// A cloth that is being simulated. The plugin adds it to every [`Cloth`](crate::Cloth) as soon as
/// that has all it needs.
///
/// Positions are in world space, at the end of the last tick, row by row. Removing the component
/// starts the cloth anew. It is neither cloned with the entity nor saved with a world: the copy starts as a new cloth
/// does, or with a [`ClothSnapshot`](crate::ClothSnapshot) as this one was.
///
/// An inspector sees the shape, material, settings and pins that are in force (`in_force`), the count of ticks,
/// and whether the cloth has diverged (`progress`).
#[derive(Component, Reflect)]
#[component(clone_behavior = Ignore)]
#[reflect(Component, from_reflect = false)]
pub struct ClothSimulation {
    #[reflect(ignore)]
    pub(crate) solver: ClothSolver,
    pub(crate) in_force: InForce,
    #[reflect(ignore)]
    pub(crate) start: Start,
    #[reflect(ignore)]
    pub(crate) held: Holding,
    #[reflect(ignore)]
    pub(crate) skin: Option<Box<Skin>>,
    #[reflect(ignore)]
    pub(crate) frame: ReferenceFrame,
    #[reflect(ignore)]
    pub(crate) pushing: Pushing,
    #[reflect(ignore)]
    pub(crate) culling: Culling,
    #[reflect(ignore)]
    pub(crate) lod: Lod,
    #[reflect(ignore)]
    pub(crate) sleep: SleepState,
    #[reflect(ignore)]
    pub(crate) tick: TickState,
    pub(crate) progress: Progress,
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
        self.progress.last_tick.as_ref()
    }

    /// Ticks simulated so far.
    pub fn tick_count(&self) -> u64 {
        self.progress.tick_count
    }

    /// Whether the cloth is held because it was no longer finite. See its `ClothFailure`.
    pub fn is_quarantined(&self) -> bool {
        self.progress.quarantined
    }

    /// Whether the cloth sleeps, see [`ClothSleepThreshold`](crate::ClothSleepThreshold).
    pub fn is_asleep(&self) -> bool {
        self.sleep.is_asleep()
    }

    /// Whether the cloth stands still because no view sees it, see [`ClothCulling`](crate::ClothCulling).
    pub fn is_culled(&self) -> bool {
        self.culling.culled
    }

    /// Whether the cloth stands still because it is being brought to rest where it hangs, in the
    /// background. See [`HangOnStart`](crate::HangOnStart).
    pub fn is_hanging(&self) -> bool {
        self.start.is_pending()
    }

    /// How it came to rest before it started; `None` where it was not hung, or is not at rest yet.
    pub fn hung(&self) -> Option<&RelaxReport> {
        self.start.hanging.as_ref()?.report()
    }

    /// Wakes the cloth, for what it cannot know of.
    pub fn wake(&mut self) {
        self.sleep.disturb();
    }

    /// Lets the next tick carry the cloth along to where its entity and anchors are then, without a
    /// velocity. See [`TeleportCloth`](crate::TeleportCloth).
    pub fn teleport(&mut self) {
        self.frame.teleport_asked = true;
    }

    /// Lets the next tick put the cloth back to its rest shape where its entity is then, at rest. See
    /// [`ResetCloth`](crate::ResetCloth).
    pub fn reset(&mut self) {
        self.frame.reset_asked = true;
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
        self.in_force.rest_shape.intake()
    }

    /// The particle of a vertex of the mesh, `None` where there is no such vertex, or where no
    /// triangle of the cloth uses it.
    pub fn particle_of_vertex(&self, vertex: u32) -> Option<u32> {
        self.in_force.rest_shape.particle_of(vertex)
    }

    /// Position of a particle in the world \[m\], `None` where there is no such particle.
    pub fn position(&self, particle: usize) -> Option<Vec3> {
        (particle < self.particle_count()).then(|| self.solver.position(particle))
    }

    /// Mass of a particle \[kg\], `None` where there is no such particle.
    pub fn mass(&self, particle: usize) -> Option<f32> {
        (particle < self.particle_count()).then(|| self.solver.mass(particle))
    }

    /// What holds particles near their places on the skin, one a particle; `None` for a cloth without
    /// [`ClothSkin`](crate::ClothSkin). Lengths are in metres of the world.
    pub fn skin_limits(&self) -> Option<&[SkinLimit]> {
        self.solver.skin()
    }

    /// Where the skeleton would put all particles in the world, at the end of the last tick \[m\]; `None` for a cloth without
    /// [`ClothSkin`](crate::ClothSkin).
    pub fn skin_places(&self) -> Option<&[Vec3]> {
        self.skin.as_ref().map(|skin| skin.places())
    }

    /// Rest positions of all particles \[m\], in the entity's frame times its scale.
    pub fn rest_positions(&self) -> &[Vec3] {
        self.topology().rest_positions()
    }

    /// Velocity of a particle in the world [m/s], zero while the cloth sleeps, `None` where there is no such particle.
    pub fn velocity(&self, particle: usize) -> Option<Vec3> {
        let place = self.position(particle)?;
        if self.is_asleep() {
            return Some(Vec3::ZERO);
        }
        Some(self.solver.velocity(particle) + self.velocity_of_ride(place))
    }

    /// How fast the cloth is taken along at a place, where it rides along [m/s].
    fn velocity_of_ride(&self, place: Vec3) -> Vec3 {
        match self.frame.ride {
            Some(ride) if self.tick.step.runs => {
                (place - ride.inverse().apply(place)) / self.tick.step.dt
            }
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

    /// Times that an edge of the cloth pierces a face of it: how much of it has passed through itself. Looks at all of it, which
    /// takes milliseconds: for reports, not for every tick.
    pub fn crossings(&self) -> u32 {
        self.solver.crossings()
    }

    /// Times that an edge of either cloth pierces a face of the other: how much of them has passed through each other. Looks at all of
    /// both, which takes milliseconds: for reports, not for every tick.
    pub fn crossings_with(&self, other: &Self) -> u32 {
        self.solver.crossings_with(&other.solver)
    }

    /// Chooses how the kernels are compiled. Every choice gives the same bits.
    pub fn set_isa(&mut self, isa: Isa) {
        self.solver.set_isa(isa);
    }

    /// Lets held particles start from where they are.
    pub(crate) fn take_hold_anew(&mut self) {
        self.held.attachments.take_hold_anew();
        if let Some(skin) = &mut self.skin {
            skin.state.fresh = true;
        }
    }

    /// The facts that particles are chosen by.
    pub(crate) fn choices(&self) -> Choices<'_> {
        Choices {
            grid: self.lattice().map(|lattice| (lattice.rows(), lattice.columns())),
            shape: &self.in_force.rest_shape,
            rest: self.rest_positions(),
            inverse_scale: 1.0 / self.in_force.placed.scale,
        }
    }
}
