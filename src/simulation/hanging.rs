//! Cloths that start hung from their pins, at rest: Weil's shape at once, the relaxation off the main
//! thread.

use bevy::prelude::*;
use bevy::tasks::futures_lite::future::poll_once;
use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, block_on};

use crate::cloth::gravity::{ClothGravity, ClothGravityOverride};
use crate::cloth::hang_on_start::{HangOnStart, HangingPlaces};
use crate::cloth::pins::ClothPins;
use crate::error::failures::{Blame, Failures};
use crate::error::problems::HangProblem;
use crate::error::{ClothComponent, ClothErrorKind};
use crate::hang::{HangingPoint, RelaxReport, Relaxation, hang, relax};
use crate::pose::{to_local, to_world};
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::{Anchor, Attached};
use crate::solver::{ClothSolver, PinMotion, Pose, SolverError, StepInput};

/// A cloth at rest, and how it came there.
type Relaxed = Result<(Box<ClothSolver>, RelaxReport), SolverError>;

/// A cloth that is to be hung, or has been.
pub(crate) struct Hanging {
    /// The request that it is hung by.
    asked: Asked,
    pins: ClothPins,
    /// Where it was when the relaxation started.
    from: Option<Pose>,
    /// The relaxation under way.
    task: Option<Task<Relaxed>>,
    /// The cloth's first tick has come, and waits for the result.
    begun: bool,
    report: Option<RelaxReport>,
}

/// All that a hung shape depends on, but for the cloth itself.
#[derive(Clone, Debug, PartialEq)]
struct Asked {
    hung: HangOnStart,
    points: Vec<HangingPoint>,
    gravity: Vec3,
    dt: f32,
}

impl Hanging {
    /// Whether the cloth has to wait.
    pub fn is_pending(&self) -> bool {
        self.task.is_some()
    }

    /// Whether the cloth's time would have started: it no longer starts anew elsewhere.
    pub fn has_begun(&self) -> bool {
        self.begun
    }

    /// The first tick has come.
    pub fn begin(&mut self) {
        self.begun = true;
    }

    pub fn report(&self) -> Option<&RelaxReport> {
        self.report.as_ref()
    }
}

/// Hangs cloths that have not started, and starts them when they are at rest.
pub(crate) fn hang_cloths(
    mut cloths: Query<(Entity, &HangOnStart, &mut ClothSimulation, Option<&ClothGravityOverride>)>,
    gravity: Option<Res<ClothGravity>>,
    fixed: Option<Res<Time<Fixed>>>,
    mut failures: Failures,
) {
    let gravity = gravity.as_deref().copied().unwrap_or_default();
    for (entity, hung, mut cloth, own) in &mut cloths {
        if cloth.progress.tick_count > 0 {
            continue;
        }
        let cloth = &mut *cloth;
        if cloth.skin.is_some() {
            failures.report(entity, hang_error(HangProblem::Worn));
            continue;
        }
        let asked = Asked {
            hung: *hung,
            points: hanging_points(cloth, entity, hung.places),
            gravity: own.map_or(gravity.0, |own| own.0),
            dt: fixed.as_ref().map_or(1.0 / 64.0, |fixed| fixed.timestep().as_secs_f32()),
        };
        if is_new(cloth.start.hanging.as_deref(), &asked, &cloth.in_force.pins) {
            let outcome = lay(cloth, entity, asked);
            tell(entity, outcome, cloth, &mut failures);
        }
        if let Some(result) = finished(cloth) {
            let outcome = result.and_then(|(solver, report)| settle(cloth, &solver, report));
            tell(entity, outcome.map_err(hang_error), cloth, &mut failures);
        }
    }
}

/// Whether a cloth is to be hung otherwise than it is. One whose time has come is carried along with its
/// anchors instead, unless it has other pins.
fn is_new(hanging: Option<&Hanging>, asked: &Asked, pins: &ClothPins) -> bool {
    hanging.is_none_or(
        |hanging| {
            if hanging.begun { hanging.pins != *pins } else { hanging.asked != *asked }
        },
    )
}

fn hang_error(problem: impl Into<HangProblem>) -> ClothErrorKind {
    ClothErrorKind::Hang(problem.into())
}

/// Tells how it went. Where it did not, the cloth is in its rest shape.
fn tell(
    entity: Entity,
    outcome: Result<(), ClothErrorKind>,
    cloth: &mut ClothSimulation,
    failures: &mut Failures,
) {
    match outcome {
        Ok(()) => failures.clear(entity, Blame::Component(ClothComponent::HangOnStart)),
        Err(error) => {
            let rest: Vec<_> = (0..cloth.particle_count()).map(|i| rest_place(cloth, i)).collect();
            put(cloth, entity, &rest);
            failures.report(entity, error);
        }
    }
}

