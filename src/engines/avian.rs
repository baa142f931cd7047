//! Avian's colliders.

use avian3d::dynamics::integrator::CustomVelocityIntegration;
use avian3d::parry;
use avian3d::prelude as engine;
use avian3d::prelude::{PhysicsTime, WriteRigidBodyForces};
use bevy::prelude::*;

use crate::collider::mass::{BodyImpulse, BodyMemory, ColliderMass};
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
        couple_engine::<Avian, _, _>(app, engine::PhysicsSystems::StepSimulation, weigh, give);
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

    fn is_dynamic(body: &engine::RigidBody) -> bool {
        body.is_dynamic()
    }

    fn wake(body: Entity, commands: &mut Commands) {
        commands.queue(engine::WakeBody(body));
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

/// What Avian knows of a body's mass.
type Weight = (
    Entity,
    &'static engine::ComputedMass,
    Ref<'static, engine::ComputedAngularInertia>,
    &'static engine::ComputedCenterOfMass,
    &'static Transform,
    Option<&'static engine::LockedAxes>,
    Has<engine::Sleeping>,
    Option<&'static mut ColliderMass>,
);

/// Says how heavy bodies are.
fn weigh(
    mut bodies: Query<Weight, With<BodyOf<Avian>>>,
    time: Option<Res<Time<engine::Physics>>>,
    mut commands: Commands,
    mut failures: Failures,
) {
    let stands = time.is_none_or(|time| time.is_paused() || time.relative_speed() == 0.0);
    for (entity, mass, inertia, center, place, locked, sleeps, known) in &mut bodies {
        let locked = locked.copied().unwrap_or_default();
        let turns = !locked.is_rotation_locked();
        // Axes are dear to find.
        let is_known = |it: &Mut<ColliderMass>| {
            !(it.is_changed() || inertia.is_changed()) && it.principal_inertia.is_finite() == turns
        };
        let (principal_inertia, principal_axes) = match known.as_ref().filter(|it| is_known(it)) {
            Some(known) => (known.principal_inertia, known.principal_axes),
            None => inertia.principal_angular_inertia_with_local_frame(),
        };
        let found = ColliderMass {
            mass: mass.value(),
            principal_inertia: if turns { principal_inertia } else { Vec3::INFINITY },
            principal_axes,
            // Avian's is not scaled with the entity.
            center_of_mass: center.0 / place.scale,
            sleeps: sleeps || stands || locked.is_translation_locked(),
        };
        set_mass(entity, found, known, &mut commands, &mut failures);
    }
}

/// A body, and what cloths have to do with it.
type Given = (
    Entity,
    Has<CustomVelocityIntegration>,
    engine::Forces,
    &'static BodyImpulse,
    &'static BodyMemory,
    &'static ColliderMass,
);

/// Gives bodies their impulses. One that sleeps goes on sleeping, unless something has changed for it.
///
/// The angular impulse that is expected of the next step is given all through it, as weight acts, and not by a blow at its start: what
/// leans in a cloth would turn to and fro within each step, by a radian a second at its end, and never sleep. The linear one is given by
/// a blow: all through the step it would come half a step later, and light balls would swing in a hammock for ever.
fn give(
    mut bodies: Query<Given, With<BodyOf<Avian>>>,
    time: Option<Res<Time<engine::Physics>>>,
    mut commands: Commands,
) {
    let step = time.map_or(0.0, |time| time.delta_secs());
    for (entity, is_custom, mut forces, impulse, memory, mass) in &mut bodies {
        if impulse.wakes {
            Avian::wake(entity, &mut commands);
        }
        if mass.sleeps {
            continue;
        }
        let mut forces = forces.non_waking();
        forces.apply_linear_impulse(impulse.linear);
        // Avian turns no body of its user's own integration by torques.
        let through = if step > 0.0 && !is_custom { memory.ahead.angular } else { Vec3::ZERO };
        if through != Vec3::ZERO {
            forces.apply_torque(through / step);
        }
        forces.apply_angular_impulse(impulse.angular - through);
    }
}
