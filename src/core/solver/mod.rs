//! The solver of one cloth: pure numerics over structure-of-arrays state. No ECS, no assets, no clock.
//!
//! A tick of length `dt` is made of `n` substeps of length `h = dt / n`, and each substep of four
//! stages, one function each (`stages`):
//!
//! 1. [`accumulate_forces`](ClothSolver::accumulate_forces): explicit springs, bending, damping, gravity,
//!    loads from outside and air give accelerations (`forces`);
//! 2. [`integrate`](ClothSolver::integrate): Verlet in its leapfrog form, linear drag; pins move to where
//!    they are to be (`integrate`);
//! 3. [`correct`](ClothSolver::correct): *threads* are solved whole, or *springs* are held to Provot's
//!    strain limit; then tethers to the pins, and bounds around an animated pose (`constraints`). A particle that lies on a collider is moved along its
//!    surface alone;
//! 4. [`collide`](ClothSolver::collide): particles and edges are held outside the colliders (`contact`).
//!
//! Between the second stage and the end of the fourth a particle is at `x + d`: `x` is its position when the
//! substep began, and `d` its displacement since. The displacement is the velocity times `h`, so that a
//! correction changes position and velocity by what was computed, never by a difference of rounded positions.
//!
//! # Rooms
//!
//! Each folder knows only the ones above it in this table. A test keeps it so (`tests/architecture.rs`).
//!
//! | room | what it holds |
//! | --- | --- |
//! | `settings` | material, settings, and the range of coordinates |
//! | `simd` | blocks of 16 particles, storage, memory layout; one body a kernel, compiled for several instruction sets; bands of rows that threads share |
//! | `topology` | the rest shape, immutable and shared by equal cloths: lattice or graph, geodesic distances, wide hinges |
//! | `error` | why a solver refuses |
//! | `contact` | colliders; broad phase, response of particles, swept contact, friction, active set; edges and faces |
//! | `cloth_contact` | contact of cloth with cloth: balls of particles, pairs that may touch, what moves them apart; crossings |
//! | `forces` | springs, bending, friction of bending, damping, external loads, aerodynamics, wind |
//! | `plan` | stability bounds; substeps, springs or threads, clamped constants |
//! | `integrate` | Verlet, Houbolt's filter of corrections; explicit integrators to compare with |
//! | `constraints` | pins, soft pins, threads, shear, strain limit, tethers, skin |
//! | `input` | what a tick is given and gives back |
//! | `state` | positions, displacements, workspace, measures |
//! | `model` | what stages do differently on a sheet and on a mesh, with the constants and the workspace of each |
//! | `stages` and the files beside this one | [`ClothSolver`]: what it does in each stage; setting it up, reading, moving and saving it |
//!
//! # A new force
//!
//! It has a file of its own in `forces`, with a `Kernel` that adds to the accelerations. `external` is the shortest to
//! start from (a vector each particle), `aerodynamics` one with a state, a law and settings. The compiler asks for what it
//! remembers (`snapshot`), and does not tell the rest:
//!
//! - `accelerate` calls it: in `stages/forces` where it is the same for both models, as `add_air` is; else in `model/sheet` and
//!   `model/mesh`, which find it in `model`'s `Acting`;
//! - `has_forces` knows of it: where gravity acts alone, the first stage is left out;
//! - `begin_tick` counts it in the load that tethers are bounded for, if it may be as strong as gravity;
//! - a force that is stiff has its part in `plan`'s bound on the substep; one that depends on the velocity has it there too, or
//!   limits its own impulse, as air does in `forces/aerodynamics/law`;
//! - `setup` hands it on to a solver that is made anew (`remade`), and `hang` leaves it out or not while a cloth is hung.
//!
//! # A new constraint
//!
//! It has a file of its own in `constraints`. `graph_strain_limit` is the shortest to start from,
//! `tethers` one that belongs to the pins:
//!
//! - `stages/correct` calls it; what comes last there is held best. Where sheets and meshes differ it is a method of `model`'s trait
//!   `Stages`, and `model/sheet` and `model/mesh` each have it;
//! - a mesh's constraints work between `begin_corrections` and `end_corrections`, on its places, in batches that share no
//!   particle (`topology/graph/coloring`);
//! - it changes displacements by a multiplier times inverse masses: momentum is kept, and position and velocity agree. A particle
//!   on a collider has the mobility `w (1 - n n^T)`, and what that takes away is its load (`contact/active_set`);
//! - what one pass of it leaves under a load that lasts can be made up for over ticks (`constraints/threads/shifts`);
//! - what it does is carried on as a pull (`integrate/houbolt`), unless it mends, as the strain limit does: then it works between
//!   `pause_pulls` and `go_on_pulling`;
//! - what it derives from pins, material or settings is made again in `setup` (`set_pins`, `replan`).

