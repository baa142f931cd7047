//! Random numbers that are the same everywhere.

use bevy::math::{DVec3, Vec3};

/// A linear congruential generator (Knuth's).
pub struct Dice(pub u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0
    }

    /// From -1 to 1.
    pub fn roll(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    /// Each coordinate from -1 to 1.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.roll(), self.roll(), self.roll())
    }

    /// From 0 to 1, in 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A whole number below another.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next() >> 33) as usize % count
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn in_box(&mut self, half: f64) -> DVec3 {
        DVec3::from_array(core::array::from_fn(|_| self.between(-half, half)))
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.in_box(1.0);
            if (0.1..1.0).contains(&v.length()) {
                return v.normalize();
            }
        }
    }
}
