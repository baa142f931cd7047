//! The surroundings of a cloth in a tick.

use bevy::prelude::*;

use crate::cloth::wind::ClothWind;
use crate::simulation::attachments::Attachments;
use crate::solver::{Collider, StepInput, Zone};

/// The surroundings of a cloth, fixed for a tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClothStep {
    pub(crate) dt: f32,
    pub(crate) gravity: Vec3,
    pub(crate) wind: ClothWind,
    /// The time that its gusts are of \[s\].
    pub(crate) time: f64,
    /// Substeps still to go, in the staged form.
    pub(crate) rounds: u32,
    /// The cloth takes this tick.
    pub(crate) runs: bool,
}

impl ClothStep {
    /// Takes the wind at a time \[s\].
    pub fn set_wind(&mut self, wind: ClothWind, time: f64) {
        (self.wind, self.time) = (wind, time);
    }
}

/// The solver's input. A function of fields, so that the solver beside them can be borrowed.
pub(crate) fn input<'a>(
    step: ClothStep,
    attachments: &'a Attachments,
    colliders: &'a [Collider<'a>],
    zones: &'a [Zone],
) -> StepInput<'a> {
    let wind = step.wind.at(step.time, zones);
    StepInput { dt: step.dt, gravity: step.gravity, pins: &attachments.motions, colliders, wind }
}