mod cloth_contact;
mod constraints;
mod contact;
mod error;
mod forces;
mod given;
mod input;
mod integrate;
mod island;
mod model;
mod particles;
mod placing;
mod plan;
mod rest_detection;
mod rigid_motion;
mod settings;
mod setup;
mod simd;
mod snapshot;
mod stages;
mod state;
mod topology;

use bevy_math::Vec3;

pub use crate::solver::cloth_contact::{InterCollision, SelfCollision};
pub use crate::solver::constraints::pin_motion::PinMotion;
pub use crate::solver::constraints::skin::{Backstop, SkinLimit, SkinMotion};
pub use crate::solver::constraints::soft_pins::SoftPin;
pub use crate::solver::contact::{Collider, ColliderMotion, Impulse, Mobility, Pose};
pub use crate::solver::error::SolverError;
pub use crate::solver::forces::aerodynamics::Air;
pub use crate::solver::forces::external::{PushOn, PushWith};
pub use crate::solver::forces::wind::{Gusts, Wind, WindFlow, WindShape, Zone};
pub use crate::solver::input::{PinPull, StepInput, TickReport};
pub use crate::solver::island::{Island, Member};
pub use crate::solver::plan::{Clamped, Plan, PlanReason};
pub use crate::solver::rigid_motion::RigidMotion;
pub use crate::solver::settings::{
    Bending, DampingForm, Integrator, MassLumping, Material, ParameterError, Settings,
    StretchMethod, Stretching, Substeps,
};
pub use crate::solver::simd::isa::Isa;
pub use crate::solver::simd::lanes::LANES;
pub use crate::solver::snapshot::{SolverState, StateError};
pub use crate::solver::state::measure::StrainReport;
pub use crate::solver::topology::Topology;
pub use crate::solver::topology::graph::{Graph, GraphError, Weights};
pub use crate::solver::topology::lattice::{Lattice, LatticeError};

use crate::solver::cloth_contact::{OthersContact, SelfContact};
use crate::solver::constraints::pins::Pins;
use crate::solver::constraints::skin::Skin;
use crate::solver::contact::Span;
use crate::solver::forces::aerodynamics::Surface;
use crate::solver::model::Model;
use crate::solver::plan::stability::Bound;
use crate::solver::settings::is_near;
use crate::solver::simd::parallel::{self, Bands};
use crate::solver::state::measure::Survey;
use crate::solver::state::{State, Workspace};

