//! The solver of one cloth: pure numerics over structure-of-arrays state. No ECS, no assets, no clock.
//!
//! A tick of length `dt` is made of `n` substeps of length `h = dt / n`, and each substep of four
//! stages, one function each:
//!
//! 1. [`accumulate_forces`](ClothSolver::accumulate_forces): explicit springs, bending, damping, gravity
//!    give accelerations (`forces`, `bending`);
//! 2. [`integrate`](ClothSolver::integrate): Verlet in its leapfrog form, air drag; pins move to where
//!    they are to be (`integrate`);
//! 3. [`correct`](ClothSolver::correct): *threads* are solved whole, or *springs* are held to Provot's
//!    limit; tethers to the pins (`threads`, `constraint`, `tethers`);
//! 4. [`collide`](ClothSolver::collide): particles are held epsilon outside the colliders (`contact`).
//!
//! Every correction of a position changes the stored velocity by the same correction over `h`, never
//! by a difference of rounded positions. What is where:
//!
//! | file | what it holds |
//! | --- | --- |
//! | `lattice` | the rest shape: immutable, shared by equal cloths |
//! | `state` | positions, velocities, working room |
//! | `held` | what depends on the pins: inverse masses, tethers, clamped hinges |
//! | `plan` | the stability bound; substeps, springs or threads, clamped constants |
//! | `parameters` | material and settings |
//! | `measure` | strain, bounds, whether all is finite |
//! | `lanes`, `isa` | blocks of 16 particles; one body a kernel, compiled for several instruction sets |

mod bending;
mod constraint;
mod contact;
mod error;
mod forces;
mod held;
mod integrate;
mod isa;
mod lanes;
mod lattice;
mod measure;
mod parameters;
mod plan;
mod state;
mod tethers;
mod threads;

use std::sync::Arc;

use bevy::math::Vec3;

pub use contact::{Collider, Pose};
pub use error::SolverError;
pub use isa::Isa;
pub use lanes::LANES;
pub use lattice::{Lattice, LatticeError, MassLumping};
pub use measure::StrainReport;
pub use parameters::{
    Bending, DampingForm, FormChoice, Material, ParameterError, Settings, Substeps,
};
pub use plan::{Clamped, Form, Plan, PlanReason};

use bending::{AddBending, BendHinges};
use constraint::{CorrectSprings, Rule};
use contact::{ResolveContacts, Span};
use forces::{AccumulateSprings, AddDamping, DampedSprings, DampingTarget};
use held::Held;
use integrate::{Acceleration, Integrate, Kick};
use measure::{Survey, TakeSurvey};
use plan::Bound;
use state::{Scratch, State};
use tethers::PullTethers;
use threads::{AddTransposed, Apply, SolveThreads, Transpose};

/// Coordinates and speeds beyond this are refused.
const FARTHEST: f32 = 1e7;
/// Part of the strain limit from which the thread form starts to watch it.
const WATCH: f32 = 0.8;

/// The solver of one cloth: its rest shape, what it is made of, and what moves.
#[derive(Clone, Debug)]
pub struct ClothSolver {
    lattice: Arc<Lattice>,
    material: Material,
    settings: Settings,
    isa: Isa,
    held: Held,
    bound: Bound,
    plan: Plan,
    /// Gravity that the tethers' bounds were made for [m/s2].
    tethered_under: Option<Vec3>,
    state: State,
    scratch: Scratch,
    /// Substeps of this tick that are done.
    done: u32,
    contact_count: u32,
    survey: Survey,
}

/// What surrounds a cloth in one tick. Positions are in world space.
#[derive(Clone, Copy, Debug)]
pub struct StepInput<'a> {
    /// The tick's length [s].
    pub dt: f32,
    /// Gravity [m/s2].
    pub gravity: Vec3,
    /// Motions of the pins, in the order of [`ClothSolver::pins`].
    pub pins: &'a [PinMotion],
    /// Colliders, in an order that does not change from run to run.
    pub colliders: &'a [Collider<'a>],
}

/// Where a pin is at the tick's start and end, in world space [m]; it moves evenly between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinMotion {
    /// Where the tick begins.
    pub start: Vec3,
    /// Where it ends.
    pub end: Vec3,
}

impl PinMotion {
    /// A pin that stays.
    pub fn still(at: Vec3) -> Self {
        Self { start: at, end: at }
    }
}

