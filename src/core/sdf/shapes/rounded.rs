//! A solid swollen by a radius.

use crate::sdf::{
    LANES, NearestBlock, PointBlock, SampleBlock, SdfSample, SegmentBlock, SignedDistance,
};
use bevy_math::{Vec3, Vec3A, bounding::Aabb3d};
use std::sync::Arc;

/// A solid with everything that is within a radius of it: a box becomes a box with round edges, a flat thing a thick one.
///
/// Outside, the distance is as exact as the solid's own. Inside, it is exact around a convex solid; where a
/// surface is hollow, a ball of this radius may not reach into it, and the distance there is that to a
/// surface which is nearer than the true one.
#[derive(Clone, Debug)]
pub struct Rounded {
    /// What is swollen.
    pub solid: Arc<dyn SignedDistance>,
    /// How far \[m\]. Higher is thicker.
    pub radius: f32,
}

impl Rounded {
    /// Swells `solid` by `radius` \[m\]. One that is in an `Arc` already goes into the fields as it is.
    pub fn new(solid: impl SignedDistance, radius: f32) -> Self {
        Self { solid: Arc::new(solid), radius }
    }
}

impl SignedDistance for Rounded {
    fn sample(&self, point: Vec3) -> SdfSample {
        let SdfSample { distance, normal } = self.solid.sample(point);
        SdfSample { distance: distance - self.radius, normal }
    }

    fn distance(&self, point: Vec3) -> f32 {
        self.solid.distance(point) - self.radius
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        self.solid.sample_block(points, out);
        for distance in &mut out.distance {
            *distance -= self.radius;
        }
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        self.solid.distance_block(points, out);
        for distance in out {
            *distance -= self.radius;
        }
    }

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        self.solid.nearest_on_segments(segments, out);
        for distance in out.distance.iter_mut().chain(&mut out.least) {
            *distance -= self.radius;
        }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let Aabb3d { min, max } = self.solid.bounds()?;
        let radius = Vec3A::splat(self.radius);
        Some(Aabb3d { min: min - radius, max: max + radius })
    }

    /// The solid's own and the radius: every way out is longer by that.
    fn core_depth(&self) -> f32 {
        (self.solid.core_depth() + self.radius).max(0.0)
    }

    /// The solid's own and the radius: a parallel surface bends around the same centres. Zero where the
    /// solid's distance is not exact, since a surface of equal distances is then not parallel to it.
    fn least_radius(&self) -> f32 {
        if self.overestimate() > 0.0 {
            return 0.0;
        }
        (self.solid.least_radius() + self.radius).max(0.0)
    }

    fn overestimate(&self) -> f32 {
        self.solid.overestimate()
    }
}
