//! Pushing a cloth from a game: forces that go on, and pushes of one tick.

use bevy::prelude::*;

use crate::cloth::forces::{ClothForce, ClothForces, PushCloth};
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::simulation::ClothSimulation;
use crate::simulation::reference_frame::ReferenceFrame;
use crate::solver::{ClothSolver, PushOn, PushWith, SolverError};

/// Passes a push on to the running cloth.
pub(crate) fn ask_for_push(
    event: On<PushCloth>,
    mut cloths: Query<&mut ClothSimulation>,
    mut failures: Failures,
) {
    let PushCloth { entity, on, with } = *event;
    match cloths.get_mut(entity).map(|mut cloth| cloth.push(on, with)) {
        Ok(Ok(())) => failures.clear(entity, Blame::Push),
        Ok(Err(problem)) => failures.report(entity, ClothErrorKind::Push(problem)),
        Err(_) => tracing::warn!(
            "entity {entity} has no running cloth, so the push was ignored; wait for its `ClothReady`"
        ),
    }
}

/// Pushes that a cloth was asked for.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pushing {
    /// Pushes since the last tick, in their order.
    pub asked: Vec<(PushOn, PushWith)>,
    /// The forces that went on in the last tick.
    pub forces: Vec<ClothForce>,
}

impl Pushing {
    /// Takes over the forces that go on; tells whether they are others than before.
    pub fn set_forces(&mut self, forces: Option<&ClothForces>) -> bool {
        let forces = forces.map_or(&[][..], |forces| &forces.forces);
        let changed = self.forces != forces;
        if changed {
            self.forces.clear();
            self.forces.extend_from_slice(forces);
        }
        changed
    }

    /// Forgets what was asked for, as the cloth stands.
    pub fn forget(&mut self) {
        self.asked.clear();
    }

    /// Gives the solver what pushes in this tick.
    pub fn push(
        &mut self,
        entity: Entity,
        solver: &mut ClothSolver,
        frame: &ReferenceFrame,
        failures: &mut Failures,
    ) {
        // In the ride, directions are those that are seen from it.
        let mut give = |on, with: PushWith| solver.push(on, with.map(|vector| frame.seen(vector)));
        for (on, with) in self.asked.drain(..) {
            if let Err(problem) = give(on, with) {
                failures.report(entity, ClothErrorKind::Push(problem));
            }
        }
        // The first bad one is told of, and no other.
        let mut good = true;
        for (force, &ClothForce { on, force: vector }) in self.forces.iter().enumerate() {
            if let Err(problem) = give(on, PushWith::Force(vector))
                && core::mem::take(&mut good)
            {
                failures.report(entity, ClothErrorKind::Forces { force, problem });
            }
        }
        if good {
            failures.clear(entity, Blame::Forces);
        }
    }
}

impl ClothSimulation {
    /// Pushes particles in the next tick, once: by a force through that tick, or by an impulse or a change of
    /// velocity at its start. Pushes add up, and wake the cloth. What is pinned does not move.
    ///
    /// May be called from any system. From one that runs once a frame, give impulses or velocities: a force
    /// that is to go on is a [`ClothForces`], at any frame rate. A cloth that takes no step in the next tick
    /// (see [`ClothPaused`](crate::ClothPaused)) is not pushed, nor later.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`], [`SolverError::Parameter`] for a radius or falloff that is out of its
    /// range, [`SolverError::Push`] for what is not finite or too large; nothing is pushed then.
    pub fn push(&mut self, on: PushOn, with: PushWith) -> Result<(), SolverError> {
        self.solver.check_push(on, with)?;
        if matches!(with, PushWith::Force(_)) {
            self.solver.make_room_for_forces();
        }
        self.pushing.asked.push((on, with));
        self.wake();
        Ok(())
    }
}
