//! Rigid bodies that answer to what presses on them, within a tick.
//!
//! An engine moves its bodies once a tick. Were a cloth to meet them on the ways that the engine has planned, and the
//! engine told afterwards of what the cloth has done, a body that the cloth carries would be thrown: the reaction comes half a tick
//! late, and feeds each swing. So a body takes part in the substeps. It goes its planned way, and departs from it by what the
//! cloth's impulses make of it up to each substep. At the tick's end the engine is given their sum.
//!
//! The planned way may contain an impulse already that the engine was given beforehand, as the cloth was expected to go on carrying the
//! body (`coupling`). It is taken back evenly through the tick.

use bevy_math::{Mat3, Quat, Vec3};

use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::pose::Pose;

/// What a body's velocity changes by for an impulse, and where about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mobility {
    /// One over the mass \[1/kg\]; zero where nothing shifts it.
    pub inverse_mass: f32,
    /// Inverse of the inertia tensor about the centre of mass, in world axes \[1/(kg m2)\]; zero where nothing turns it.
    pub inverse_inertia: Mat3,
    /// Whether the body was given [`ClothSolver::body_impulse`](crate::solver::ClothSolver::body_impulse) after the last
    /// tick. One that sleeps is not.
    pub informed: bool,
}

impl Mobility {
    /// Whether nothing moves the body.
    pub(super) fn is_immovable(&self) -> bool {
        self.inverse_mass == 0.0 && self.inverse_inertia == Mat3::ZERO
    }

    /// The motion that an impulse makes.
    pub(super) fn motion(&self, impulse: Impulse) -> Twist {
        Twist {
            linear: impulse.linear * self.inverse_mass,
            angular: self.inverse_inertia * impulse.angular,
        }
    }

    /// Bound of [`most_along`](Self::most_along) that does not depend on the direction of the arm \[1/kg\].
    pub(super) fn most_at(&self, arm: Vec3) -> f32 {
        self.inverse_mass + self.trace() * arm.length_squared()
    }

    /// Sum of the inverse moments of inertia.
    pub(super) fn trace(&self) -> f32 {
        let inertia = self.inverse_inertia;
        inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z
    }

    /// What an impulse of one along `n` at an arm moves it by there, along `n` \[1/kg\].
    #[inline(always)]
    pub(super) fn along(&self, arm: Vec3, n: Vec3) -> f32 {
        let turn = arm.cross(n);
        self.inverse_mass + turn.dot(self.inverse_inertia * turn)
    }

    /// Most that an impulse of one may move it by at an arm, in any direction \[1/kg\].
    pub(super) fn most_along(&self, arm: Vec3) -> f32 {
        self.most_at(arm) - arm.dot(self.inverse_inertia * arm)
    }

    /// Whether every number can be used.
    pub(crate) fn is_valid(&self) -> bool {
        let Self { inverse_mass, inverse_inertia, .. } = self;
        let mass = *inverse_mass >= 0.0 && inverse_mass.is_finite();
        let inertia = inverse_inertia.is_finite()
            && inverse_inertia.x_axis.x >= 0.0
            && inverse_inertia.y_axis.y >= 0.0
            && inverse_inertia.z_axis.z >= 0.0;
        mass && inertia
    }
}

/// A velocity, or a small displacement, of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Twist {
    pub linear: Vec3,
    pub angular: Vec3,
}

impl Twist {
    /// Adds another.
    pub fn add(&mut self, other: &Self) {
        self.linear += other.linear;
        self.angular += other.angular;
    }

    /// So many times as much.
    pub fn times(&self, factor: f32) -> Self {
        Self { linear: self.linear * factor, angular: self.angular * factor }
    }

    /// What it does at an arm from the centre.
    #[inline(always)]
    pub fn at(&self, arm: Vec3) -> Vec3 {
        self.linear + self.angular.cross(arm)
    }
}

/// How far a body is from where it was planned to be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Deviation {
    /// How far its centre of mass is shifted \[m\].
    pub shift: Vec3,
    /// How far it is turned about it.
    pub turn: Quat,
}

impl Deviation {
    /// None.
    pub const NONE: Self = Self { shift: Vec3::ZERO, turn: Quat::IDENTITY };

    /// The same, after `time` of a velocity.
    pub(super) fn after(&self, velocity: &Twist, time: f32) -> Self {
        let half = velocity.angular * (0.5 * time);
        // A turn by `2 atan |half|`, without transcendental functions: exact enough for what a substep turns.
        let by = Quat::from_xyzw(half.x, half.y, half.z, 1.0).normalize();
        let turn = (by * self.turn).normalize();
        Self { shift: self.shift + velocity.linear * time, turn }
    }

    /// Both of them.
    pub(super) fn and(&self, then: &Self) -> Self {
        let turn = if self.turn == Quat::IDENTITY {
            then.turn
        } else {
            (then.turn * self.turn).normalize()
        };
        Self { shift: self.shift + then.shift, turn }
    }

    /// Whether every number can be used.
    pub(crate) fn is_valid(&self) -> bool {
        self.shift.is_finite() && (self.turn.length_squared() - 1.0).abs() < 1e-3
    }

    /// A part of it.
    pub(super) fn part(&self, part: f32) -> Self {
        if self.turn == Quat::IDENTITY {
            return Self { shift: self.shift * part, ..Self::NONE };
        }
        Self { shift: self.shift * part, turn: Quat::IDENTITY.lerp(self.turn, part) }
    }

    /// Where a place is by it, that turns about `centre`.
    pub(super) fn apply_to(&self, place: Vec3, centre: Vec3) -> Vec3 {
        if *self == Self::NONE {
            return place;
        }
        centre + self.turn * (place - centre) + self.shift
    }

    /// Where a pose is by it, that turns about `centre`.
    pub(super) fn apply(&self, pose: &Pose, centre: Vec3) -> Pose {
        if *self == Self::NONE {
            return *pose;
        }
        let translation = centre + self.turn * (pose.translation - centre) + self.shift;
        Pose { translation, rotation: (self.turn * pose.rotation).normalize(), ..*pose }
    }
}
