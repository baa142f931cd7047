//! Where a rigid thing is.

use bevy_math::{Quat, Vec3};

/// Where a collider is: uniform scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// Place of the shape's origin \[m\].
    pub translation: Vec3,
    /// Rotation, of length one.
    pub rotation: Quat,
    /// Uniform scale, above zero.
    pub scale: f32,
}

impl Pose {
    /// No translation, no rotation, scale one.
    pub const IDENTITY: Self =
        Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };

    /// A pose without rotation or scale.
    pub fn from_translation(translation: Vec3) -> Self {
        Self { translation, ..Self::IDENTITY }
    }

    /// Whether every number can be used.
    pub fn is_valid(&self) -> bool {
        self.translation.is_finite()
            && self.rotation.is_finite()
            && (self.rotation.length_squared() - 1.0).abs() < 1e-3
            && self.scale.is_finite()
            && self.scale > 0.0
    }

    /// The pose at part `t` of the way to `end`; rotations the shorter way, without transcendental
    /// functions, so that it gives the same bits everywhere.
    pub fn interpolate(&self, end: &Self, t: f32) -> Self {
        if self == end || t <= 0.0 {
            return *self;
        }
        if t >= 1.0 {
            return *end;
        }
        let side = if self.rotation.dot(end.rotation) < 0.0 { -1.0 } else { 1.0 };
        Self {
            translation: self.translation + (end.translation - self.translation) * t,
            rotation: (self.rotation * (1.0 - t) + end.rotation * (side * t)).normalize(),
            scale: self.scale + (end.scale - self.scale) * t,
        }
    }

    pub(super) fn apply(&self, point: Vec3) -> Vec3 {
        self.rotation * (point * self.scale) + self.translation
    }
}
