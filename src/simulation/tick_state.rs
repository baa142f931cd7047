//! A cloth's tick: its surroundings, and what came of it.

use bevy::prelude::*;

use crate::cloth::wind::ClothWind;
use crate::collider::tick_colliders::ColliderRoom;
use crate::solver::{
    Collider, PinMotion, PinPull, SkinMotion, SolverError, StepInput, TickReport, Zone,
};

/// This tick of a cloth, from gathering its input until its result is looked at.
#[derive(Default)]
pub(crate) struct TickState {
    pub(crate) step: ClothStep,
    pub(crate) motions: Motions,
    /// Memory for the colliders as the cloth meets them.
    pub(crate) room: ColliderRoom,
    /// The tick's result, until it is looked at.
    pub(crate) outcome: Option<Result<TickReport, SolverError>>,
}

/// The motions of a tick that lead particles.
#[derive(Default)]
pub(crate) struct Motions {
    /// Of each held particle, hard pins first.
    pub(crate) pins: Vec<PinMotion>,
    /// Those of the hard ones that pull at bodies.
    pub(crate) pulls: Vec<PinPull>,
    /// Of each particle's place on the skin, where the cloth has one.
    pub(crate) skin: Vec<SkinMotion>,
}

impl TickState {
    /// How far any particle is led in the tick, at most \[m\].
    pub fn way_of_pins(&self) -> f32 {
        let ways = self.motions.pins.iter().map(|motion| motion.start.distance_squared(motion.end));
        ways.fold(0.0, f32::max).sqrt()
    }

    /// Whether the tick was taken, until its result has been looked at.
    pub fn ran(&self) -> bool {
        matches!(self.outcome, Some(Ok(_)))
    }
}

/// The surroundings of a cloth, fixed for a tick.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClothStep {
    pub(crate) dt: f32,
    pub(crate) gravity: Vec3,
    pub(crate) wind: ClothWind,
    /// Drag beside the material's, as it hardly moves \[1/s\].
    pub(crate) braking: f32,
    /// The time that its gusts are of \[s\].
    pub(crate) time: f64,
    /// Substeps still to go, in the staged form.
    pub(crate) rounds: u32,
    /// The cloth takes this tick.
    pub(crate) runs: bool,
    /// It did not take the last one.
    pub(crate) begins: bool,
    /// The island that it is stepped in, where another cloth is near that it collides with.
    pub(crate) island: Option<u32>,
}

impl ClothStep {
    /// Takes the wind at a time \[s\].
    pub fn set_wind(&mut self, wind: ClothWind, time: f64) {
        (self.wind, self.time) = (wind, time);
    }
}

/// The solver's input. A function of fields, so that the result beside them can be written.
pub(crate) fn input<'a>(
    step: ClothStep,
    motions: &'a Motions,
    colliders: &'a [Collider<'a>],
    zones: &'a [Zone],
) -> StepInput<'a> {
    let wind = step.wind.at(step.time, zones);
    StepInput {
        dt: step.dt,
        gravity: step.gravity,
        pins: &motions.pins,
        pulls: &motions.pulls,
        skin: &motions.skin,
        colliders,
        wind,
        braking: step.braking,
    }
}
