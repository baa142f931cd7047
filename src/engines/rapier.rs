//! Rapier's colliders.

use bevy::prelude::*;
use bevy_rapier3d::parry;
use bevy_rapier3d::prelude as engine;

use crate::engines::adapt::{add_engine, schedule_engine};
use crate::engines::engine::{Adapting, Engine, is_even};
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;

// Both engines have parry's shapes, but not of the same version.
#[allow(clippy::duplicate_mod)]
#[path = "read.rs"]
mod read;

/// Cloths collide with the colliders of Rapier: with those that have [`ClothCollider`](crate::ClothCollider), or with
/// [`all`](Self::all).
///
/// Add it beside [`ClothPlugin`](crate::ClothPlugin) and `RapierPhysicsPlugin`. By default Rapier moves bodies once a frame,
/// which is then spread over the frame's ticks, and depends on the frames. With `in_fixed_schedule` it moves them each tick,
/// before cloths are stepped.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// use bevy_rapier3d::prelude::*;
///
/// # fn build(app: &mut App) {
/// let physics = RapierPhysicsPlugin::<NoUserData>::default().in_fixed_schedule();
/// app.add_plugins((physics, ClothPlugin::default(), RapierClothPlugin::default()));
/// # }
/// fn spawn(mut commands: Commands) {
///     commands.spawn((
///         RigidBody::Dynamic,
///         Collider::ball(0.5),
///         ClothCollider::default(),
///         Transform::from_xyz(0.0, 2.0, 0.0),
///     ));
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct RapierClothPlugin {
    /// Whether colliders without `ClothCollider` are taken too.
    pub all: bool,
}

impl RapierClothPlugin {
    /// With every collider that is neither a sensor nor disabled, but for those with
    /// [`SdfColliderDisabled`](crate::SdfColliderDisabled).
    pub fn all() -> Self {
        Self { all: true }
    }
}

impl Plugin for RapierClothPlugin {
    fn build(&self, app: &mut App) {
        add_engine::<Rapier>(app, self.all);
    }

    fn finish(&self, app: &mut App) {
        schedule_engine::<Rapier>(app, engine::PhysicsSet::Writeback);
    }
}

/// Rapier.
pub(crate) struct Rapier;

impl Engine for Rapier {
    const NAME: &'static str = "Rapier";
    const SET: Adapting = Adapting::Rapier;
    const FRICTION_OF_BODY: bool = false;
    type Collider = engine::Collider;
    // Before that its shape is not yet scaled.
    type Known = engine::RapierColliderHandle;
    type Sensor = engine::Sensor;
    type ColliderDisabled = engine::ColliderDisabled;
    type Body = engine::RigidBody;
    type BodyDisabled = engine::RigidBodyDisabled;
    type Friction = engine::Friction;

    fn friction(friction: &engine::Friction) -> f32 {
        friction.coefficient
    }

    fn read(
        collider: &engine::Collider,
        reader: &mut Reader,
    ) -> Result<(EngineSolid, f32), EngineProblem> {
        let scale = collider.scale();
        if is_even(scale) && read::is_baked(&collider.raw, reader) {
            let mut unscaled = collider.clone();
            unscaled.set_scale(Vec3::ONE, 1);
            return Ok((read::read(&unscaled.raw, reader)?, scale.x));
        }
        Ok((read::read(&collider.raw, reader)?, 1.0))
    }
}
