//! Rigid bodies that cloths move: what a game or a physics engine says of them, and what they are given.

use bevy::prelude::*;

use crate::solver::{Impulse, Mobility, ParameterError};

/// Makes an [`SdfCollider`](crate::SdfCollider) a rigid body that cloths move: they carry it, slow it down and turn it.
///
/// The body stays the game's own, or that of its physics engine. In each tick the engine moves its entity first, cloths are stepped
/// then, and the engine gives the body its [`BodyImpulse`] at the end:
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::{BodyImpulse, ClothSystems, ColliderMass};
/// #[derive(Component, Default)]
/// struct Velocity(Vec3);
///
/// fn spawn(mut commands: Commands) {
///     let ball = (SdfCollider::from(Sphere::new(0.15)), ColliderMass::sphere(1.0, 0.15));
///     commands.spawn((ball, Velocity::default(), Transform::from_xyz(0.0, 1.0, 0.0)));
/// }
///
/// fn fall(mut balls: Query<(&mut Transform, &mut Velocity)>, time: Res<Time>) {
///     for (mut place, mut velocity) in &mut balls {
///         velocity.0.y -= 9.81 * time.delta_secs();
///         place.translation += velocity.0 * time.delta_secs();
///     }
/// }
///
/// fn be_pushed(mut balls: Query<(&mut Velocity, &BodyImpulse, &ColliderMass)>) {
///     for (mut velocity, impulse, body) in &mut balls {
///         velocity.0 += impulse.linear / body.mass;
///     }
/// }
///
/// # let mut app = App::new();
/// app.add_systems(FixedUpdate, fall)
///     .add_systems(FixedPostUpdate, be_pushed.after(ClothSystems::Finish));
/// ```
///
/// Within the tick the body takes part in each substep: a cloth meets it where what it has been given up to then has taken it, and
/// threads feel its mass. So a cloth carries bodies of any mass, and none is thrown off. Where several cloths are near a body, each
/// meets an equal part of it.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Debug, PartialEq, Clone)]
#[require(BodyImpulse, BodyMemory)]
pub struct ColliderMass {
    /// Mass \[kg\].
    pub mass: f32,
    /// Moments of inertia about the principal axes through the centre of mass \[kg m2\]. Infinite where nothing turns it.
    pub principal_inertia: Vec3,
    /// Turns the principal axes to those of the entity.
    pub principal_axes: Quat,
    /// Centre of mass, in the entity's frame \[m\].
    pub center_of_mass: Vec3,
    /// The body sleeps: cloths lie on it as on a wall, and its [`BodyImpulse`] is not applied.
    pub sleeps: bool,
}

impl ColliderMass {
    /// A body with its centre of mass at the entity's place, and its principal axes along those of the entity.
    pub fn new(mass: f32, principal_inertia: Vec3) -> Self {
        Self {
            mass,
            principal_inertia,
            principal_axes: Quat::IDENTITY,
            center_of_mass: Vec3::ZERO,
            sleeps: false,
        }
    }

    /// A solid ball of this `mass` \[kg\] and `radius` \[m\].
    pub fn sphere(mass: f32, radius: f32) -> Self {
        Self::new(mass, Vec3::splat(0.4 * mass * radius * radius))
    }

    /// A solid box of this `mass` \[kg\] and `size` \[m\].
    pub fn cuboid(mass: f32, size: Vec3) -> Self {
        let squares = size * size;
        let inertia = Vec3::splat(squares.element_sum()) - squares;
        Self::new(mass, inertia * (mass / 12.0))
    }

    /// Another centre of mass, in the entity's frame \[m\].
    pub fn with_center_of_mass(self, center_of_mass: Vec3) -> Self {
        Self { center_of_mass, ..self }
    }

    /// How a body answers to impulses that is turned so.
    pub(crate) fn mobility(&self, rotation: Quat, informed: bool) -> Mobility {
        let axes = Mat3::from_quat(rotation * self.principal_axes);
        let inverse = Mat3::from_diagonal(self.principal_inertia.recip());
        Mobility {
            inverse_mass: self.mass.recip(),
            inverse_inertia: axes * inverse * axes.transpose(),
            informed,
        }
    }

