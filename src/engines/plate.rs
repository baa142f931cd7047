//! A triangle with a thickness.

use bevy::math::bounding::Aabb3d;
use bevy::prelude::*;

use crate::sdf::{SdfSample, SignedDistance};

/// All that is within a distance of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plate {
    /// Corners \[m\].
    pub corners: [Vec3; 3],
    /// Distance of the surface from the triangle \[m\].
    pub radius: f32,
}

impl Plate {
    /// The nearest point of the triangle, by Ericson's classification (*Real-Time Collision Detection*, section 5.1.5).
    fn nearest(&self, point: Vec3) -> Vec3 {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let along = |from: Vec3| (ab.dot(point - from), ac.dot(point - from));
        let ((a1, a2), (b1, b2), (c1, c2)) = (along(a), along(b), along(c));
        if a1 <= 0.0 && a2 <= 0.0 {
            return a;
        }
        if b1 >= 0.0 && b2 <= b1 {
            return b;
        }
        let beside_ab = a1 * b2 - b1 * a2;
        if beside_ab <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
            return a + ab * (a1 / (a1 - b1));
        }
        if c2 >= 0.0 && c1 <= c2 {
            return c;
        }
        let beside_ac = c1 * a2 - a1 * c2;
        if beside_ac <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
            return a + ac * (a2 / (a2 - c2));
        }
        let beside_bc = b1 * c2 - c1 * b2;
        let (from_b, from_c) = (b2 - b1, c1 - c2);
        if beside_bc <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
            return b + (c - b) * (from_b / (from_b + from_c));
        }
        // Along the normal nothing cancels.
        let normal = ab.cross(ac).normalize_or_zero();
        point - normal * normal.dot(point - a)
    }
}

impl SignedDistance for Plate {
    fn sample(&self, point: Vec3) -> SdfSample {
        let [a, b, c] = self.corners;
        let away = point - self.nearest(point);
        let length = away.length();
        // On the triangle both its sides are as near.
        let across = (b - a).cross(c - a).normalize_or(Vec3::Y);
        SdfSample { distance: length - self.radius, normal: away.try_normalize().unwrap_or(across) }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let [a, b, c] = self.corners;
        let radius = Vec3::splat(self.radius);
        let (low, high) = (a.min(b).min(c) - radius, a.max(b).max(c) + radius);
        Some(Aabb3d { min: low.into(), max: high.into() })
    }

    fn core_depth(&self) -> f32 {
        self.radius
    }

    fn least_radius(&self) -> f32 {
        self.radius
    }
}
