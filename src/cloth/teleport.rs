//! Teleports and resets, and cloths that ride along.

use core::f32::consts::FRAC_PI_3;

use bevy::prelude::*;

use crate::solver::ParameterError;

/// Motion in one tick beyond which an entity counts as teleported, so that its cloth is carried along.
/// A cloth without this component has the default.
///
/// The cloth's own entity leads it, or the first anchor where only anchors hold it. Whatever else holds the
/// cloth has to jump with it. The cloth keeps its shape and its motion, turned with what leads it.
/// Colliders that come along, however far, do not sweep through it. See [`TeleportCloth`] for shorter jumps.
///
/// For an entity moved once a frame, the whole frame's motion is tested: `distance` is multiplied by the
/// frame's ticks (1 to 4), `angle` is not. A jump of 2 to 8 m may be a motion in a long frame: trigger [`TeleportCloth`] where it is none.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothTeleport {
    /// Distance moved in a tick beyond which it is a jump \[m\]. Higher lets faster things drag their cloth;
    /// infinite is never. The default of 2 m is 128 m/s at 64 ticks a second.
    pub distance: f32,
    /// Rotation in a tick beyond which it is a jump \[rad\]. Higher lets faster turns swing their cloth;
    /// infinite is never. The default is 60 degrees.
    pub angle: f32,
}

impl Default for ClothTeleport {
    fn default() -> Self {
        Self { distance: 2.0, angle: FRAC_PI_3 }
    }
}

impl ClothTeleport {
    /// No motion is a jump.
    pub const NEVER: Self = Self { distance: f32::INFINITY, angle: f32::INFINITY };

    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        if self.distance.is_nan() || self.distance <= 0.0 {
            let range = "above 0 m";
            return Err(ParameterError { name: "distance", value: self.distance, range });
        }
        if self.angle.is_nan() || self.angle < 0.01 {
            let range = "at least 0.01 rad";
            return Err(ParameterError { name: "angle", value: self.angle, range });
        }
        Ok(())
    }
}

/// How much of its entity's motion a cloth feels. Without this component it feels all of it.
///
/// At 1 the cloth is a thing of the world: an entity that moves drags it by its pins, or leaves it
/// behind. At 0 it rides along, as in a closed car, and only motion relative to the entity (pins that
/// follow an animation, colliders, gravity, wind) moves it. Between, that part of the motion is felt: a
/// cape on a fast runner wants some 0.3. Where anchors alone hold the cloth, the motion is that of the
/// first.
///
/// The wind that it feels is that in the world, less the part of the motion that it does not feel.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothInertia {
    /// Part of the entity's shifts that is felt, from 0 to 1 \[1\]. Higher lags behind more.
    pub linear: f32,
    /// Part of its turns that is felt, from 0 to 1 \[1\]. Higher lags behind more.
    pub angular: f32,
}

impl Default for ClothInertia {
    fn default() -> Self {
        Self { linear: 1.0, angular: 1.0 }
    }
}

impl ClothInertia {
    /// Inherits the same part of shifts and of turns.
    pub fn new(part: f32) -> Self {
        Self { linear: part, angular: part }
    }

    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        for (name, value) in [("linear", self.linear), ("angular", self.angular)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(ParameterError { name, value, range: "from 0 to 1" });
            }
        }
        Ok(())
    }
}

/// Moves the cloth with its entity and anchors at the next tick, however short the jump: the explicit form of [`ClothTeleport`].
///
/// Trigger it before the next fixed tick after the entity was moved. Once a tick has run, the cloth has been pulled along already;
/// [`ResetCloth`] then puts it where it belongs.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// fn step_aside(mut commands: Commands, mut cloth: Single<(Entity, &mut Transform), With<Cloth>>) {
///     cloth.1.translation.x += 1.0;
///     commands.trigger(TeleportCloth { entity: cloth.0 });
/// }
/// # bevy::ecs::system::assert_is_system(step_aside);
/// ```
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TeleportCloth {
    /// The cloth.
    pub entity: Entity,
}

/// Puts the cloth back to its rest shape, where its entity (or the anchor that leads it) is at the next
/// tick, at rest. One that had diverged goes on.
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResetCloth {
    /// The cloth.
    pub entity: Entity,
}
