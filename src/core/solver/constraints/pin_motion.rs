//! How a pin moves through a tick.

use bevy_math::Vec3;

/// Where a pin is at the tick's start and end, in world space \[m\]; it moves evenly between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinMotion {
    /// Where the tick begins.
    pub start: Vec3,
    /// Where it ends.
    pub end: Vec3,
}

impl PinMotion {
    /// A pin that stays.
    pub fn still(at: Vec3) -> Self {
        Self { start: at, end: at }
    }
}
