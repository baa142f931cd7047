//! The solver of one cloth: pure numerics over structure-of-arrays state. No ECS, no assets, no clock.
//!
//! A tick of length `dt` is made of `n` substeps of length `h = dt / n`, and each substep of four
//! stages, one function each:
//!
//! 1. [`accumulate_forces`](ClothSolver::accumulate_forces): explicit springs, bending, damping, gravity,
//!    air give accelerations (`forces`, `rows`, `bending`, `damping`, `air`);
//! 2. [`integrate`](ClothSolver::integrate): Verlet in its leapfrog form, linear drag; pins move to where
//!    they are to be (`integrate`);
//! 3. [`correct`](ClothSolver::correct): *threads* are solved whole, or *springs* are held to Provot's
//!    limit, what lies on a collider going along its surface alone; tethers to the pins (`threads`, `weft`, `warp`,
//!    `constraint`, `contact`, `tethers`);
//! 4. [`collide`](ClothSolver::collide): particles are held epsilon outside the colliders (`contact`).
//!
//! Between the second stage and the end of the fourth a particle is at `x + d`: where it was when the
//! substep began, and its displacement since. The displacement is the velocity (times `h`), so that a
//! correction changes both by what was computed, never by a difference of rounded positions. What is
//! where:
//!
//! | file | what it holds |
//! | --- | --- |
//! | `topology` | the rest shape: immutable, shared by equal cloths |
//! | `lattice` | that of a rectangular sheet |
//! | `graph` | that of any triangle mesh, and the stages as they are on one |
//! | `ways` | ways along the cloth at rest, for tethers |
//! | `beyond` | whether any spring is beyond the strain limit |
//! | `carry`, `shear` | corrections carried on to the next substep; shear springs of a lattice of threads |
//! | `taut` | threads under more tension than a substep allows for |
//! | `state` | positions, displacements, working room |
//! | `held`, `soft` | what depends on the pins: inverse masses, tethers, clamped hinges; pins on springs |
//! | `motion` | moving a whole cloth rigidly, and putting it back to rest |
//! | `plan` | the stability bound; substeps, springs or threads, clamped constants |
//! | `parameters` | material and settings |
//! | `air`, `wind` | drag and lift; uniform wind, gusts, zones |
//! | `save` | the state between ticks, taken out and put back |
//! | `push` | forces, impulses and changes of velocity from outside |
//! | `setup`, `input`, `access` | making a solver, what a tick is given, reading and writing particles |
//! | `rows`, `damping` | springs of a lattice, each worked out once; their damping |
//! | `bending_friction` | friction between the yarns, which brings a cloth to rest |
//! | `measure`, `stillness` | strain, bounds, whether all is finite; how far the cloth has gone |
//! | `lanes`, `transpose`, `isa` | blocks of 16 particles; one body a kernel, compiled for several instruction sets |
//! | `bands` | large sheets cut into bands of rows, which threads share |
//! | `study` | integrators to compare with |
//!
//! # A new force
//!
//! It has a file of its own, with a `Kernel` that adds to the accelerations `scratch.a`. `push` is the shortest to
//! start from (a vector each particle), `air` one with a state, a law and settings. No compiler tells the rest:
//!
//! - `accelerate` calls it for sheets, `accumulate_graph_forces` for meshes;
//! - `has_forces` knows of it: where gravity acts alone, the first stage is left out;
//! - `begin_tick` counts it in the load that tethers are bounded for, if it may be as strong as gravity;
//! - what is stiff or depends on the velocity has its part in `plan`'s bound on the substep;
//! - what it remembers between ticks is in `save`.

mod access;
mod air;
mod bands;
mod bending;
mod bending_friction;
mod beyond;
mod carry;
mod constraint;
mod contact;
mod damping;
mod error;
mod forces;
mod graph;
mod held;
mod input;
mod integrate;
mod isa;
mod lanes;
mod lattice;
mod measure;
mod motion;
mod parameters;
mod plan;
mod push;
mod rows;
mod save;
mod setup;
mod shear;
mod soft;
mod state;
mod stillness;
mod study;
mod taut;
mod tethers;
mod threads;
mod topology;
mod transpose;
mod warp;
mod ways;
mod weft;
mod weights;
mod wind;

