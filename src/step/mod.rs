//! One tick: gather -> solve -> finish. The solver does the work; here it meets the world.

pub(crate) mod bodies;
pub(crate) mod impulses;
pub(crate) mod islands;

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::time::{Fixed, Virtual};

use crate::cloth::events::ClothDiverged;
use crate::cloth::gravity::{ClothGravity, ClothGravityOverride};
use crate::collider::tick_colliders::{ColliderRoom, Found, TickColliders, note_colliders};
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::pose::frames::FrameClock;
use crate::pose::moves::Moves;
use crate::pose::skeleton::Joints;
use crate::schedule::{ClothSubstep, ClothSubstepSystems};
use crate::sdf::DistanceField;
use crate::simulation::ClothSimulation;
use crate::simulation::anchors::note_anchors;
use crate::simulation::complaints::solver_error;
use crate::simulation::stage_times::{self, StageTimes};
use crate::simulation::tick_state::{ClothStep, TickState, input};
use crate::solver::{ClothSolver, Collider, RigidMotion, SolverError, StepInput};
use crate::step::islands::Islands;
use crate::wind::zone::WindZones;

/// Which form of the substeps runs. Both give the same bits.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Resource, Default, Debug, PartialEq, Clone)]
pub enum ClothExecution {
    /// Staged if the game has added systems to [`ClothSubstep`], else fused.
    ///
    /// Systems are counted: a game that only replaces a stage, or puts run conditions on its set,
    /// asks for [`ClothExecution::Staged`].
    #[default]
    Automatic,
    /// Each cloth takes all its substeps in one go, cloths in parallel. [`ClothSubstep`] is not
    /// run.
    Fused,
    /// [`ClothSubstep`] runs once a substep, cloths one after the other.
    Staged,
}

/// How this tick runs.
#[derive(Resource, Default)]
pub(crate) struct Runner {
    staged: bool,
    /// Substeps of the cloth with most.
    rounds: u32,
}

/// Whether this tick runs stage by stage.
pub(crate) fn is_staged(runner: Res<Runner>) -> bool {
    runner.staged
}

/// The step of this run, by the schedule's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Fixed,
    /// Time stands still, or there is no clock.
    None,
    Variable,
}

fn step(time: Option<Res<Time>>, fixed: Option<Res<Time<Fixed>>>) -> Step {
    match (time, fixed) {
        (Some(time), _) if time.delta().is_zero() => Step::None,
        // In the fixed main loop, and nowhere else, the generic clock is the fixed one.
        (Some(time), Some(fixed))
            if time.delta() == fixed.delta() && time.elapsed() == fixed.elapsed() =>
        {
            Step::Fixed
        }
        (Some(_), _) => Step::Variable,
        (None, _) => Step::None,
    }
}

/// Whether the schedule runs at the fixed step.
pub(crate) fn in_fixed_step(time: Option<Res<Time>>, fixed: Option<Res<Time<Fixed>>>) -> bool {
    step(time, fixed) == Step::Fixed
}

/// Whether the schedule runs at some other step.
pub(crate) fn in_variable_step(time: Option<Res<Time>>, fixed: Option<Res<Time<Fixed>>>) -> bool {
    step(time, fixed) == Step::Variable
}

/// Verlet integration and a changing step do not go together.
pub(crate) fn refuse_variable_step(
    cloths: Query<Entity, With<ClothSimulation>>,
    mut failures: Failures,
) {
    for entity in &cloths {
        failures.report(entity, ClothErrorKind::VariableStep);
    }
}

/// Notes, before a frame's ticks, where everything is that may move once a frame.
pub(crate) fn note_poses(
    mut colliders: Query<Found>,
    mut cloths: Query<&mut ClothSimulation>,
    mut moves: Moves,
    transforms: TransformHelper,
    joints: Joints,
    mut clock: ResMut<FrameClock>,
    mut jumps: Local<Vec<RigidMotion>>,
    fixed: Option<Res<Time<Fixed>>>,
    time: Option<Res<Time<Virtual>>>,
) {
    let (Some(fixed), Some(time)) = (fixed, time) else {
        return;
    };
    let ticks = clock.begin_frame(time.delta(), fixed.timestep(), fixed.overstep());
    jumps.clear();
    for mut cloth in &mut cloths {
        if cloth.is_culled() {
            continue;
        }
        let ClothSimulation { held, skin, frame, .. } = &mut *cloth;
        let jump = note_anchors(&mut held.attachments, frame, (&transforms, &joints), ticks);
        if let Some(skin) = skin {
            skin.begin_frame(&joints, ticks, frame.is_put_elsewhere() || jump.is_some());
        }
        jumps.extend(jump);
    }
    note_colliders(&mut colliders, &mut moves, &transforms, ticks, &jumps);
}

