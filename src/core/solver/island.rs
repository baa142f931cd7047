//! Cloths that may touch each other, stepped together.

use bevy_math::Vec3;

use crate::solver::cloth_contact::{Body, Couples, Parts};
use crate::solver::contact::FurthestWay;
use crate::solver::error::SolverError;
use crate::solver::input::{StepInput, TickReport};
use crate::solver::simd::parallel;
use crate::solver::{ClothSolver, Stage};

/// How much faster a cloth may become within a tick, as it is pulled or struck.
const HASTE: f32 = 1.5;

/// Cloths that may touch each other in a tick, stepped in lockstep: all take the substeps of the one with most, and in each substep
/// particles that touch are moved apart, after the threads of all of them and before their strain limits.
///
/// It is no more than room to work in. Cloths may come together and part between any two ticks, and what later bits depend on is
/// the cloths' own and saved with them. Cloths collide that were
/// [asked to](ClothSolver::set_inter_collision) and share a layer. The order of the members is part of the input: bits depend on it.
///
/// ```
/// # use bevy_math::{Vec2, Vec3};
/// # use bevy_drape_core::solver::*;
/// # use std::sync::Arc;
/// # fn main() -> Result<(), SolverError> {
/// let sheet = Arc::new(Lattice::sheet(Vec2::ONE, 16, 16, MassLumping::Lumped)?);
/// let mut cloths = Vec::new();
/// for layer in 0..2 {
///     let at = sheet.rest_positions().iter().map(|&p| p + Vec3::Y * 0.1 * layer as f32);
///     let at: Vec<_> = at.collect();
///     let mut cloth = ClothSolver::new(sheet.clone(), &at, Material::USUAL, Settings::default())?;
///     cloth.set_inter_collision(Some(InterCollision::default()))?;
///     cloths.push(cloth);
/// }
/// let input = StepInput { dt: 1.0 / 60.0, ..StepInput::default() };
/// let mut island = Island::default();
/// let mut members: Vec<_> = cloths.iter_mut().map(|cloth| Member::new(cloth, input)).collect();
/// island.tick(&mut members);
/// assert!(members.iter().all(|member| member.outcome.as_ref().is_some_and(Result::is_ok)));
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Default)]
pub struct Island {
    couples: Couples,
}

/// A cloth in an [`Island`], for a tick.
#[derive(Debug)]
pub struct Member<'a> {
    /// The cloth.
    pub solver: &'a mut ClothSolver,
    /// The cloth's surroundings. All members have the same length of tick.
    pub input: StepInput<'a>,
    /// Whether the cloth takes the tick. One that does not stays where it is, and others lie on it as on a wall.
    pub moves: bool,
    /// How far its surroundings are moved in the tick, and the cloth with them: that of a frame which the input is seen from \[m\].
    pub drift: Vec3,
    /// What came of its tick, once that has ended.
    pub outcome: Option<Result<TickReport, SolverError>>,
    /// Whether a spring may be beyond its limit in this substep.
    exceeds: bool,
}

impl<'a> Member<'a> {
    /// A cloth that takes the tick.
    pub fn new(solver: &'a mut ClothSolver, input: StepInput<'a>) -> Self {
        let drift = Vec3::ZERO;
        Self { solver, input, moves: true, drift, outcome: None, exceeds: false }
    }

    /// A cloth that does not take the tick: it sleeps, or is held.
    pub fn still(solver: &'a mut ClothSolver) -> Self {
        Self { moves: false, ..Self::new(solver, StepInput::default()) }
    }

    fn refuse(&mut self, error: SolverError) {
        self.outcome = Some(Err(error));
        self.moves = false;
    }
}

impl Body for Member<'_> {
    fn parts(&mut self) -> Option<Parts<'_>> {
        self.solver.parts(self.moves)
    }
}