/// What a tick came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TickReport {
    /// Substeps taken.
    pub substeps: u32,
    /// Largest strain of a structural spring at the end.
    pub max_strain: f32,
    /// Contacts in the last substep.
    pub contact_count: u32,
}

impl ClothSolver {
    /// A cloth at rest at the given start positions in world space [m], row by row, nothing held.
    ///
    /// # Errors
    /// [`SolverError`] for positions, a material or settings that cannot be used.
    pub fn new(
        lattice: Arc<Lattice>,
        positions: &[Vec3],
        material: Material,
        settings: Settings,
    ) -> Result<Self, SolverError> {
        material.validate()?;
        check_settings(&lattice, &settings)?;
        if positions.len() != lattice.particle_count() {
            return Err(SolverError::WrongPositionCount {
                expected: lattice.particle_count(),
                got: positions.len(),
            });
        }
        if let Some(particle) = positions.iter().position(|&p| !is_near(p)) {
            return Err(SolverError::NonFinite { what: "position", particle });
        }
        let mut held = Held::new(&lattice, Vec::new());
        held.set_density(&lattice, material.area_density);
        let bound = Bound::new(&lattice, &held.hinges, &held.inverse_mass);
        let state = State::new(lattice.layout, positions);
        let mut solver = Self {
            plan: Plan::new(&bound, &material, &settings, 1.0 / 64.0),
            scratch: Scratch::new(lattice.layout),
            isa: Isa::detect(),
            tethered_under: None,
            done: 0,
            contact_count: 0,
            survey: Survey::default(),
            lattice,
            material,
            settings,
            held,
            bound,
            state,
        };
        solver.survey = solver.take_survey();
        Ok(solver)
    }

    /// Changes the material.
    ///
    /// # Errors
    /// [`SolverError::Parameter`]; the old material then stays.
    pub fn set_material(&mut self, material: Material) -> Result<(), SolverError> {
        material.validate()?;
        self.material = material;
        self.replan();
        Ok(())
    }

