//! Soft pins: particles on springs and dampers to targets that move.
//!
//! Their forces are those at the substep's end, so that no stiffness is too high for a substep. A
//! particle that is pulled so answers a further force as one that weighs more by `k h^2 + c h`:
//! corrections see it with that mass, so that threads and soft pins are solved together, not one after
//! the other. A body at the other end gives way, and the particle weighs less than beside a wall: mobilities
//! of springs in series add up.

use bevy_math::Vec3;

use crate::solver::settings::ParameterError;

/// A particle on a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SoftPin {
    /// The particle.
    pub particle: u32,
    /// Constant of the spring \[N/m\].
    pub stiffness: f32,
    /// Constant of the damper beside it \[N s/m\]. The substep itself damps as `stiffness` times its
    /// length does; less than that is not to be had.
    pub damping: f32,
}

impl SoftPin {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`ParameterError`] for a number that is not finite or out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        Self::check(self.stiffness, self.damping)
    }

    /// Checks the numbers of a spring \[N/m\] and its damper \[N s/m\].
    ///
    /// # Errors
    /// [`ParameterError`] for a number that is not finite or out of its range.
    pub fn check(stiffness: f32, damping: f32) -> Result<(), ParameterError> {
        if !(stiffness > 0.0 && stiffness <= 1e9) {
            let range = "above 0 and at most 1e9 N/m";
            return Err(ParameterError { name: "stiffness", value: stiffness, range });
        }
        if !(0.0..=1e9).contains(&damping) {
            let range = "from 0 to 1e9 N s/m";
            return Err(ParameterError { name: "damping", value: damping, range });
        }
        Ok(())
    }
}

/// A soft pin at work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring {
    pub pin: SoftPin,
    pub slot: usize,
    /// Force that it does not exceed \[N\].
    pub most_force: f32,
    /// The spring pulls as hard as it may in this substep: a particle further off feels no more of it.
    pub slack: bool,
    /// The particle's own inverse mass, while corrections see another \[1/kg\].
    pub inverse_mass: f32,
    /// The particle's displacement when the pull that it does not follow was last noted \[m\].
    pub noted: Vec3,
    /// The body that it pulls at, where the cloth moves that.
    pub body: Option<PulledBody>,
}

/// A body at the other end of a spring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PulledBody {
    /// The collider that has the account of it.
    pub collider: usize,
    /// Where the spring holds it at the substep's end \[m\].
    pub at: Vec3,
    /// How much it yields there for each time that the particle does.
    pub yields: f32,
    /// The particle's displacement when corrections begin, and what the spring has given the body up to then, times the
    /// substep \[m, kg m\].
    pub before: Vec3,
    pub given: Vec3,
}

impl PulledBody {
    /// The body of a collider, of which nothing is known yet.
    pub fn new(collider: usize) -> Self {
        let none = Vec3::ZERO;
        Self { collider, at: none, yields: 0.0, before: none, given: none }
    }
}

impl Spring {
    /// A pin that is to be at work.
    pub(crate) fn new(pin: SoftPin, slot: usize) -> Self {
        Self {
            pin,
            slot,
            most_force: f32::INFINITY,
            slack: false,
            inverse_mass: 0.0,
            noted: Vec3::ZERO,
            body: None,
        }
    }

    /// How much a body that it pulls at yields for each time that the particle does.
    pub(crate) fn yields(&self) -> f32 {
        self.body.map_or(0.0, |body| body.yields)
    }

    /// Displacement that the spring makes by each metre of its length, and the damper by each metre of
    /// relative displacement, for a displacement `response` made by a newton \[m/N\]. A damper does not slow a body down by
    /// more than there is of its motion.
    pub(crate) fn gains(&self, response: f32, h: f32) -> (f32, f32) {
        let SoftPin { stiffness, damping, .. } = self.pin;
        // Forces of the substep's end damp as a damper of k h does.
        let left = (damping / h - stiffness).max(0.0);
        let (alpha, beta) = (response * stiffness, response * left);
        (alpha, beta / (1.0 + beta * self.yields()))
    }
}

/// The displacement, or as much of it as is `longest` \[m\].
pub(crate) fn shortened(d: Vec3, longest: f32) -> Vec3 {
    let square = d.dot(d);
    if square > longest * longest { d * (longest / square.sqrt()) } else { d }
}