/// The solver of one cloth: its rest shape, what it is made of, and what moves.
#[derive(Clone, Debug)]
pub struct ClothSolver {
    topology: Topology,
    model: Model,
    material: Material,
    settings: Settings,
    isa: Isa,
    bands: Bands,
    /// Whether threads share a large cloth.
    shares: bool,
    pins: Pins,
    soft: Vec<constraints::soft_pins::Spring>,
    /// Pins that pull at bodies in this tick.
    pulling: Vec<stages::pulling::Pulling>,
    /// What holds it near an animated pose, where anything does.
    skin: Option<Box<Skin>>,
    /// Forces from outside, once there were any.
    pushes: Option<Box<forces::external::Pushes>>,
    bound: Bound,
    plan: Plan,
    /// The air around it, where it feels any.
    air: Option<Surface>,
    /// Load that the tethers' bounds were made for \[m/s2\].
    tethered_under: Option<Vec3>,
    /// Largest correction by one spring at which a taut thread does not tremble \[m\].
    steady: f32,
    /// Factor of the tethers' bounds in this tick; above 1 where its pins are too far apart.
    tether_ease: f32,
    /// Rate at which it is stopped in this tick beside its drag \[1/s\].
    braking: f32,
    /// Edges that are held out of colliders.
    edges: contact::Edges,
    /// Contact with itself, where it collides with itself.
    self_contact: Option<Box<SelfContact>>,
    state: State,
    workspace: Workspace,
    /// Substeps of this tick that are done.
    done: u32,
    contact_count: u32,
    /// Pairs of particles that touched in this substep.
    touching_itself: u32,
    /// Contact with other cloths, where it collides with others.
    others_contact: Option<Box<OthersContact>>,
    /// Pairs of its particles and others' that touched in the last substep.
    touching_others: u32,
    /// Substeps of its tick at least, as it is stepped together with others; 0 where it is not.
    lockstep: u32,
    /// How far its coordinates are moved in the tick that it is stepped in together with others \[m\].
    drift: Vec3,
    survey: Survey,
    /// Particles were put elsewhere since the survey was taken.
    surveyed_before: bool,
    mark: rest_detection::Mark,
}

/// A stage of a tick: its beginning, and the four stages of each substep, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// [`ClothSolver::begin_tick`].
    Begin,
    /// [`ClothSolver::accumulate_forces`].
    Forces,
    /// [`ClothSolver::integrate`].
    Integrate,
    /// [`ClothSolver::correct`].
    Correct,
    /// [`ClothSolver::collide`].
    Collide,
}

impl ClothSolver {
    /// Takes one tick, all substeps.
    ///
    /// # Errors
    /// [`SolverError`] for input that cannot be used, and nothing is done; or
    /// [`SolverError::Diverged`].
    pub fn tick(&mut self, input: &StepInput<'_>) -> Result<TickReport, SolverError> {
        self.tick_observed(input, |_| ())
    }

    /// Takes one tick as [`ClothSolver::tick`] does, and calls `ended` at the end of each stage. The solver has no clock: a
    /// caller that has one takes the times of the stages so, with the same bits and the same threads as without.
    ///
    /// # Errors
    /// As [`ClothSolver::tick`].
    pub fn tick_observed(
        &mut self,
        input: &StepInput<'_>,
        ended: impl FnMut(Stage) + Send,
    ) -> Result<TickReport, SolverError> {
        if self.is_to_share() {
            return parallel::inside(|| self.take_tick(input, ended));
        }
        self.take_tick(input, ended)
    }

    fn take_tick(
        &mut self,
        input: &StepInput<'_>,
        mut ended: impl FnMut(Stage),
    ) -> Result<TickReport, SolverError> {
        let substeps = self.begin_tick(input)?;
        ended(Stage::Begin);
        for _ in 0..substeps {
            self.accumulate_forces(input);
            ended(Stage::Forces);
            self.integrate(input);
            ended(Stage::Integrate);
            self.correct();
            ended(Stage::Correct);
            self.collide(input);
            ended(Stage::Collide);
        }
        self.end_tick()
    }

    /// Begins a tick and says how many substeps it has. Each is the four stages in their order, with
    /// the same input.
    ///
    /// # Errors
    /// As [`ClothSolver::tick`]; the tick has not begun then.
    pub fn begin_tick(&mut self, input: &StepInput<'_>) -> Result<u32, SolverError> {
        self.check_input(input)?;
        self.lockstep = 0;
        self.plan_tick(input, false);
        Ok(self.begin_planned_tick(input))
    }

    fn check_input(&self, input: &StepInput<'_>) -> Result<(), SolverError> {
        let pins = self.pins.slots.len() + self.soft.len();
        input.check(pins)?;
        input.check_pulls(pins)?;
        input.check_skin(self.isa, self.skin.as_deref())?;
        if self.air.is_some() {
            input.wind.validate()?;
        }
        Ok(())
    }