    /// Changes the settings.
    ///
    /// # Errors
    /// [`SolverError::Parameter`] or [`SolverError::OtherLumping`]; the old settings then stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), SolverError> {
        check_settings(&self.lattice, &settings)?;
        self.settings = settings;
        self.replan();
        Ok(())
    }

    /// Holds these particles and no others, in any order. What was held and is no more goes on with
    /// the velocity it had.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`]; the old pins then stay.
    pub fn set_pins(&mut self, particles: &[u32]) -> Result<(), SolverError> {
        let count = self.lattice.particle_count();
        if let Some(&out) = particles.iter().find(|&&p| p as usize >= count) {
            return Err(SolverError::NoSuchParticle { particle: out as usize, count });
        }
        let mut sorted = particles.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        if sorted != self.held.particles {
            self.held = Held::new(&self.lattice, sorted);
            self.replan();
        }
        Ok(())
    }

    /// The held particles, ascending.
    pub fn pins(&self) -> &[u32] {
        &self.held.particles
    }

    /// Forces an instruction set: same bits, other speed. The widest is taken by default.
    pub fn set_isa(&mut self, isa: Isa) {
        self.isa = isa;
    }

    /// Takes one tick, all substeps.
    ///
    /// # Errors
    /// [`SolverError`] for input that cannot be used, and nothing is done; or
    /// [`SolverError::Diverged`].
    pub fn tick(&mut self, input: &StepInput<'_>) -> Result<TickReport, SolverError> {
        let substeps = self.begin_tick(input)?;
        for _ in 0..substeps {
            self.accumulate_forces(input);
            self.integrate(input);
            self.correct();
            self.collide(input);
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
        if input.dt != self.plan.tick {
            self.plan = Plan::new(&self.bound, &self.material, &self.settings, input.dt);
        }
        if self.tethered_under != Some(input.gravity) {
            for set in &mut self.held.tethers {
                set.set_limits(&self.lattice, &self.material, input.gravity);
            }
            self.tethered_under = Some(input.gravity);
        }
        let centre = (self.survey.min + self.survey.max) * 0.5;
        self.state.follow(self.lattice.layout, centre);
        self.state.start.copy_from(&self.state.x);
        // Colliders may have come, or been put elsewhere, since the last tick.
        self.scratch.clearance.fill(0.0);
        self.done = 0;
        Ok(self.plan.substeps)
    }

    /// First stage: accelerations from springs, bending, damping and gravity. Nothing to do where
    /// gravity acts alone.
    pub fn accumulate_forces(&mut self, input: &StepInput<'_>) {
        if !self.has_forces() {
            return;
        }
        let (isa, lattice, plan) = (self.isa, &*self.lattice, self.plan);
        let inverse_mass = &self.held.inverse_mass;
        isa.run(AccumulateSprings {
            lattice,
            constants: plan.explicit,
            gravity: input.gravity,
            inverse_mass,
            x: &self.state.x,
            a: &mut self.scratch.a,
        });
        if plan.hinge_rigidity > 0.0 {
            for hinges in &self.held.hinges {
                isa.run(BendHinges {
                    lattice,
                    hinges,
                    rigidity: plan.hinge_rigidity,
                    x: &self.state.x,
                    moments: &mut self.scratch.b,
                });
                isa.run(AddBending {
                    lattice,
                    hinges,
                    inverse_mass,
                    moments: &self.scratch.b,
                    a: &mut self.scratch.a,
                });
            }
        }
        if plan.damping > 0.0 {
            self.add_damping();
        }
    }

    /// Damping with the velocity of this instant, not of half a substep ago: a half kick predicts it,
    /// without which the whole scheme would be of first order.
    fn add_damping(&mut self) {
        let Scratch { a, b, .. } = &mut self.scratch;
        let state = &self.state;
        let common = DampedSprings {
            lattice: &self.lattice,
            damping: self.plan.damping,
            form: self.material.damping_form,
            shear: self.plan.shear_stiffness > 0.0,
            inverse_mass: &self.held.inverse_mass,
            x: &state.x,
        };
        let half_step = 0.5 * state.last_step;
        let target = DampingTarget::Predict { half_step, a, predicted: b };
        self.isa.run(AddDamping { springs: common, v: &state.v, target });
        let target = DampingTarget::Accelerations(a);
        self.isa.run(AddDamping { springs: common, v: b, target });
    }

    /// Second stage: velocities and positions of the free particles; pins go their way.
    pub fn integrate(&mut self, input: &StepInput<'_>) {
        let plan = self.plan;
        let acceleration = if self.has_forces() {
            Acceleration::Each(&self.scratch.a)
        } else {
            Acceleration::Uniform(input.gravity)
        };
        // From the middle of the last substep to the middle of this one.
        let kick = Kick::new(self.material.drag, 0.5 * (self.state.last_step + plan.step));
        self.isa.run(Integrate {
            layout: self.lattice.layout,
            acceleration,
            kick,
            step: plan.step,
            max_speed: self.settings.max_speed,
            inverse_mass: &self.held.inverse_mass,
            x: &mut self.state.x,
            v: &mut self.state.v,
        });
        self.state.last_step = plan.step;
        self.move_pins(input);
    }

    fn move_pins(&mut self, input: &StepInput<'_>) {
        let to = self.span().to;
        let state = &mut self.state;
        for (&slot, pin) in self.held.slots.iter().zip(input.pins) {
            let (start, end) = (pin.start - state.origin, pin.end - state.origin);
            let target = if to < 1.0 { start + (end - start) * to } else { end };
            state.v.set(slot, (target - state.x.get(slot)) / self.plan.step);
            state.x.set(slot, target);
        }
    }

    /// Third stage: threads or Provot's limit, then tethers.
    pub fn correct(&mut self) {
        match self.plan.form {
            Form::Threads => {
                self.correct_shear();
                self.solve_threads();
                if self.survey.max_strain > WATCH * self.material.max_strain {
                    self.limit_strain();
                }
                self.pull_tethers();
            }
            Form::Springs => {
                self.limit_strain();
                // Springs that carry what was asked of them need no help.
                if self.plan.clamped.thread {
                    self.pull_tethers();
                }
            }
        }
    }

    fn correct_shear(&mut self) {
        let Plan { step, shear_stiffness, .. } = self.plan;
        if shear_stiffness > 0.0 {
            self.correct_springs(Rule::Shear { compliance: 1.0 / (shear_stiffness * step * step) });
        }
    }

    fn limit_strain(&mut self) {
        let limit = 1.0 + self.material.max_strain;
        let shear = self.material.shear_stiffness > 0.0;
        for _ in 0..self.settings.provot_passes {
            self.correct_springs(Rule::Limit { limit, shear });
        }
    }

    fn correct_springs(&mut self, rule: Rule) {
        self.isa.run(CorrectSprings {
            lattice: &self.lattice,
            inverse_mass: &self.held.inverse_mass,
            x: &mut self.state.x,
            v: &mut self.state.v,
            rate: 1.0 / self.plan.step,
            rule,
        });
    }

    /// Weft threads in the transposed layout, then warp threads where they lie.
    fn solve_threads(&mut self) {
        let Plan { step, thread_stiffness, .. } = self.plan;
        if thread_stiffness <= 0.0 {
            return;
        }
        let (isa, rate) = (self.isa, 1.0 / step);
        let compliance = 1.0 / (thread_stiffness * step * step);
        let layout = self.lattice.layout;
        let State { x, v, .. } = &mut self.state;
        let Scratch { transposed, line, .. } = &mut self.scratch;
        isa.run(Transpose { layout, from: x, to: transposed });
        isa.run(SolveThreads {
            layout: layout.transposed(),
            springs: &self.lattice.weft_transposed,
            compliance,
            inverse_mass: &self.held.inverse_mass_transposed,
            x: transposed,
            v: None,
            line,
            apply: Apply::Overwrite,
        });
        isa.run(AddTransposed { layout: layout.transposed(), corrections: transposed, x, v, rate });
        isa.run(SolveThreads {
            layout,
            springs: &self.lattice.warp,
            compliance,
            inverse_mass: &self.held.inverse_mass,
            x,
            v: Some(v),
            line,
            apply: Apply::Add { rate },
        });
    }

    fn pull_tethers(&mut self) {
        if !self.settings.tethers {
            return;
        }
        for set in &self.held.tethers {
            self.isa.run(PullTethers {
                layout: self.lattice.layout,
                set,
                inverse_mass: &self.held.inverse_mass,
                x: &mut self.state.x,
                v: &mut self.state.v,
                rate: 1.0 / self.plan.step,
            });
        }
    }

    /// Fourth stage: contact and friction. Ends the substep.
    pub fn collide(&mut self, input: &StepInput<'_>) {
        if input.colliders.is_empty() {
            self.contact_count = 0;
        } else {
            self.contact_count = self.isa.run(ResolveContacts {
                layout: self.lattice.layout,
                colliders: input.colliders,
                origin: self.state.origin,
                span: self.span(),
                step: self.plan.step,
                epsilon: self.material.thickness,
                friction: self.material.friction,
                inverse_mass: &self.held.inverse_mass,
                x: &mut self.state.x,
                v: &mut self.state.v,
                clearance: &mut self.scratch.clearance,
                gaps: &mut self.scratch.gaps,
            });
        }
        self.done += 1;
    }

    /// Ends the tick.
    ///
    /// # Errors
    /// [`SolverError::Diverged`] where anything is not finite.
    pub fn end_tick(&mut self) -> Result<TickReport, SolverError> {
        let survey = self.take_survey();
        if !survey.finite || survey.max.max(-survey.min).max_element() > FARTHEST {
            self.state.x.copy_from(&self.state.start);
            self.state.v = lanes::Soa::zeros(self.state.v.len());
            self.state.last_step = 0.0;
            self.survey = self.take_survey();
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
        self.isa.run(TakeSurvey {
            lattice: &self.lattice,
            x: &self.state.x,
            v: &self.state.v,
            start: &self.state.start,
        })
    }

    fn has_forces(&self) -> bool {
        let plan = &self.plan;
        !plan.explicit.is_zero() || plan.hinge_rigidity > 0.0 || plan.damping > 0.0
    }

    /// The part of the tick that the present substep covers.
    fn span(&self) -> Span {
        let n = self.plan.substeps as f32;
        Span { from: self.done as f32 / n, to: (self.done + 1) as f32 / n }
    }

    /// Works out again what follows from lattice, pins, material and settings.
    fn replan(&mut self) {
        self.held.set_density(&self.lattice, self.material.area_density);
        self.bound = Bound::new(&self.lattice, &self.held.hinges, &self.held.inverse_mass);
        self.plan = Plan::new(&self.bound, &self.material, &self.settings, self.plan.tick);
        self.tethered_under = None;
    }

    fn check_input(&self, input: &StepInput<'_>) -> Result<(), SolverError> {
        if !(input.dt > 0.0 && input.dt <= 1.0) {
            return Err(SolverError::Tick(input.dt));
        }
        if !(input.gravity.abs().max_element() <= 1e6) {
            return Err(SolverError::Gravity);
        }
        let (pins, motions) = (self.held.slots.len(), input.pins.len());
        if pins != motions {
            return Err(SolverError::WrongPinCount { pins, motions });
        }
        if let Some(pin) = input.pins.iter().position(|p| !(is_near(p.start) && is_near(p.end))) {
            return Err(SolverError::PinTarget(pin));
        }
        let usable = |c: &Collider<'_>| {
            c.start.is_valid() && c.end.is_valid() && c.friction >= 0.0 && c.friction <= 1e3
        };
        match input.colliders.iter().position(|c| !usable(c)) {
            Some(collider) => Err(SolverError::Collider(collider)),
            None => Ok(()),
        }
    }
}

