//! Random points, and bits compared.

use bevy::math::DVec3;

/// Where the meshes are moved to, so that nothing lies on a node.
pub const SHIFT: DVec3 = DVec3::new(0.013, 0.021, 0.007);

/// A linear congruential generator: the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
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