/// Decides between the two forms.
pub(crate) fn choose_execution(world: &mut World) {
    let staged = match world.get_resource().copied().unwrap_or_default() {
        ClothExecution::Fused => false,
        ClothExecution::Staged => true,
        ClothExecution::Automatic => others_take_part(world),
    };
    world.resource_mut::<Runner>().staged = staged;
}

/// Whether [`ClothSubstep`] holds more than the four stages.
fn others_take_part(world: &mut World) -> bool {
    const STAGES: usize = 4;
    let count = world.try_schedule_scope(ClothSubstep, |world, schedule| {
        // The number means nothing before the schedule is built. A schedule that cannot be built is
        // run, so that Bevy says why.
        let built = schedule.initialize(world).is_ok();
        if built { schedule.systems_len() } else { usize::MAX }
    });
    count.is_ok_and(|count| count != STAGES)
}

/// The surroundings that all cloths share in a tick.
#[derive(SystemParam)]
pub(crate) struct Surroundings<'w, 's> {
    snapshot: Res<'w, TickColliders>,
    fields: Option<Res<'w, Assets<DistanceField>>>,
    room: Local<'s, ColliderRoom>,
}

impl Surroundings<'_, '_> {
    /// Calls `act` with the tick's colliders, without allocating once there is room for them.
    fn with_colliders(&mut self, act: impl FnOnce(&[Collider])) {
        let room = core::mem::take(&mut *self.room);
        let colliders = self.snapshot.colliders(self.fields.as_deref(), room);
        act(&colliders);
        *self.room = ColliderRoom::keep(colliders);
    }
}

/// Takes the tick's length, and the gravity of each cloth.
pub(crate) fn gather_step(
    mut cloths: Query<(&mut ClothSimulation, Option<&ClothGravityOverride>)>,
    gravity: Option<Res<ClothGravity>>,
    time: Res<Time>,
) {
    let gravity = gravity.as_deref().copied().unwrap_or_default();
    for (mut cloth, own) in &mut cloths {
        let gravity = own.map_or(gravity.0, |own| own.0);
        cloth.tick.step = ClothStep { dt: time.delta_secs(), gravity, ..default() };
    }
}

/// A cloth in its substeps, and its times where they are asked for.
type Stepped = (Entity, &'static mut ClothSimulation, Option<&'static mut StageTimes>);

/// The fused form: all cloths in parallel, each all its substeps.
pub(crate) fn solve_fused(
    mut cloths: Query<Stepped>,
    mut surroundings: Surroundings,
    mut islands: ResMut<Islands>,
    zones: Res<WindZones>,
) {
    if !cloths.iter().any(|(_, cloth, _)| cloth.tick.step.runs) {
        return;
    }
    surroundings.with_colliders(|colliders| {
        cloths.par_iter_mut().for_each(|(_, mut cloth, times)| {
            let ClothSimulation { solver, frame, tick, .. } = &mut *cloth;
            let TickState { step, motions, room, outcome } = tick;
            if step.runs && step.island.is_none() {
                *outcome = Some(frame.with_colliders(room, colliders, |colliders| {
                    let input = input(*step, motions, colliders, zones.get());
                    stage_times::tick(times, solver, &input)
                }));
                frame.end_ride(solver, outcome);
            }
        });
        islands.tick(&mut cloths, colliders, zones.get());
    });
}

/// The staged form: begins the tick of every cloth.
pub(crate) fn begin_staged(
    mut cloths: Query<Stepped>,
    mut surroundings: Surroundings,
    mut islands: ResMut<Islands>,
    zones: Res<WindZones>,
    mut runner: ResMut<Runner>,
) {
    runner.rounds = 0;
    surroundings.with_colliders(|colliders| {
        for (_, mut cloth, _) in &mut cloths {
            let ClothSimulation { solver, frame, tick, .. } = &mut *cloth;
            let TickState { step, motions, room, outcome } = tick;
            if !step.runs || step.island.is_some() {
                continue;
            }
            let begun = frame.with_colliders(room, colliders, |colliders| {
                solver.begin_tick(&input(*step, motions, colliders, zones.get()))
            });
            match begun {
                Ok(substeps) => step.rounds = substeps,
                Err(error) => *outcome = Some(Err(error)),
            }
            runner.rounds = runner.rounds.max(step.rounds);
        }
        let rounds = islands.begin(&mut cloths, colliders, zones.get());
        runner.rounds = runner.rounds.max(rounds);
    });
}

