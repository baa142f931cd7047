//! Rapier's colliders.

use bevy::prelude::*;
use bevy_rapier3d::parry;
use bevy_rapier3d::prelude as engine;
use bevy_rapier3d::rapier::dynamics::LockedAxes;

use crate::collider::mass::{BodyImpulse, ColliderMass};
use crate::engines::adapt::{add_engine, couple_engine, schedule_engine};
use crate::engines::bodies::{BodyOf, set_mass};
use crate::engines::engine::{Adapting, Engine, is_even};
use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;
use crate::error::failures::Failures;

// Both engines have parry's shapes, but not of the same version.
#[allow(clippy::duplicate_mod)]
#[path = "read.rs"]
mod read;

/// Cloths collide with the colliders of Rapier: with those that have [`ClothCollider`](crate::ClothCollider), or with
/// [`all`](Self::all).
///
/// Add it beside [`ClothPlugin`](crate::ClothPlugin) and `RapierPhysicsPlugin`. By default Rapier moves bodies once a frame,
/// which ticks see a frame late, and which depends on the frames. With `in_fixed_schedule` it moves them each tick,
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
        couple_engine::<Rapier, _, _>(app, engine::PhysicsSet::StepSimulation, weigh, give);
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

    fn is_dynamic(body: &engine::RigidBody) -> bool {
        *body == engine::RigidBody::Dynamic
    }

    fn wake(body: Entity, commands: &mut Commands) {
        let wake = |In(body): In<Entity>,
                    bodies: Query<InWorld>,
                    mut worlds: Query<&mut engine::RapierRigidBodySet>| {
            let Ok((handle, world)) = bodies.get(body) else { return };
            let Ok(mut world) = worlds.get_mut(world.0) else { return };
            if let Some(body) = world.bodies.get_mut(handle.0) {
                body.wake_up(true);
            }
        };
        commands.run_system_cached_with(wake, body);
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

/// A body, and the world of Rapier's that it is in.
type InWorld = (&'static engine::RapierRigidBodyHandle, &'static engine::RapierContextEntityLink);

/// Says how heavy bodies are.
fn weigh(
    mut bodies: Query<
        (Entity, InWorld, &Transform, Option<&mut ColliderMass>),
        With<BodyOf<Rapier>>,
    >,
    worlds: Query<(&engine::RapierRigidBodySet, &engine::RapierConfiguration)>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for (entity, (handle, world), place, known) in &mut bodies {
        let Ok((world, settings)) = worlds.get(world.0) else { continue };
        let Some(body) = world.bodies.get(handle.0) else { continue };
        let all = body.mass_properties();
        let (properties, locked) = (&all.local_mprops, all.flags);
        let turns = !locked.contains(LockedAxes::ROTATION_LOCKED);
        let principal_inertia = properties.inv_principal_inertia.recip();
        let found = ColliderMass {
            mass: properties.inv_mass.recip(),
            principal_inertia: if turns { principal_inertia } else { Vec3::INFINITY },
            principal_axes: properties.principal_inertia_local_frame,
            // Rapier's is not scaled with the entity.
            center_of_mass: properties.local_com / place.scale,
            sleeps: body.is_sleeping()
                || !settings.physics_pipeline_active
                || locked.contains(LockedAxes::TRANSLATION_LOCKED),
        };
        set_mass(entity, found, known, &mut commands, &mut failures);
    }
}

/// Gives bodies their impulses. One that sleeps goes on sleeping, unless something has changed for it.
fn give(
    mut bodies: Query<
        (InWorld, &BodyImpulse, &ColliderMass, Option<&mut engine::Velocity>),
        With<BodyOf<Rapier>>,
    >,
    mut worlds: Query<&mut engine::RapierRigidBodySet>,
) {
    for ((handle, world), impulse, mass, velocity) in &mut bodies {
        let Ok(mut world) = worlds.get_mut(world.0) else { continue };
        let Some(body) = world.bodies.get_mut(handle.0) else { continue };
        if impulse.wakes {
            body.wake_up(true);
        }
        if mass.sleeps {
            continue;
        }
        let before = engine::Velocity { linear: body.linvel(), angular: body.angvel() };
        body.apply_impulse(impulse.linear, false);
        body.apply_torque_impulse(impulse.angular, false);
        // Rapier takes the component over before its next step, and the impulse would be lost. Where a game has changed it,
        // the impulse is added to that; else both are to be the same bits, or the body would be woken.
        if let Some(mut velocity) = velocity {
            let (linear, angular) = (body.linvel(), body.angvel());
            if *velocity == before {
                *velocity.bypass_change_detection() = engine::Velocity { linear, angular };
            } else {
                velocity.linear += linear - before.linear;
                velocity.angular += angular - before.angular;
            }
        }
    }
}