    /// Checks every number.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let check = |name, value: f32, sound, range| {
            if sound { Ok(()) } else { Err(ParameterError { name, value, range }) }
        };
        let masses = 1e-6..=1e9;
        check("mass", self.mass, masses.contains(&self.mass), "from 1e-6 to 1e9 kg")?;
        for inertia in self.principal_inertia.to_array() {
            let range = "from 1e-12 kg m2; infinite where nothing turns it";
            check("principal_inertia", inertia, inertia >= 1e-12, range)?;
        }
        let length = self.principal_axes.length();
        let sound = (length - 1.0).abs() < 1e-3;
        check("the length of principal_axes", length, sound, "1, a rotation")?;
        let far = self.center_of_mass.to_array().into_iter().find(|c| c.is_nan() || c.abs() > 1e7);
        let range = "within 1e7 m of the entity";
        check("center_of_mass", far.unwrap_or_default(), far.is_none(), range)
    }
}

/// The impulse that a body with a [`ColliderMass`] is to be given in this tick, after
/// [`ClothSystems::Finish`](crate::ClothSystems::Finish), in world axes.
///
/// Over time it sums up to what cloths gave; of a light rod, to less about its length. It is ahead of that by what they are expected to
/// give in the next tick, as they do in this one: the body then falls no further into a cloth that carries it, its engine finds it at rest, and it can fall asleep.
/// The angular part also makes up for how far the body has gone between being pushed and being told, so that both keep their angular
/// momentum.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct BodyImpulse {
    /// Momentum \[kg m/s\].
    pub linear: Vec3,
    /// Angular momentum about the centre of mass \[kg m2/s\].
    pub angular: Vec3,
    /// What cloths do to a body that sleeps is no longer what they did when it fell asleep: wake it.
    pub wakes: bool,
}

impl BodyImpulse {
    pub(crate) fn sum(&self) -> Impulse {
        Impulse { linear: self.linear, angular: self.angular }
    }
}

impl From<Impulse> for BodyImpulse {
    fn from(Impulse { linear, angular }: Impulse) -> Self {
        Self { linear, angular, wakes: false }
    }
}

/// Makes an [`SdfCollider`](crate::SdfCollider) a part of the body of another entity, which has a [`ColliderMass`].
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::{ColliderBody, ColliderMass};
/// # fn spawn(mut commands: Commands) {
/// let hammer = commands.spawn((ColliderMass::new(1.0, Vec3::splat(0.02)), Transform::default())).id();
/// let part = |shape: Cuboid, y| {
///     (SdfCollider::from(shape), ColliderBody(hammer), ChildOf(hammer), Transform::from_xyz(0.0, y, 0.0))
/// };
/// commands.spawn(part(Cuboid::new(0.03, 0.3, 0.03), -0.1));
/// commands.spawn(part(Cuboid::new(0.12, 0.05, 0.05), 0.07));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, Debug, PartialEq, Clone)]
pub struct ColliderBody(#[entities] pub Entity);

/// What is remembered of a body between ticks.
#[derive(Component, Clone, Debug, Default)]
pub(crate) struct BodyMemory {
    /// It was given its impulse after the last tick.
    pub informed: bool,
    /// The part of that which cloths were expected to give in this tick.
    pub ahead: Impulse,
    /// What cloths gave it in its first tick asleep, and how many of them took that tick.
    pub at_rest: Option<(Impulse, u32)>,
    /// Where its centre was in the last tick \[m\].
    pub at: Option<Vec3>,
    /// Cloths that carry it and do not go on.
    pub held_by: Vec<Held>,
}

/// A body in a cloth that is paused or out of sight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held {
    pub cloth: Entity,
    /// Where its centre was when that began, in the frame of what leads the cloth; none once it has left it \[m\].
    pub began: Option<Vec3>,
    /// Where it was there in the last tick \[m\], and what it was given then.
    pub at: Vec3,
    pub given: Impulse,
    /// Momentum that it is given in each tick beside the cloth's last, so that it stays \[kg m/s\].
    pub trim: Vec3,
}
