//! Times of the stages of a tick, where they are asked for.

use core::time::Duration;

use bevy::platform::time::Instant;
use bevy::prelude::*;

use crate::schedule::ClothSubstepSystems;
use crate::solver::{ClothSolver, SolverError, Stage, StepInput, TickReport};

/// Times of the stages of a tick's substeps, in the order of [`ClothSubstepSystems`].
///
/// The component is on the cloths that are measured.
#[derive(Component, Clone, Copy, Default)]
pub(crate) struct StageTimes(pub [Duration; 4]);

impl StageTimes {
    pub(crate) fn add(&mut self, other: &Self) {
        for (sum, time) in self.0.iter_mut().zip(other.0) {
            *sum += time;
        }
    }

    /// Takes a tick, and the times of its stages.
    fn tick(
        &mut self,
        solver: &mut ClothSolver,
        input: &StepInput<'_>,
    ) -> Result<TickReport, SolverError> {
        let mut timing = Timing::new();
        solver.tick_observed(input, |stage| self.note(stage, timing.lap()))
    }

    /// Notes the time of a stage.
    pub(crate) fn note(&mut self, stage: Stage, spent: Duration) {
        use ClothSubstepSystems::{Collide, Correct, Forces, Integrate};
        match stage {
            Stage::Begin => {}
            Stage::Forces => self.add_to(Forces, spent),
            Stage::Integrate => self.add_to(Integrate, spent),
            Stage::Correct => self.add_to(Correct, spent),
            Stage::Collide => self.add_to(Collide, spent),
        }
    }

    fn time(&mut self, stage: ClothSubstepSystems, act: impl FnOnce()) {
        let start = Instant::now();
        act();
        self.add_to(stage, start.elapsed());
    }

    fn add_to(&mut self, stage: ClothSubstepSystems, time: Duration) {
        self.0[stage as usize] += time;
    }
}

/// A clock that tells the time from one look at it to the next.
pub(crate) struct Timing(Instant);

impl Timing {
    pub(crate) fn new() -> Self {
        Self(Instant::now())
    }

    pub(crate) fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - core::mem::replace(&mut self.0, now)
    }
}

/// Takes a tick, and its times where they are asked for.
pub(crate) fn tick(
    times: Option<Mut<StageTimes>>,
    solver: &mut ClothSolver,
    input: &StepInput<'_>,
) -> Result<TickReport, SolverError> {
    match times {
        None => solver.tick(input),
        Some(mut times) => times.tick(solver, input),
    }
}

/// Does a stage, and takes its time where that is asked for.
pub(crate) fn stage(
    times: Option<Mut<StageTimes>>,
    stage: ClothSubstepSystems,
    act: impl FnOnce(),
) {
    match times {
        None => act(),
        Some(mut times) => times.time(stage, act),
    }
}