/// The particles that are held, hard ones first, and where each hangs.
fn hanging_points(
    cloth: &ClothSimulation,
    entity: Entity,
    places: HangingPlaces,
) -> Vec<HangingPoint> {
    let attachments = &cloth.held.attachments;
    let held: Vec<&Attached> = attachments.held().collect();
    let anchor_of = |at: &Attached| &attachments.anchors[at.anchor as usize];
    let shifts: Vec<Vec3> = (0..attachments.anchors.len())
        .map(|index| {
            let anchor = &attachments.anchors[index];
            let theirs = || held.iter().filter(|at| at.anchor as usize == index);
            let rest = theirs().map(|at| rest_place(cloth, at.particle as usize));
            let count = theirs().count();
            if places == HangingPlaces::Rest || anchor.entity == entity || count == 0 {
                return Vec3::ZERO;
            }
            anchor.pose.end().translation - rest.sum::<Vec3>() / count as f32
        })
        .collect();
    let point = |at: &&Attached| {
        let rest = rest_place(cloth, at.particle as usize);
        let alone = held.iter().filter(|other| other.anchor == at.anchor).count() == 1;
        let shift = shifts[at.anchor as usize];
        let place = match (alone, shift == Vec3::ZERO) {
            (_, true) => rest,
            // Without the rounding of the way there.
            (true, false) => anchor_of(at).pose.end().translation,
            (false, false) => rest + shift,
        };
        HangingPoint { particle: at.particle, place }
    };
    held.iter().map(point).collect()
}

/// Where a particle is in the world while the cloth is in its rest shape \[m\].
fn rest_place(cloth: &ClothSimulation, particle: usize) -> Vec3 {
    let unscaled = Pose { scale: 1.0, ..cloth.in_force.placed };
    to_world(&unscaled, cloth.rest_positions()[particle])
}

/// Puts a cloth into its hung shape and starts the relaxation.
fn lay(cloth: &mut ClothSimulation, entity: Entity, asked: Asked) -> Result<(), ClothErrorKind> {
    let begun = cloth.start.has_begun();
    let (hung, dt, gravity) = (asked.hung, asked.dt, asked.gravity);
    let motions: Vec<_> = asked.points.iter().map(|p| PinMotion::still(p.place)).collect();
    let rest: Vec<_> = (0..cloth.particle_count()).map(|i| rest_place(cloth, i)).collect();
    let strain = cloth.in_force.material.max_strain;
    let positions = hang(cloth.topology(), &rest, &asked.points, strain, gravity);
    cloth.start.hanging = Some(Box::new(Hanging {
        asked,
        pins: cloth.in_force.pins.clone(),
        from: reference_pose(cloth),
        task: None,
        begun,
        report: None,
    }));
    let component = ClothComponent::HangOnStart;
    hung.validate().map_err(|problem| ClothErrorKind::Parameter { component, problem })?;
    put(cloth, entity, &positions.map_err(hang_error)?);
    let mut solver = cloth.solver.clone();
    let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn(async move {
        let limits = Relaxation { speed: hung.speed, longest: hung.longest };
        let input = StepInput { dt, gravity, pins: &motions, ..default() };
        let report = relax(&mut solver, &input, limits)?;
        Ok((Box::new(solver), report))
    });
    if let Some(hanging) = &mut cloth.start.hanging {
        hanging.task = Some(task);
    }
    Ok(())
}

/// Pose of what leads the cloth, at the last tick's end.
fn reference_pose(cloth: &ClothSimulation) -> Option<Pose> {
    let reference = cloth.held.attachments.reference()?;
    Some(cloth.held.attachments.anchors[reference].pose.end())
}

/// Puts all particles somewhere, at rest. What holds some of them holds them there.
fn put(cloth: &mut ClothSimulation, entity: Entity, positions: &[Vec3]) {
    // Places of a cloth that is near enough to be simulated are so too, or the next tick says why not.
    let _ = cloth.solver.place(positions);
    let local = |anchor: &Anchor, at: &Attached| {
        to_local(&anchor.pose.end(), positions[at.particle as usize])
    };
    cloth
        .held
        .attachments
        .hold_at(|anchor, at| if anchor.entity == entity { at.local } else { local(anchor, at) });
    cloth.shape_version += 1;
}

/// The result of the relaxation, once it is there.
fn finished(cloth: &mut ClothSimulation) -> Option<Relaxed> {
    let hanging = cloth.start.hanging.as_mut()?;
    let result = block_on(poll_once(hanging.task.as_mut()?))?;
    hanging.task = None;
    Some(result)
}

/// Puts the cloth into its shape at rest, where its anchors have led it meanwhile.
fn settle(
    cloth: &mut ClothSimulation,
    relaxed: &ClothSolver,
    report: RelaxReport,
) -> Result<(), SolverError> {
    let now = reference_pose(cloth);
    cloth.solver.place_as(relaxed)?;
    cloth.shape_version += 1;
    let Some(hanging) = &mut cloth.start.hanging else { return Ok(()) };
    hanging.report = Some(report);
    match (hanging.from, now) {
        (Some(from), Some(now)) if from != now => cloth.solver.carry(&from, &now),
        _ => Ok(()),
    }
}

/// A cloth that is to be hung no longer starts from where it is.
pub(crate) fn cancel_hanging(
    removed: On<Remove, HangOnStart>,
    mut cloths: Query<&mut ClothSimulation>,
    mut failures: Failures,
) {
    if let Ok(mut cloth) = cloths.get_mut(removed.entity)
        && let Some(hanging) = &mut cloth.start.hanging
    {
        hanging.task = None;
    }
    failures.clear(removed.entity, Blame::Component(ClothComponent::HangOnStart));
}
