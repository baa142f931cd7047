//! Particles that something leads: a hand, a hook.

use bevy::prelude::*;

use crate::error::problems::GrabProblem;
use crate::solver::{ParameterError, SoftPin};

/// Pulls a cloth towards a place, for as long as it is on the entity: what a mouse, a hand or a hook does.
/// Removing it lets go.
///
/// The particles are chosen when it comes and when [`hold`](ClothGrab::hold) changes, and keep their places
/// around their middle, which is drawn to the target. The target may be moved in the fixed schedule or once
/// a frame. What a pin holds, the pin keeps.
///
/// One that cannot be used is told as a [`ClothErrorKind::Grab`](crate::ClothErrorKind::Grab), and holds nothing.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothGrab;
/// fn pull(mut commands: Commands, cloth: Single<(Entity, &ClothSimulation)>) {
///     let (entity, simulation) = *cloth;
///     if let Some(place) = simulation.position(0) {
///         let target = place + Vec3::Y;
///         commands.entity(entity).insert(ClothGrab::particle(0, target));
///     }
/// }
/// # bevy::ecs::system::assert_is_system(pull);
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Debug, PartialEq, Clone)]
pub struct ClothGrab {
    /// The particles that are grabbed.
    pub hold: GrabHold,
    /// Where the middle of what is grabbed is drawn, in world space \[m\].
    pub target: Vec3,
    /// Constant of the spring \[N/m\], above 0, shared by all that is grabbed. Higher follows closer.
    pub stiffness: f32,
    /// Constant of the damper beside it \[N s/m\]. Higher swings less.
    pub damping: f32,
    /// Force that it does not exceed \[N\], above 0. Higher pulls harder, and drags what is pinned longer;
    /// infinite is no limit.
    pub max_force: f32,
}

/// The particles that a [`ClothGrab`] grabs.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub enum GrabHold {
    /// One particle.
    Particle(u32),
    /// All that is within a ball as it is grabbed.
    Within {
        /// The ball's middle, in world space \[m\].
        centre: Vec3,
        /// Its radius \[m\], above 0. Larger grabs more.
        radius: f32,
    },
}

impl ClothGrab {
    /// Grabs one particle.
    pub fn particle(particle: u32, target: Vec3) -> Self {
        Self::new(GrabHold::Particle(particle), target)
    }

    /// Grabs what is within a ball in world space \[m\].
    pub fn within(centre: Vec3, radius: f32, target: Vec3) -> Self {
        Self::new(GrabHold::Within { centre, radius }, target)
    }

    /// 200 N/m, 1 N s/m, and 20 N at most: what a hand does to a garment.
    fn new(hold: GrabHold, target: Vec3) -> Self {
        Self { hold, target, stiffness: 200.0, damping: 1.0, max_force: 20.0 }
    }

    pub(crate) fn validate(&self) -> Result<(), GrabProblem> {
        SoftPin::check(self.stiffness, self.damping)?;
        if self.max_force.is_nan() || self.max_force <= 0.0 {
            let range = "above 0 N";
            let value = self.max_force;
            return Err(ParameterError { name: "max_force", value, range }.into());
        }
        let is_near = |p: Vec3| p.is_finite() && p.abs().max_element() <= 1e7;
        if !is_near(self.target) {
            return Err(GrabProblem::Place("target"));
        }
        if let GrabHold::Within { centre, radius } = self.hold {
            if !is_near(centre) {
                return Err(GrabProblem::Place("centre"));
            }
            if !(radius > 0.0 && radius <= 1e7) {
                let range = "above 0 and at most 1e7 m";
                return Err(ParameterError { name: "radius", value: radius, range }.into());
            }
        }
        Ok(())
    }

    /// Whether only the target is another.
    pub(crate) fn pulls_as(&self, other: &Self) -> bool {
        Self { target: other.target, ..*self } == *other
    }
}