/// Reading and writing.
impl ClothSolver {
    /// The rest shape.
    pub fn lattice(&self) -> &Arc<Lattice> {
        &self.lattice
    }

    /// The material.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What the solver makes of them.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Plans ticks of another length [s] than the last.
    ///
    /// # Errors
    /// [`SolverError::Tick`].
    pub fn plan_for(&mut self, tick: f32) -> Result<&Plan, SolverError> {
        if !(tick > 0.0 && tick <= 1.0) {
            return Err(SolverError::Tick(tick));
        }
        self.plan = Plan::new(&self.bound, &self.material, &self.settings, tick);
        Ok(&self.plan)
    }

    /// Where the cloth's own coordinates begin, in world space [m].
    pub fn origin(&self) -> Vec3 {
        self.state.origin
    }

    /// A particle's position in world space [m], at the last tick's end.
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

    /// A particle's velocity [m/s], at the middle of the last substep.
    pub fn velocity(&self, particle: usize) -> Vec3 {
        self.state.v.get(self.slot(particle))
    }

    /// A particle's mass [kg].
    pub fn mass(&self, particle: usize) -> f32 {
        self.lattice.area[self.slot(particle)] * self.material.area_density
    }

    /// Puts a particle elsewhere, in world space [m]. Where all are put, a cloth is reset.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`] or [`SolverError::NonFinite`].
    pub fn set_position(&mut self, particle: usize, position: Vec3) -> Result<(), SolverError> {
        self.check_particle(particle, "position", position)?;
        let slot = self.slot(particle);
        self.state.x.set(slot, position - self.state.origin);
        Ok(())
    }

