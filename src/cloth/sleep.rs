//! Cloths that sleep, or are frozen.

use bevy::prelude::*;

use crate::solver::ParameterError;

/// When a cloth goes to sleep: it then costs next to nothing until something could move it. A cloth
/// without this component has the default.
///
/// It is woken by pins and anchors that move, changed pins, material, settings, self-collision or gravity, colliders
/// that move, appear, change or vanish near it, pushes, forces that change, grabs, teleports, resets, and
/// [`ClothSimulation::wake`](crate::ClothSimulation::wake). In wind a cloth with [`ClothAir`](crate::ClothAir) does not sleep. Cloth that nothing damps may swing for ever, and never sleeps.
///
/// A cloth that hardly moves is braked, so that it comes to rest sooner: while no particle goes further than `distance` in a twentieth of
/// `time`, the drag of its material counts up to five times, and 5 /s at most. One that pins or a skeleton lead is not, nor one with
/// [`ClothAir`](crate::ClothAir), nor one whose material has no drag.
///
/// Positions are compared, not speeds: a cloth that trembles on the spot is at rest, and one that turns at
/// the end of a swing is not.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothSleepThreshold {
    /// Largest change of any coordinate of a particle, since the rest timer started, that still counts as rest
    /// \[m\]. A larger change starts the timer anew. Higher sleeps sooner; 0 never. The default is 5 mm.
    pub distance: f32,
    /// Time after which a cloth that stayed at rest falls asleep \[s\]. Higher sleeps later. The default is
    /// 1 s, in which a small pendulum has been at both its ends.
    pub time: f32,
}

impl Default for ClothSleepThreshold {
    fn default() -> Self {
        Self { distance: 0.005, time: 1.0 }
    }
}

impl ClothSleepThreshold {
    /// The cloth never sleeps.
    pub const NEVER: Self = Self { distance: 0.0, time: 1.0 };

    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        if !(self.distance >= 0.0 && self.distance.is_finite()) {
            let range = "at least 0 m, and finite";
            return Err(ParameterError { name: "distance", value: self.distance, range });
        }
        if !(self.time >= 0.0 && self.time.is_finite()) {
            let range = "at least 0 s, and finite";
            return Err(ParameterError { name: "time", value: self.time, range });
        }
        Ok(())
    }
}

/// Stops a cloth for as long as it is on the entity.
///
/// The cloth keeps its shape. Its entity, or the anchor that leads it, carries it along rigidly. When the
/// component is removed the cloth goes on with the velocities that it had, turned with it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothPaused;
/// fn step_once(mut frozen: Single<&mut ClothPaused>) {
///     frozen.steps += 1;
/// }
/// # bevy::ecs::system::assert_is_system(step_once);
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothPaused {
    /// Ticks that the cloth is to take all the same; each takes one off.
    pub steps: u32,
}
