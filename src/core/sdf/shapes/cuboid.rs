//! Cuboid: the distance to a face, an edge or a corner, whichever is nearest.

use super::{Kernel, centred, larger, length_and_direction, smaller, to_sample};
use crate::sdf::{KnownShape, LANES, PointBlock, SampleBlock, SdfSample, SignedDistance};
use bevy_math::{Vec3, bounding::Aabb3d, primitives::Cuboid};

#[inline(always)]
fn cuboid(half_size: [f32; 3], x: f32, y: f32, z: f32) -> Kernel {
    // Beyond each pair of faces, by symmetry in the positive octant.
    let ax = x.abs() - half_size[0];
    let ay = y.abs() - half_size[1];
    let az = z.abs() - half_size[2];
    let deepest = larger(larger(ax, ay), az);

    // The nearest face: the way out from inside, and from so close outside that squares vanish.
    // Of equally near faces the horizontal one is taken, so that a cube's centre goes up.
    let on_y = ay >= ax && ay >= az;
    let on_x = !on_y && ax >= az;
    let one_if = |yes: bool| if yes { 1.0 } else { 0.0 };
    let face = [one_if(on_x), one_if(on_y), one_if(!on_x && !on_y)];

    let outside = [larger(ax, 0.0), larger(ay, 0.0), larger(az, 0.0)];
    let (length, normal) = length_and_direction(outside, face);
    let distance = length + smaller(deepest, 0.0);
    let mirrored = [normal[0].copysign(x), normal[1].copysign(y), normal[2].copysign(z)];
    (distance, mirrored)
}

/// [`Cuboid`] of this half size \[m\] at a block of points.
#[inline(always)]
pub fn cuboid_block(half_size: Vec3, points: &PointBlock, out: &mut SampleBlock) {
    let half_size = half_size.to_array();
    for i in 0..LANES {
        let (distance, normal) = cuboid(half_size, points.x[i], points.y[i], points.z[i]);
        out.set(i, distance, normal);
    }
}

/// Distance alone \[m\] of a [`Cuboid`] of this half size \[m\].
#[inline(always)]
pub fn cuboid_distance_block(half_size: Vec3, points: &PointBlock, out: &mut [f32; LANES]) {
    let half_size = half_size.to_array();
    for (i, distance) in out.iter_mut().enumerate() {
        *distance = cuboid(half_size, points.x[i], points.y[i], points.z[i]).0;
    }
}

impl SignedDistance for Cuboid {
    fn sample(&self, p: Vec3) -> SdfSample {
        to_sample(cuboid(self.half_size.to_array(), p.x, p.y, p.z))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        cuboid_block(self.half_size, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        cuboid_distance_block(self.half_size, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Cuboid(self))
    }

    fn core_depth(&self) -> f32 {
        self.half_size.min_element()
    }

    fn bounds(&self) -> Option<Aabb3d> {
        centred(self.half_size)
    }
}
