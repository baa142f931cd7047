//! Particles that pressed edges may move.

use bevy_math::Vec3A;

/// A particle that pressed edges may move.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub slot: u32,
    /// \[1/kg\].
    pub inverse_mass: f32,
    /// The particle's position and its displacement, up to now \[m\].
    pub x: Vec3A,
    pub d: Vec3A,
    /// The particle's position and its displacement before edges were held \[m\].
    pub before: [Vec3A; 2],
}

impl Body {
    /// Where it is to be \[m\].
    pub fn at(&self) -> Vec3A {
        self.x + self.d
    }

    pub fn was_at(&self) -> Vec3A {
        self.before[0] + self.before[1]
    }
}