    /// Gives a particle a velocity [m/s]. Before the first tick it is the one at that instant.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`] or [`SolverError::NonFinite`].
    pub fn set_velocity(&mut self, particle: usize, velocity: Vec3) -> Result<(), SolverError> {
        self.check_particle(particle, "velocity", velocity)?;
        let slot = self.slot(particle);
        self.state.v.set(slot, velocity);
        Ok(())
    }

    /// Whether any particle moved in the last tick.
    pub fn has_moved(&self) -> bool {
        self.survey.moved > 0.0
    }

    /// Corners of the box around all particles at the last tick's end, in world space [m].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.state.origin + self.survey.min, self.state.origin + self.survey.max)
    }

    /// Strains of the structural springs. Sorts them: for reports, not for every frame.
    pub fn strain(&self) -> StrainReport {
        StrainReport::new(&self.lattice, &self.state.x)
    }

    fn slot(&self, particle: usize) -> usize {
        let columns = self.lattice.layout.columns;
        assert!(particle < self.lattice.particle_count(), "no particle {particle}");
        self.lattice.layout.slot(particle / columns, particle % columns)
    }

    fn check_particle(
        &self,
        particle: usize,
        what: &'static str,
        value: Vec3,
    ) -> Result<(), SolverError> {
        let count = self.lattice.particle_count();
        if particle >= count {
            return Err(SolverError::NoSuchParticle { particle, count });
        }
        if !is_near(value) {
            return Err(SolverError::NonFinite { what, particle });
        }
        Ok(())
    }
}

fn is_near(p: Vec3) -> bool {
    p.abs().max_element() <= FARTHEST
}

fn check_settings(lattice: &Lattice, settings: &Settings) -> Result<(), SolverError> {
    settings.validate()?;
    if settings.lumping != lattice.lumping {
        return Err(SolverError::OtherLumping { lattice: lattice.lumping, asked: settings.lumping });
    }
    Ok(())
}
