//! Avian's colliders.

use avian3d::parry;
use avian3d::prelude as engine;
use bevy::prelude::*;

use crate::engines::adapt::{add_engine, schedule_engine};
use crate::engines::engine::{Adapting, Engine, is_even};
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;

// Both engines have parry's shapes, but not of the same version.
#[allow(clippy::duplicate_mod)]
#[path = "read.rs"]
mod read;

/// Cloths collide with Avian's colliders: with those that have [`ClothCollider`](crate::ClothCollider), or with
/// [`all`](Self::all).
///
/// Add it beside [`ClothPlugin`](crate::ClothPlugin) and Avian's `PhysicsPlugins`. Cloths are stepped after the physics where both are
/// in one schedule, as they are unless told otherwise.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// use avian3d::prelude::*;
///
/// # fn build(app: &mut App) {
/// app.add_plugins((PhysicsPlugins::default(), ClothPlugin::default(), AvianClothPlugin::default()));
/// # }
/// fn spawn(mut commands: Commands) {
///     commands.spawn((
///         RigidBody::Dynamic,
///         Collider::sphere(0.5),
///         ClothCollider::default(),
///         Transform::from_xyz(0.0, 2.0, 0.0),
///     ));
/// }
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct AvianClothPlugin {
    /// Whether colliders without `ClothCollider` are taken too.
    pub all: bool,
}

impl AvianClothPlugin {
    /// With every collider that is neither a sensor nor disabled, but for those with
    /// [`SdfColliderDisabled`](crate::SdfColliderDisabled).
    pub fn all() -> Self {
        Self { all: true }
    }
}

impl Plugin for AvianClothPlugin {
    fn build(&self, app: &mut App) {
        add_engine::<Avian>(app, self.all);
    }

    fn finish(&self, app: &mut App) {
        schedule_engine::<Avian>(app, engine::PhysicsSystems::Last);
    }
}

/// Avian.
pub(crate) struct Avian;

impl Engine for Avian {
    const NAME: &'static str = "Avian";
    const SET: Adapting = Adapting::Avian;
    const FRICTION_OF_BODY: bool = true;
    type Collider = engine::Collider;
    type Known = engine::ColliderMarker;
    type Sensor = engine::Sensor;
    type ColliderDisabled = engine::ColliderDisabled;
    type Body = engine::RigidBody;
    type BodyDisabled = engine::RigidBodyDisabled;
    type Friction = engine::Friction;

    fn friction(friction: &engine::Friction) -> f32 {
        friction.dynamic_coefficient
    }

    fn read(
        collider: &engine::Collider,
        reader: &mut Reader,
    ) -> Result<(EngineSolid, f32), EngineProblem> {
        let scale = collider.scale();
        if is_even(scale) && read::is_baked(collider.shape(), reader) {
            return Ok((read::read(collider.shape(), reader)?, scale.x));
        }
        Ok((read::read(collider.shape_scaled(), reader)?, 1.0))
    }
}
