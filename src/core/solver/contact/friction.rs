//! Coulomb's friction of a particle, of which corrections have moved a part.
//!
//! Corrections see a particle that sticks with a part of its inverse mass, its slip `s`. Of a pull `P` they move it by
//! `s P`, and the surface is taken to hold the rest, `(1 - s) P`. So what friction has to bear is not the way that
//! is left of a particle, but its demand: that way and what has been held. It sticks where its demand is within Coulomb's limit.
//!
//! A pull beyond the limit has to move a particle as corrections foresee it, `s` times as far as it is too large: they would
//! else find the threads out of length in the next substep by more than that, and pull the more. Friction on a cloth that
//! is about to slip would flip between two states, ever wider, and the cloth would creep long before it should slip. But a
//! particle's own motion is no pull, and is braked as it is.

use bevy_math::Vec3;

use crate::solver::contact::LEAST_SLIDING;
use crate::solver::simd::block::larger;

/// Pull, as a multiple of Coulomb's limit, from which friction no longer brakes the particle's own motion, if its slip is
/// at most 2/3: see [`Sliding::left`].
const SPENT: f32 = 3.0;

/// A particle's way along a surface, as displacements \[m\].
#[derive(Clone, Copy)]
pub(super) struct Sliding {
    /// The particle's displacement along the surface, after the corrections.
    pub way: Vec3,
    /// The part of it that pulls have made.
    pub pulled: Vec3,
    /// One over its slip.
    pub unslipped: f32,
}

impl Sliding {
    /// The way that pulls would have moved it beyond the one that they did.
    #[inline(always)]
    pub fn held(&self) -> Vec3 {
        self.pulled * (self.unslipped - 1.0)
    }

    /// The part of its way that friction takes, of what it can undo at `most` \[m\], on a surface of normal `n`.
    #[inline(always)]
    pub fn braked(&self, most: f32, n: Vec3) -> f32 {
        let held = self.held();
        let way = larger(self.way.dot(self.way).sqrt(), LEAST_SLIDING);
        let demand = self.way + held - n * held.dot(n);
        let asked = larger(demand.dot(demand).sqrt(), LEAST_SLIDING);
        let excess = larger(asked - most, 0.0);
        let slip = 1.0 / self.unslipped;
        let pull = larger(self.unslipped * self.pulled.dot(demand) / asked - most, 0.0);
        let of_pull = if pull < excess { pull } else { excess };
        let goes = excess - (1.0 - slip) * of_pull;
        // Friction never drives.
        let goes = if demand.dot(self.way) > 0.0 { goes } else { 0.0 };
        let brake = larger(way - goes, 0.0);
        let left = self.left(most, slip);
        (if brake < left { brake } else { left }) * (1.0 / way)
    }

    /// The way that friction can still take \[m\]: the part of the limit that holds no pull, or the slip's part of the limit, which
    /// ends as pulls grow.
    #[inline(always)]
    fn left(&self, most: f32, slip: f32) -> f32 {
        let pull = self.pulled.dot(self.pulled).sqrt() * self.unslipped;
        let spent = larger(pull - most, 0.0) * (1.0 / (SPENT - 1.0));
        larger(most - pull * (1.0 - slip), larger(most - spent, 0.0) * slip)
    }
}