use bevy_math::Vec3;

pub use air::Air;
pub use contact::{Collider, ColliderMotion, Pose};
pub use error::SolverError;
pub use graph::{Graph, GraphError, Weights};
pub use input::{PinMotion, StepInput, TickReport};
pub use isa::Isa;
pub use lanes::LANES;
pub use lattice::{Lattice, LatticeError, MassLumping};
pub use measure::StrainReport;
pub use motion::RigidMotion;
pub use parameters::{
    Bending, DampingForm, FormChoice, Integrator, Material, ParameterError, Settings, Substeps,
};
pub use plan::{Clamped, Form, Plan, PlanReason};
pub use push::{PushOn, PushWith};
pub use save::{SolverState, StateError};
pub use soft::SoftPin;
pub use topology::Topology;
pub use wind::{Gusts, Wind, WindFlow, WindShape, Zone};

use air::{Push, Surface};
use bands::Bands;
use bending::Bend;
use beyond::IsAnyBeyond;
use carry::Carry;
use constraint::{CorrectSprings, Rule};
use contact::{ActiveSet, HoldOnto, ResolveContacts, Skin, Span};
use damping::{AddDamping, DampedSprings, DampingTarget};
use forces::AccumulateForces;
use held::Held;
use input::is_near;
use integrate::{Acceleration, Advance, Displace, Integrate, Kick};
use lanes::ValuesMut;
use measure::{Survey, TakeSurvey};
use plan::Bound;
use shear::{Cells, CorrectShear, ShearRule};
use state::{Scratch, State};
use tethers::PullTethers;
use threads::{Lines, Reach};
use warp::{PutBack, SolveWarp, SolveWarpApart};
use weft::SolveWeft;
use wind::Place;

