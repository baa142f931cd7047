//! Linear and angular impulses.

use core::ops::{Add, AddAssign, Mul, Sub};

use bevy_math::{Mat3, Vec3};

/// A linear impulse, and an angular one about a place that both sides know.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct Impulse {
    /// Momentum \[kg m/s\].
    pub linear: Vec3,
    /// Angular momentum \[kg m2/s\].
    pub angular: Vec3,
}

impl Impulse {
    /// None.
    pub const ZERO: Self = Self { linear: Vec3::ZERO, angular: Vec3::ZERO };

    /// An impulse that acts at an arm from the place \[m\].
    #[inline(always)]
    pub(crate) fn at(arm: Vec3, linear: Vec3) -> Self {
        Self { linear, angular: arm.cross(linear) }
    }

    /// The impulse, turned.
    pub(crate) fn turned(self, turn: Mat3) -> Self {
        Self { linear: turn * self.linear, angular: turn * self.angular }
    }
}

impl Add for Impulse {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl AddAssign for Impulse {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Impulse {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul<f32> for Impulse {
    type Output = Self;

    fn mul(self, part: f32) -> Self {
        Self { linear: self.linear * part, angular: self.angular * part }
    }
}

impl core::iter::Sum for Impulse {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::ZERO, Add::add)
    }
}