/// Runs as many substeps as the cloth with most needs; a cloth with fewer sits the rest out.
pub(crate) fn run_substeps(world: &mut World) {
    let rounds = world.resource::<Runner>().rounds;
    // The plugin has added the schedule; without it there is nothing to run.
    let _ = world.try_schedule_scope(ClothSubstep, |world, schedule| {
        for _ in 0..rounds {
            schedule.run(world);
        }
    });
}

/// Stage 1: springs, bending, damping, gravity, air.
pub(crate) fn accumulate_forces(mut cloths: Query<Stepped>) {
    let stage = ClothSubstepSystems::Forces;
    for_each_stepping(&mut cloths, stage, |_| true, ClothSolver::accumulate_forces);
}

/// Stage 2: Verlet; pins go their way.
pub(crate) fn integrate(mut cloths: Query<Stepped>) {
    let stage = ClothSubstepSystems::Integrate;
    for_each_stepping(&mut cloths, stage, |_| true, ClothSolver::integrate);
}

/// Stage 3: threads or Provot's correction, tethers.
pub(crate) fn correct(mut cloths: Query<Stepped>, mut islands: ResMut<Islands>) {
    let is_alone = |step: &ClothStep| step.island.is_none();
    let stage = ClothSubstepSystems::Correct;
    for_each_stepping(&mut cloths, stage, is_alone, |solver, _| solver.correct());
    islands.correct(&mut cloths);
}

fn for_each_stepping(
    cloths: &mut Query<Stepped>,
    stage: ClothSubstepSystems,
    takes_part: impl Fn(&ClothStep) -> bool,
    act: impl Fn(&mut ClothSolver, &StepInput),
) {
    for (_, mut cloth, times) in cloths {
        let ClothSimulation { solver, tick, .. } = &mut *cloth;
        if tick.step.rounds > 0 && takes_part(&tick.step) {
            let input = input(tick.step, &tick.motions, &[], &[]);
            stage_times::stage(times, stage, || act(solver, &input));
        }
    }
}

/// Stage 4: out of the colliders, friction. Ends the substep.
pub(crate) fn collide(mut cloths: Query<Stepped>, mut surroundings: Surroundings) {
    surroundings.with_colliders(|colliders| {
        for (_, mut cloth, times) in &mut cloths {
            let ClothSimulation { solver, frame, tick, .. } = &mut *cloth;
            let TickState { step, motions, room, outcome } = tick;
            if step.rounds > 0 {
                frame.with_colliders(room, colliders, |colliders| {
                    let input = input(*step, motions, colliders, &[]);
                    let stage = ClothSubstepSystems::Collide;
                    stage_times::stage(times, stage, || solver.collide(&input));
                });
                step.rounds -= 1;
                if step.rounds == 0 {
                    *outcome = Some(solver.end_tick());
                    frame.end_ride(solver, outcome);
                }
            }
        }
    });
}

/// Looks at how the tick went.
pub(crate) fn finish_tick(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    mut failures: Failures,
    // After the failures, so that these are there when it is told.
    mut commands: Commands,
) {
    for (entity, mut cloth) in &mut cloths {
        match cloth.tick.outcome.take() {
            Some(Ok(report)) => {
                let ClothSimulation { solver, sleep, tick, progress, shape_version, .. } =
                    &mut *cloth;
                progress.note(report);
                *shape_version += u64::from(solver.has_moved());
                sleep.note_tick(solver, tick.step.dt);
                failures.clear(entity, Blame::Motion);
                failures.clear(entity, Blame::Schedule);
            }
            Some(Err(problem)) => {
                // Bad input leaves the cloth where it is, until the input is good again.
                cloth.progress.quarantined = problem == SolverError::Diverged;
                // Its pins may be led away meanwhile.
                cloth.take_hold_anew();
                failures.report(entity, solver_error(problem));
                if cloth.progress.quarantined {
                    commands.trigger(ClothDiverged { entity, problem });
                }
            }
            None => {}
        }
    }
}