impl Island {
    /// Takes one tick of all members that move, all substeps. A member whose input cannot be used does not take it; see its
    /// [`outcome`](Member::outcome).
    pub fn tick(&mut self, members: &mut [Member<'_>]) {
        self.tick_observed(members, |_, _| ());
    }

    /// Takes one tick as [`Island::tick`] does, and calls `ended` with each member's place when it has ended a stage.
    pub fn tick_observed(
        &mut self,
        members: &mut [Member<'_>],
        ended: impl FnMut(usize, Stage) + Send,
    ) {
        if members.iter().any(|member| member.solver.is_to_share()) {
            parallel::inside(|| self.take_tick(members, ended));
        } else {
            self.take_tick(members, ended);
        }
    }

    fn take_tick(&mut self, members: &mut [Member<'_>], mut ended: impl FnMut(usize, Stage)) {
        let substeps = self.begin_tick(members);
        for _ in 0..substeps {
            for (place, member) in moving(members) {
                member.solver.accumulate_forces(&member.input);
                ended(place, Stage::Forces);
                member.solver.integrate(&member.input);
                ended(place, Stage::Integrate);
            }
            self.correct_observed(members, &mut ended);
            for (place, member) in moving(members) {
                member.solver.collide(&member.input);
                ended(place, Stage::Collide);
            }
        }
        for (_, member) in moving(members) {
            member.outcome = Some(member.solver.end_tick());
        }
    }

    /// Begins a tick, and says how many substeps it has. In each, all members that move take the four stages in their order, each
    /// stage before any takes the next one; [`Island::correct`] is the third of all of them.
    pub fn begin_tick(&mut self, members: &mut [Member<'_>]) -> u32 {
        let mut most = 0;
        let dt = members.iter().find(|member| member.moves).map(|member| member.input.dt);
        for member in members.iter_mut().filter(|member| member.moves) {
            let checked = member.solver.check_input(&member.input);
            if dt != Some(member.input.dt) {
                member.refuse(SolverError::OtherTick);
            } else if let Err(error) = checked {
                member.refuse(error);
            } else {
                most = most.max(member.solver.plan_tick(&member.input, true));
            }
        }
        for (_, member) in moving(members) {
            member.solver.drift = member.drift;
            member.solver.step_with(most);
            member.solver.begin_planned_tick(&member.input);
        }
        self.couples.begin_tick(members);
        most
    }

    /// The third stage of a substep, of all members that move.
    pub fn correct(&mut self, members: &mut [Member<'_>]) {
        self.correct_observed(members, &mut |_, _| ());
    }

    fn correct_observed(
        &mut self,
        members: &mut [Member<'_>],
        ended: &mut impl FnMut(usize, Stage),
    ) {
        for (_, member) in moving(members) {
            member.exceeds = member.solver.pull_threads();
            member.solver.end_corrections();
        }
        let left = moving(members).map(|(_, member)| member.solver.substeps_left()).max();
        self.couples.meet(members, left.unwrap_or(0));
        for (place, member) in moving(members) {
            let touching = self.couples.touching(place);
            member.solver.touching_others = touching;
            member.solver.begin_corrections();
            member.solver.hold_threads(member.exceeds || touching > 0);
        }
        self.couples.keep_apart(members);
        for (place, member) in moving(members) {
            member.solver.keep_layers_apart();
            member.solver.hold_to_skin();
            ended(place, Stage::Correct);
        }
        if left == Some(0) {
            self.couples.end_tick(members);
        }
    }

    /// The members that have touched each other in the tick, by their places: two by two.
    pub fn touched(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.couples.touched()
    }
}

fn moving<'a, 'b>(
    members: &'a mut [Member<'b>],
) -> impl Iterator<Item = (usize, &'a mut Member<'b>)> {
    members.iter_mut().enumerate().filter(|(_, member)| member.moves)
}

impl ClothSolver {
    /// How far from its [`bounds`](ClothSolver::bounds) the cloth may touch another in a tick of `dt` seconds, if nothing new
    /// moves it but a gravity; `None` where it collides with no others \[m\]. One that takes no tick has a tick of 0 s.
    pub fn reach_of_tick(&self, dt: f32, gravity: Vec3) -> Option<f32> {
        let others = self.others_contact.as_ref()?;
        let speed = if dt > 0.0 { self.fastest() } else { 0.0 };
        Some(others.widest() + HASTE * speed * dt + gravity.length() * dt * dt)
    }

    /// Speed of the fastest particle \[m/s\].
    fn fastest(&self) -> f32 {
        let farthest = FurthestWay { band: self.bands.sums.clone(), d: &self.state.d, from: None };
        parallel::run(self.isa, farthest).0.sqrt() / self.state.unit
    }

    /// Substeps of the tick after the present one.
    fn substeps_left(&self) -> u32 {
        self.plan.substeps - self.done - 1
    }

    /// Takes so many substeps in the tick that is planned, together with others.
    fn step_with(&mut self, substeps: u32) {
        if self.lockstep != substeps {
            self.lockstep = substeps;
            self.plan_ticks(self.plan.tick);
        }
    }
}