    /// Plans a tick, alone or in the company of cloths that it may touch. Tells how many substeps it takes where it is alone.
    fn plan_tick(&mut self, input: &StepInput<'_>, is_in_company: bool) -> u32 {
        if let Some(own) = &mut self.self_contact {
            own.begin_tick();
        }
        if let Some(others) = &mut self.others_contact {
            others.begin_tick(is_in_company);
        }
        self.touching_others = 0;
        self.look_out(input);
        if input.dt != self.plan.tick || self.planned_cloth() != self.plan.cloth {
            self.plan_ticks(input.dt);
        }
        self.plan.alone
    }

    /// Begins a tick that has been planned, with input that has been checked.
    fn begin_planned_tick(&mut self, input: &StepInput<'_>) -> u32 {
        self.share_out();
        if self.surveyed_before {
            self.survey_anew();
        }
        let (low, high) = self.bounds();
        let centre = (self.survey.min + self.survey.max) * 0.5;
        if self.state.follow(self.topology.layout(), centre) {
            self.ride_pairs(None);
        }
        if let Some(skin) = &mut self.skin {
            skin.begin_tick(self.isa, &self.topology, input.skin, self.state.origin);
        }
        let wind = self.take_wind(input, (low, high));
        let load = input.gravity + wind + self.load_of_pushes(input.gravity);
        if !self.tethered_under.is_some_and(|known| is_as_strong(known, load)) {
            self.tether_under(Some(load));
        }
        self.begin_pushes();
        let eases = self.pins.tethers.iter().map(|set| set.ease(input.pins));
        self.tether_ease = eases.fold(1.0, f32::max);
        self.braking = input.braking;
        self.begin_filtering();
        self.state.start.copy_from(&self.state.x);
        let (epsilon, layers) = (self.material.thickness, self.settings.layers);
        self.workspace.broad_phase.begin_tick(low, high, epsilon, layers, input.colliders);
        let particle = self.topology.total_area() * self.material.area_density
            / self.topology.particle_count() as f32;
        self.state.contacts.begin_tick(input.colliders, self.state.origin, particle, input.dt);
        self.begin_carrying(input);
        self.begin_pulling(input);
        self.workspace.looked = None;
        self.done = 0;
        self.plan.substeps
    }

    /// Ends the tick.
    ///
    /// # Errors
    /// [`SolverError::Diverged`] where anything is not finite.
    pub fn end_tick(&mut self) -> Result<TickReport, SolverError> {
        self.end_pushes();
        let survey = self.take_survey();
        let origin = self.state.origin;
        if !survey.finite || !is_near(origin + survey.max) || !is_near(origin + survey.min) {
            self.state.x.copy_from(&self.state.start);
            self.come_to_rest();
            self.state.contacts.impulses.clear();
            return Err(SolverError::Diverged);
        }
        self.survey = survey;
        self.shift_springs();
        self.state.striking.has_met = self.state.contacts.impulses.meet_bodies();
        self.state.contacts.impulses.end_tick();
        Ok(TickReport {
            substeps: self.plan.substeps,
            max_strain: survey.max_strain,
            contact_count: self.contact_count,
            self_contact_count: self.touching_itself,
            inter_contact_count: self.touching_others,
        })
    }

    fn take_survey(&self) -> Survey {
        self.model.stages().survey(self.isa, &self.bands, &self.state)
    }

    fn survey_anew(&mut self) {
        self.survey = self.take_survey();
        self.surveyed_before = false;
    }

    /// The survey of where the particles are now.
    fn survey(&self) -> Survey {
        if self.surveyed_before { self.take_survey() } else { self.survey }
    }

    /// The part of the tick that the present substep covers.
    fn span(&self) -> Span {
        let n = self.plan.substeps as f32;
        Span { from: self.done as f32 / n, to: (self.done + 1) as f32 / n }
    }
}

/// Whether two gravities pull alike, in whatever direction, but for rounding: as they do in the frame of
/// a cloth that turns.
fn is_as_strong(a: Vec3, b: Vec3) -> bool {
    a == b || (a.length_squared() - b.length_squared()).abs() <= 1e-4 * a.length_squared()
}
