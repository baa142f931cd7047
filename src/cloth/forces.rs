//! Pushing a cloth from a game: forces that go on, and pushes of one tick.

use bevy::prelude::*;

use crate::solver::{PushOn, PushWith};

/// Forces that act on a cloth in every tick, for as long as they are here: a thrust, a weight hung from a
/// corner, the stream of a hose. May be changed at any time.
///
/// It is the same in the fixed schedule and in `Update`, at any frame rate. For what happens once there
/// are [`ClothSimulation::push`](crate::ClothSimulation::push) and [`PushCloth`]; for wind there is [`ClothAir`](crate::ClothAir).
///
/// A force that cannot be used is told as a [`ClothErrorKind::Forces`](crate::ClothErrorKind::Forces) and left out; the others act.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::ClothForce;
/// # use bevy_drape::ClothForces;
/// # use bevy_drape::solver::PushOn;
/// # fn spawn(mut commands: Commands) {
/// // A weight of 50 g on one corner.
/// let weight = ClothForce { on: PushOn::Particle(0), force: Vec3::NEG_Y * 0.05 * 9.81 };
/// commands.spawn((
///     Cloth::sheet(Vec2::ONE, UVec2::splat(32)),
///     ClothPins::from(PinSelection::LastRow),
///     ClothForces::from(weight),
/// ));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothForces {
    /// The forces. They add up.
    pub forces: Vec<ClothForce>,
}

/// A force on some particles of a cloth.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub struct ClothForce {
    /// The particles that it acts on. Those in a ball are chosen anew in each tick.
    pub on: PushOn,
    /// The force \[N\], in world axes, shared by all that it acts on. Longer pushes harder.
    pub force: Vec3,
}

impl From<ClothForce> for ClothForces {
    fn from(force: ClothForce) -> Self {
        Self { forces: vec![force] }
    }
}

/// Pushes a cloth in its next tick, once: [`ClothSimulation::push`](crate::ClothSimulation::push) from where there are only `Commands`.
///
/// A push that cannot be used is reported as a [`ClothErrorKind::Push`](crate::ClothErrorKind::Push).
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::PushCloth;
/// # use bevy_drape::solver::PushOn;
/// # use bevy_drape::solver::PushWith;
/// fn explode(mut commands: Commands, cloths: Query<Entity, With<Cloth>>) {
///     for entity in &cloths {
///         let on = PushOn::Within { centre: Vec3::ZERO, radius: 2.0, falloff: 1.0 };
///         commands.trigger(PushCloth { entity, on, with: PushWith::Velocity(Vec3::Y * 5.0) });
///     }
/// }
/// # bevy::ecs::system::assert_is_system(explode);
/// ```
#[derive(EntityEvent, Clone, Copy, Debug, PartialEq)]
pub struct PushCloth {
    /// The cloth.
    pub entity: Entity,
    /// The particles.
    pub on: PushOn,
    /// The force, impulse or change of velocity.
    pub with: PushWith,
}