/// The solver of one cloth: its rest shape, what it is made of, and what moves.
#[derive(Clone, Debug)]
pub struct ClothSolver {
    topology: Topology,
    material: Material,
    settings: Settings,
    isa: Isa,
    bands: Bands,
    /// Whether threads share a large sheet.
    shares: bool,
    held: Held,
    soft: Vec<soft::Spring>,
    /// Forces from outside, once there were any.
    pushes: Option<Box<push::Pushes>>,
    bound: Bound,
    plan: Plan,
    /// The air around it, where it feels any.
    air: Option<Surface>,
    /// Load that the tethers' bounds were made for \[m/s2\].
    tethered_under: Option<Vec3>,
    /// What a spring may move a particle by without its thread trembling \[m\].
    steady: f32,
    /// What the tethers' bounds are multiplied by in this tick, as its pins are too far apart.
    tether_ease: f32,
    /// Edges that are held out of colliders.
    edges: contact::Edges,
    state: State,
    scratch: Scratch,
    /// Substeps of this tick that are done.
    done: u32,
    contact_count: u32,
    survey: Survey,
    /// Particles were put elsewhere since the survey was taken.
    surveyed_before: bool,
    mark: stillness::Mark,
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

/// Without gravity, what only touches is pressed by its weight in this \[m/s2\].
const LEAST_GRAVITY: f32 = 9.81;

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
            return bands::inside(|| self.take_tick(input, ended));
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
        input.check(self.held.slots.len() + self.soft.len())?;
        if self.air.is_some() {
            input.wind.validate()?;
        }
        if input.dt != self.plan.tick {
            self.plan_ticks(input.dt);
        }
        self.share_out();
        if self.surveyed_before {
            self.survey_anew();
        }
        let (low, high) = self.bounds();
        let centre = (self.survey.min + self.survey.max) * 0.5;
        self.state.follow(self.topology.layout(), centre);
        let wind = self.take_wind(input, (low, high));
        let load = input.gravity + wind + self.load_of_pushes(input.gravity);
        if !self.tethered_under.is_some_and(|known| is_as_strong(known, load)) {
            self.tether_under(Some(load));
        }
        self.begin_pushes();
        let eases = self.held.tethers.iter().map(|set| set.ease(input.pins));
        self.tether_ease = eases.fold(1.0, f32::max);
        self.begin_carrying();
        self.state.start.copy_from(&self.state.x);
        let (epsilon, layers) = (self.material.thickness, self.settings.layers);
        self.scratch.contact.begin_tick(low, high, epsilon, layers, input.colliders);
        self.state.contacts.begin_tick(input.colliders);
        self.done = 0;
        Ok(self.plan.substeps)
    }

    /// First stage: accelerations from springs, bending, damping, gravity and air. Nothing to do where
    /// gravity acts alone.
    pub fn accumulate_forces(&mut self, input: &StepInput<'_>) {
        self.brake_bending();
        if !self.has_forces() {
            return;
        }
        self.accelerate(input);
        if self.settings.integrator != Integrator::Verlet {
            self.study_forces(input);
        }
    }

    /// Accelerations where the particles are.
    fn accelerate(&mut self, input: &StepInput<'_>) {
        let Topology::Lattice(lattice) = &self.topology else {
            self.accumulate_graph_forces(input);
            self.add_air();
            return;
        };
        let plan = self.plan;
        let x = &self.state.x;
        let layout = lattice.layout;
        let Scratch { a, moments, rows, .. } = &mut self.scratch;
        let (hinges, rigidity) = (&self.held.hinges, plan.hinge_rigidity);
        let forces = AccumulateForces {
            band: self.bands.rows.clone(),
            lattice,
            constants: plan.explicit,
            bend: (rigidity > 0.0).then_some(Bend { hinges, rigidity, layout, x }),
            gravity: input.gravity,
            inverse_mass: &self.held.inverse_mass,
            x,
            a: a.part_mut(),
            rows,
            moments,
        };
        bands::run(self.isa, forces);
        if let Some(pushes) = &self.pushes {
            pushes.add(self.isa, layout, &self.held.inverse_mass, &mut self.scratch.a);
        }
        if plan.damping > 0.0 {
            self.add_damping();
        }
        self.add_air();
    }

    /// Damping with the velocity of this instant, not of half a substep ago: a half kick predicts it,
    /// without which the whole scheme would be of first order; and so it would, were drag left out of it.
    fn add_damping(&mut self) {
        let half = self.half_kick();
        let Topology::Lattice(lattice) = &self.topology else { return };
        let Scratch { a, b, rows, .. } = &mut self.scratch;
        let rows = &*rows;
        let state = &self.state;
        let springs = DampedSprings {
            lattice,
            damping: self.plan.damping / state.unit,
            form: self.material.damping_form,
            shear: self.plan.shear_stiffness > 0.0,
            inverse_mass: &self.held.inverse_mass,
            x: &state.x,
        };
        let gain = half.gain * state.unit;
        let band = &self.bands.rows;
        let predicted = b.part_mut();
        let target = DampingTarget::Predict { keep: half.decay, gain, a, predicted };
        let damping = AddDamping { band: band.clone(), springs, d: &state.d, rows, target };
        bands::run(self.isa, damping);
        let target = DampingTarget::Accelerations(a.part_mut());
        bands::run(self.isa, AddDamping { band: band.clone(), springs, d: b, rows, target });
    }

    /// From the middle of the last substep to its end.
    fn half_kick(&self) -> Kick {
        Kick::new(self.drag(), 0.5 * self.state.last_step)
    }

    /// Rate at which still air stops the cloth \[1/s\].
    fn drag(&self) -> f32 {
        if self.air.is_some() { 0.0 } else { self.material.drag }
    }

    /// Takes the wind of a tick, if the cloth feels any. Gives what it adds to the load on the tethers,
    /// in the direction of gravity \[m/s2\].
    fn take_wind(&mut self, input: &StepInput<'_>, (min, max): (Vec3, Vec3)) -> Vec3 {
        let Some(surface) = &mut self.air else {
            return Vec3::ZERO;
        };
        let origin = self.state.origin;
        let place = Place { origin, min: min - origin, max: max - origin };
        surface.begin_tick(self.isa, &input.wind, place, &self.state.x);
        let load = surface.load(&input.wind, &place, self.material.area_density);
        input.gravity.normalize_or(Vec3::NEG_Y) * load
    }

    /// Drag and lift, on top of all other accelerations.
    fn add_air(&mut self) {
        let Some(surface) = &mut self.air else { return };
        let state = &self.state;
        let push = Push {
            kick: 0.5 * (state.last_step + self.plan.step),
            unit: state.unit,
            area_density: self.material.area_density,
            inverse_mass: &self.held.inverse_mass,
            x: &state.x,
            d: &state.d,
            a: &mut self.scratch.a,
        };
        surface.push(self.isa, push);
    }

    /// Second stage: velocities and positions of the free particles; pins go their way.
    pub fn integrate(&mut self, input: &StepInput<'_>) {
        match self.settings.integrator {
            Integrator::Verlet => self.integrate_verlet(input),
            Integrator::Euler | Integrator::Midpoint => {
                self.state.contacts.edges.warm.clear();
                self.integrate_study();
            }
        }
        self.state.unit = self.plan.step;
        self.move_pins(input);
        self.pull_soft_pins(input);
    }

    fn integrate_verlet(&mut self, input: &StepInput<'_>) {
        let plan = self.plan;
        let acceleration = if self.has_forces() {
            Acceleration::Each(&self.scratch.a)
        } else {
            Acceleration::Uniform(input.gravity)
        };
        // From the middle of the last substep to the middle of this one.
        let kick = Kick::new(self.drag(), 0.5 * (self.state.last_step + plan.step));
        self.state.response = kick.gain * plan.step;
        let part = self.carried();
        let State { d, pull, unit, response, .. } = &mut self.state;
        let integrate = Integrate {
            band: self.bands.rows.clone(),
            acceleration,
            advance: Advance {
                keep: kick.decay * (plan.step / *unit),
                gain: *response,
                longest: self.settings.max_speed * plan.step,
            },
            inverse_mass: &self.held.inverse_mass,
            d: d.part_mut(),
            carry: Carry::new(self.scratch.carries, part, pull),
        };
        bands::run(self.isa, integrate);
        let ratio = plan.step / self.state.last_step;
        let State { d, pull, contacts, .. } = &mut self.state;
        let ActiveSet { edges, impulses, .. } = contacts;
        let pull = self.scratch.carries.then_some(pull);
        let inverse_mass = &self.held.inverse_mass;
        edges.start_warm(ratio * ratio, plan.step, inverse_mass, d, pull, impulses);
        self.state.last_step = plan.step;
    }

    fn move_pins(&mut self, input: &StepInput<'_>) {
        let to = self.span().to;
        let state = &mut self.state;
        for (&slot, pin) in self.held.slots.iter().zip(input.pins) {
            let (start, end) = (pin.start - state.origin, pin.end - state.origin);
            let target = if to < 1.0 { start + (end - start) * to } else { end };
            state.d.set(slot, target - state.x.get(slot));
        }
    }

    /// Third stage: threads or Provot's limit, then tethers.
    pub fn correct(&mut self) {
        self.weigh_soft_pins();
        self.hold_onto_colliders();
        self.fill_places(true);
        // Springs that carry the cloth, and what was asked of them, need no tethers.
        let mut tethered = self.plan.clamped.thread || self.plan.gives;
        match self.plan.form {
            Form::Threads => {
                self.correct_shear();
                if self.solve_threads() {
                    self.limit_strain();
                }
                tethered = true;
            }
            Form::Springs => self.limit_strain(),
        }
        self.empty_places();
        if tethered {
            self.pull_tethers();
        }
        self.note_unfollowed(true);
        self.unweigh_soft_pins();
    }

    /// Lets what lay on a collider go only where it can.
    fn hold_onto_colliders(&mut self) {
        let part = self.carried();
        self.state.contacts.impulses.carry_on(part);
        let State { d, pull, contacts, .. } = &mut self.state;
        if contacts.now.any {
            let carried = self.scratch.carries.then_some(&*pull);
            let (inverse_mass, step) = (&self.held.inverse_mass, self.plan.step);
            self.isa.run(HoldOnto { set: contacts, inverse_mass, step, d, carried });
            contacts.give_left_out(inverse_mass, step);
        }
    }

    fn correct_shear(&mut self) {
        let stiffness = self.plan.shear_stiffness;
        if stiffness > 0.0 {
            let compliance = 1.0 / (stiffness * self.correction_response());
            let limit = self.limit();
            match &self.topology {
                Topology::Lattice(lattice) if self.state.carries => {
                    let Scratch { seams, row_pulls, .. } = &mut self.scratch;
                    if self.bands.rows.count() > 1 {
                        seams.copy(&self.state.d);
                    }
                    let State { x, d, contacts, .. } = &mut self.state;
                    let contacts = contacts.contacts();
                    let cells = Cells {
                        normals: contacts.as_ref().map(|contacts| contacts.normals),
                        lattice,
                        inverse_mass: &self.held.inverse_mass,
                        rule: ShearRule { compliance, limit, crowd: lattice.crowd },
                        x,
                    };
                    let shear = CorrectShear {
                        band: self.bands.rows.clone(),
                        cells,
                        d: d.part_mut(),
                        contacts,
                        seams,
                        rooms: row_pulls,
                    };
                    bands::run(self.isa, shear);
                }
                _ => self.correct_springs(Rule::Shear { compliance, limit }),
            }
        }
    }

    fn limit_strain(&mut self) {
        // The thread form holds shear springs to the limit where it corrects them.
        let shear = self.plan.form == Form::Springs && self.material.shear_stiffness > 0.0;
        let limit = self.limit();
        for _ in 0..self.settings.provot_passes {
            if !self.is_any_beyond(limit, shear) {
                return;
            }
            self.pause_pulls();
            self.correct_springs(Rule::Limit { limit, shear });
            self.go_on_pulling();
        }
    }

    /// Whether there is anything to hold to the limit. A mesh's pass looks for itself, as it goes.
    fn is_any_beyond(&self, limit: f32, shear: bool) -> bool {
        let Topology::Lattice(lattice) = &self.topology else { return true };
        let State { x, d, .. } = &self.state;
        let band = self.bands.rows.clone();
        bands::run(self.isa, IsAnyBeyond { band, lattice, limit, shear, x, d })
    }

    /// Longest that a spring may be, in rest lengths.
    fn limit(&self) -> f32 {
        1.0 + self.material.max_strain
    }

    fn correct_springs(&mut self, rule: Rule) {
        if let (Topology::Graph(graph), Some(room)) = (&self.topology, &mut self.scratch.graph) {
            room.correct_springs(self.isa, graph, rule, self.state.contacts.now.any);
        }
        let Topology::Lattice(lattice) = &self.topology else { return };
        let State { x, d, contacts, .. } = &mut self.state;
        let springs = CorrectSprings {
            band: self.bands.rows.clone(),
            lattice,
            inverse_mass: &self.held.inverse_mass,
            x,
            d,
            rule,
            contacts: contacts.contacts(),
        };
        springs.run(self.isa);
    }

    /// Weft threads, then warp threads. Tells whether any spring came to them beyond its limit: where
    /// none did, none has to be held to it.
    fn solve_threads(&mut self) -> bool {
        let stiffness = self.plan.thread_stiffness;
        if stiffness <= 0.0 {
            return true;
        }
        let isa = self.isa;
        let compliance = 1.0 / (stiffness * self.correction_response());
        let reach = Reach { compliance, limit: self.limit(), steady: self.steady };
        if let (Topology::Graph(graph), Some(room)) = (&self.topology, &mut self.scratch.graph) {
            return room.solve_chains(isa, graph, reach, self.state.contacts.now.any);
        }
        let weft_beyond = self.solve_weft(reach);
        let warp_beyond = self.solve_warp(reach);
        weft_beyond || warp_beyond
    }

    fn solve_weft(&mut self, reach: Reach) -> bool {
        let Topology::Lattice(lattice) = &self.topology else { return false };
        let State { x, d, contacts, .. } = &mut self.state;
        let weft = SolveWeft {
            band: self.bands.rows.clone(),
            lines: lattice.layout.transposed(),
            springs: &lattice.weft_transposed,
            inverse_mass: &self.held.inverse_mass_transposed,
            reach,
            x,
            d: d.part_mut(),
            contacts: contacts.contacts(),
            rooms: &self.scratch.threads,
        };
        bands::run(self.isa, weft)
    }

    fn solve_warp(&mut self, reach: Reach) -> bool {
        let Topology::Lattice(lattice) = &self.topology else { return false };
        let Bands { rows, columns, .. } = &self.bands;
        let State { x, d, contacts, .. } = &mut self.state;
        let Scratch { threads: rooms, apart, load_apart, .. } = &mut self.scratch;
        let (layout, springs) = (lattice.layout, &lattice.warp);
        let inverse_mass = &self.held.inverse_mass;
        if columns.count() == 1 {
            let line = &mut rooms.take().line;
            let lines = Lines { layout, springs, reach, inverse_mass, line };
            let contacts = contacts.contacts();
            return self.isa.run(SolveWarp { layout, lines, x, d, contacts });
        }
        let touches = contacts.now.any;
        let warp = SolveWarpApart {
            band: columns.clone(),
            layout,
            springs,
            inverse_mass,
            reach,
            x,
            d,
            apart: apart.part_mut(),
            contacts: touches.then(|| (&contacts.now, &contacts.load, ValuesMut::all(load_apart))),
            rooms,
        };
        let beyond = bands::run(self.isa, warp);
        let loads = contacts.contacts().map(|contacts| (&*load_apart, contacts.load));
        bands::run(self.isa, PutBack { band: rows.clone(), apart, d: d.part_mut(), loads });
        beyond
    }

    fn pull_tethers(&mut self) {
        if !self.settings.tethers || self.held.tethers.is_empty() {
            return;
        }
        let State { x, d, .. } = &mut self.state;
        for (place, &slot) in self.held.places.iter_mut().zip(&self.held.slots) {
            *place = x.get(slot) + d.get(slot);
        }
        let pull = PullTethers {
            band: self.bands.rows.clone(),
            sets: &self.held.tethers,
            pins: &self.held.places,
            ease: self.tether_ease,
            inverse_mass: &self.held.inverse_mass,
            x,
            d: d.part_mut(),
        };
        bands::run(self.isa, pull);
    }

    /// Fourth stage: contact and friction. Ends the substep.
    pub fn collide(&mut self, input: &StepInput<'_>) {
        if input.colliders.is_empty() && !self.state.contacts.now.any {
            self.contact_count = 0;
            self.state.contacts.edges.clear();
        } else {
            let weight = input.gravity.length().max(LEAST_GRAVITY) * self.state.response;
            let contacts = ResolveContacts {
                bands: &self.bands,
                colliders: input.colliders,
                origin: self.state.origin,
                span: self.span(),
                skin: Skin {
                    epsilon: self.material.thickness,
                    friction: self.material.friction,
                    layers: self.settings.layers,
                    most_push: self.settings.max_push_speed * self.plan.step,
                    per_weight: 1.0 / weight,
                    following: (self.plan.step / contact::FOLLOWING).min(1.0),
                    step: self.plan.step,
                    notes: self.scratch.carries,
                },
                inverse_mass: &mut self.held.inverse_mass,
                x: &mut self.state.x,
                d: &mut self.state.d,
                pull: self.scratch.carries.then_some(&mut self.state.pull),
                room: &mut self.scratch.contact,
                edges: self.settings.edges.then_some(&self.edges),
                max_strain: self.material.max_strain,
                strain: self.survey.max_strain,
                limits: self.settings.provot_passes > 0,
                set: &mut self.state.contacts,
            };
            self.contact_count = contacts.run(self.isa);
        }
        self.end_carrying();
        let State { x, d, pull, carries, .. } = &mut self.state;
        let pull = carries.then(|| pull.part_mut());
        let band = self.bands.rows.clone();
        bands::run(self.isa, Displace { band, x: x.part_mut(), d, pull });
        if self.settings.integrator != Integrator::Verlet {
            self.end_study();
        }
        self.done += 1;
    }

    /// Momentum that the cloth gave a collider in the last tick \[kg m/s\], by the collider's place in
    /// the input; zero where it was not asked to be [`measured`](Collider::measured), and after a tick
    /// that was undone.
    pub fn impulse(&self, collider: usize) -> Vec3 {
        self.state.contacts.impulses.of(collider)
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
            self.survey_anew();
            return Err(SolverError::Diverged);
        }
        self.survey = survey;
        Ok(TickReport {
            substeps: self.plan.substeps,
            max_strain: survey.max_strain,
            contact_count: self.contact_count,
        })
    }

    fn take_survey(&self) -> Survey {
        let survey = TakeSurvey {
            band: self.bands.rows.clone(),
            lattice: self.topology.as_lattice().map(|lattice| &**lattice),
            x: &self.state.x,
            d: &self.state.d,
            start: &self.state.start,
        };
        let mut survey = bands::run(self.isa, survey);
        if let Topology::Graph(graph) = &self.topology {
            survey.max_strain = graph::largest_strain(self.isa, graph, &self.state.x);
        }
        survey
    }

    fn survey_anew(&mut self) {
        self.survey = self.take_survey();
        self.surveyed_before = false;
    }

    /// The survey of where the particles are now.
    fn survey(&self) -> Survey {
        if self.surveyed_before { self.take_survey() } else { self.survey }
    }

    fn has_forces(&self) -> bool {
        let plan = &self.plan;
        !plan.explicit.is_zero()
            || plan.hinge_rigidity > 0.0
            || plan.damping > 0.0
            || self.air.is_some()
            || self.is_pushed()
            || self.settings.integrator != Integrator::Verlet
    }

    /// The part of the tick that the present substep covers.
    fn span(&self) -> Span {
        let n = self.plan.substeps as f32;
        Span { from: self.done as f32 / n, to: (self.done + 1) as f32 / n }
    }

    fn accumulate_graph_forces(&mut self, input: &StepInput<'_>) {
        self.fill_places(false);
        let half = self.half_kick();
        let (Topology::Graph(graph), Some(strengths)) = (&self.topology, &self.held.strengths)
        else {
            return;
        };
        let Scratch { a, graph: Some(room), .. } = &mut self.scratch else { return };
        let (isa, plan) = (self.isa, &self.plan);
        room.accumulate_forces(isa, graph, strengths, plan, input.gravity, a);
        if let Some(pushes) = &self.pushes {
            pushes.add(isa, graph.layout, &self.held.inverse_mass, a);
        }
        if plan.damping > 0.0 {
            let form = self.material.damping_form;
            room.add_damping(isa, graph, strengths, form, half, &self.state, a);
        }
    }

    /// A graph's particles are gathered from places; on a lattice there is nothing to do.
    fn fill_places(&mut self, corrects: bool) {
        if let Some(room) = &mut self.scratch.graph {
            room.fill(self.isa, &self.held.inverse_mass, &self.state, corrects);
        }
    }

    fn empty_places(&mut self) {
        if let Some(room) = &self.scratch.graph {
            room.empty(self.isa, &mut self.state);
        }
    }
}

/// Whether two gravities pull alike, in whatever direction, but for rounding: as they do in the frame of
/// a cloth that turns.
fn is_as_strong(a: Vec3, b: Vec3) -> bool {
    a == b || (a.length_squared() - b.length_squared()).abs() <= 1e-4 * a.length_squared()
}
