//! The input of a tick, and its report.

use bevy_math::Vec3;

use crate::solver::constraints::pin_motion::PinMotion;
use crate::solver::constraints::skin::{Skin, SkinMotion, look_through};
use crate::solver::contact::Collider;
use crate::solver::error::SolverError;
use crate::solver::forces::wind::Wind;
use crate::solver::settings::{ParameterError, is_near};
use crate::solver::simd::isa::Isa;

/// The surroundings of a cloth in one tick. Positions are in world space. The default has no length, which
/// is refused.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepInput<'a> {
    /// The tick's length \[s\].
    pub dt: f32,
    /// Gravity \[m/s2\].
    pub gravity: Vec3,
    /// Motions of the pins, in the order of [`ClothSolver::pins`](crate::solver::ClothSolver::pins), then those
    /// of the targets of [`ClothSolver::soft_pins`](crate::solver::ClothSolver::soft_pins).
    pub pins: &'a [PinMotion],
    /// Places on the skin, one a particle, of a cloth that has one ([`ClothSolver::set_skin`](crate::solver::ClothSolver::set_skin));
    /// else none.
    pub skin: &'a [SkinMotion],
    /// Colliders, in an order that does not change from run to run.
    pub colliders: &'a [Collider<'a>],
    /// Pins that pull at bodies among the colliders. Others lead the cloth, and nothing leads them.
    pub pulls: &'a [PinPull],
    /// The wind. A cloth that has no [`Air`](crate::solver::Air) does not feel it.
    pub wind: Wind<'a>,
    /// Rate at which the cloth is stopped in this tick, beside its drag \[1/s\]; not below 0. A game that lets cloths sleep brakes those
    /// that hardly move.
    pub braking: f32,
}

/// A pin that pulls at the body which carries it. Its motion is that of the body as it is planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinPull {
    /// The pin's place in [`StepInput::pins`]: among the [`pins`](crate::solver::ClothSolver::pins), or after them among the
    /// [`soft_pins`](crate::solver::ClothSolver::soft_pins).
    pub pin: u32,
    /// The [`body`](Collider::body) of the collider, of which there is one. It may be in no layer, where nothing is to collide with it.
    pub body: u64,
}

/// The outcome of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct TickReport {
    /// Substeps taken.
    pub substeps: u32,
    /// Largest strain of a structural spring at the end.
    pub max_strain: f32,
    /// Contacts with colliders in the last substep.
    pub contact_count: u32,
    /// Pairs of the cloth's particles that touched each other in the last substep.
    pub self_contact_count: u32,
    /// Pairs of the cloth's particles and those of other cloths that touched each other in the last substep.
    pub inter_contact_count: u32,
}

impl StepInput<'_> {
    /// Checks the places on the skin, for a cloth that has this one.
    pub(crate) fn check_skin(&self, isa: Isa, skin: Option<&Skin>) -> Result<(), SolverError> {
        let (particles, motions) = (skin.map_or(0, |skin| skin.limits.len()), self.skin.len());
        if particles != motions {
            return Err(SolverError::WrongSkinCount { particles, motions });
        }
        let Some(skin) = skin else { return Ok(()) };
        let looked = look_through(isa, self.skin);
        if !looked.near {
            let is_far =
                |motion: &SkinMotion| !look_through(isa, core::slice::from_ref(motion)).near;
            let particle = self.skin.iter().position(is_far).unwrap_or(0);
            return Err(SolverError::NonFinite { what: "place on the skin", particle });
        }
        // What has no backstop needs no normal.
        let lacking = if looked.normal { None } else { skin.without_normal(self.skin) };
        lacking.map_or(Ok(()), |particle| Err(SolverError::NoSkinNormal(particle)))
    }

    /// Checks which pins pull, of a cloth with so many, hard and soft.
    pub(crate) fn check_pulls(&self, pins: usize) -> Result<(), SolverError> {
        match self.pulls.iter().find(|pull| pull.pin as usize >= pins) {
            Some(pull) => Err(SolverError::NoSuchPin { pin: pull.pin as usize, pins }),
            None => Ok(()),
        }
    }

    /// Checks every number, for a cloth with so many pins.
    pub(crate) fn check(&self, pins: usize) -> Result<(), SolverError> {
        if !(self.dt > 0.0 && self.dt <= 1.0) {
            return Err(SolverError::Tick(self.dt));
        }
        if !(self.braking >= 0.0 && self.braking.is_finite()) {
            let range = "at least 0 /s, and finite";
            return Err(ParameterError { name: "braking", value: self.braking, range }.into());
        }
        if !(self.gravity.is_finite() && self.gravity.abs().max_element() <= 1e6) {
            return Err(SolverError::Gravity);
        }
        let motions = self.pins.len();
        if pins != motions {
            return Err(SolverError::WrongPinCount { pins, motions });
        }
        if let Some(pin) = self.pins.iter().position(|p| !(is_near(p.start) && is_near(p.end))) {
            return Err(SolverError::PinTarget(pin));
        }
        match self.colliders.iter().position(|c| !c.is_usable()) {
            Some(collider) => Err(SolverError::Collider(collider)),
            None => Ok(()),
        }
    }
}
