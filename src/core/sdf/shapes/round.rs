//! Sphere, capsule and half-space: the distance to a point, a segment and a plane.

use super::{Kernel, centred, larger, length_and_direction, smaller, to_sample};
use crate::sdf::{KnownShape, LANES, PointBlock, SampleBlock, SdfSample, SignedDistance};
use bevy_math::{
    Vec3,
    bounding::Aabb3d,
    primitives::{Capsule3d, InfinitePlane3d, Sphere},
};

#[inline(always)]
fn sphere(radius: f32, x: f32, y: f32, z: f32) -> Kernel {
    let (length, normal) = length_and_direction([x, y, z], [0.0, 1.0, 0.0]);
    (length - radius, normal)
}

#[inline(always)]
fn capsule(radius: f32, half_length: f32, x: f32, y: f32, z: f32) -> Kernel {
    let on_segment = larger(smaller(y, half_length), -half_length);
    // On the segment every way across is as short, and none is along it.
    let (length, normal) = length_and_direction([x, y - on_segment, z], [1.0, 0.0, 0.0]);
    (length - radius, normal)
}

/// A capsule between any two points of its frame, such as the ends of a bone.
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct CapsuleBetween {
    /// Centre of one round end \[m\].
    pub from: Vec3,
    /// Centre of the other \[m\]; may be the same.
    pub to: Vec3,
    /// Distance of the surface from the line between them \[m\].
    pub radius: f32,
}

impl CapsuleBetween {
    #[inline(always)]
    fn kernel(&self, p: Vec3) -> Kernel {
        let (way, from) = (self.to - self.from, p - self.from);
        let squared = larger(way.dot(way), f32::MIN_POSITIVE);
        let part = smaller(larger(from.dot(way) / squared, 0.0), 1.0);
        // On the line every way across is as short, and this one is across.
        let across =
            if way.x.abs() < way.y.abs() { [0.0, -way.z, way.y] } else { [-way.z, 0.0, way.x] };
        let (_, across) = length_and_direction(across, [0.0, 1.0, 0.0]);
        let (length, normal) = length_and_direction((from - way * part).to_array(), across);
        (length - self.radius, normal)
    }
}

impl SignedDistance for CapsuleBetween {
    fn sample(&self, p: Vec3) -> SdfSample {
        to_sample(self.kernel(p))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        capsule_between_block(self, points, out);
    }

    fn core_depth(&self) -> f32 {
        self.radius
    }

    fn least_radius(&self) -> f32 {
        self.radius
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::CapsuleBetween(self))
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let (low, high) = (self.from.min(self.to), self.from.max(self.to));
        let radius = Vec3::splat(self.radius.abs());
        Some(Aabb3d { min: (low - radius).into(), max: (high + radius).into() })
    }
}

/// [`CapsuleBetween`] at a block of points.
#[inline(always)]
pub fn capsule_between_block(shape: &CapsuleBetween, points: &PointBlock, out: &mut SampleBlock) {
    for i in 0..LANES {
        let (distance, normal) = shape.kernel(points.point(i));
        out.set(i, distance, normal);
    }
}

#[inline(always)]
fn half_space(normal: [f32; 3], x: f32, y: f32, z: f32) -> Kernel {
    (normal[0] * x + normal[1] * y + normal[2] * z, normal)
}

/// [`Sphere`] of this `radius` \[m\] at a block of points.
#[inline(always)]
pub fn sphere_block(radius: f32, points: &PointBlock, out: &mut SampleBlock) {
    for i in 0..LANES {
        let (distance, normal) = sphere(radius, points.x[i], points.y[i], points.z[i]);
        out.set(i, distance, normal);
    }
}

/// Distance alone \[m\] of a [`Sphere`] of this `radius` \[m\].
#[inline(always)]
pub fn sphere_distance_block(radius: f32, points: &PointBlock, out: &mut [f32; LANES]) {
    for (i, distance) in out.iter_mut().enumerate() {
        *distance = sphere(radius, points.x[i], points.y[i], points.z[i]).0;
    }
}

/// [`Capsule3d`] of this `radius` and `half_length` (half of its straight part) \[m\] at a block of points.
#[inline(always)]
pub fn capsule_block(radius: f32, half_length: f32, points: &PointBlock, out: &mut SampleBlock) {
    for i in 0..LANES {
        let (distance, normal) =
            capsule(radius, half_length, points.x[i], points.y[i], points.z[i]);
        out.set(i, distance, normal);
    }
}

/// Distance alone \[m\] of a [`Capsule3d`] of this `radius` and `half_length` \[m\].
#[inline(always)]
pub fn capsule_distance_block(
    radius: f32,
    half_length: f32,
    points: &PointBlock,
    out: &mut [f32; LANES],
) {
    for (i, distance) in out.iter_mut().enumerate() {
        *distance = capsule(radius, half_length, points.x[i], points.y[i], points.z[i]).0;
    }
}

/// Half-space below the plane through the origin with this unit `normal`, at a block of points.
#[inline(always)]
pub fn half_space_block(normal: Vec3, points: &PointBlock, out: &mut SampleBlock) {
    let normal = normal.to_array();
    for i in 0..LANES {
        let (distance, normal) = half_space(normal, points.x[i], points.y[i], points.z[i]);
        out.set(i, distance, normal);
    }
}

/// Distance alone \[m\] of the half-space below the plane through the origin with this unit `normal`.
#[inline(always)]
pub fn half_space_distance_block(normal: Vec3, points: &PointBlock, out: &mut [f32; LANES]) {
    let normal = normal.to_array();
    for (i, distance) in out.iter_mut().enumerate() {
        *distance = half_space(normal, points.x[i], points.y[i], points.z[i]).0;
    }
}

impl SignedDistance for Sphere {
    fn sample(&self, p: Vec3) -> SdfSample {
        to_sample(sphere(self.radius, p.x, p.y, p.z))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        sphere_block(self.radius, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        sphere_distance_block(self.radius, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Sphere(self))
    }

    fn core_depth(&self) -> f32 {
        self.radius
    }

    fn least_radius(&self) -> f32 {
        self.radius
    }

    fn bounds(&self) -> Option<Aabb3d> {
        centred(Vec3::splat(self.radius))
    }
}

impl SignedDistance for Capsule3d {
    fn sample(&self, p: Vec3) -> SdfSample {
        to_sample(capsule(self.radius, self.half_length, p.x, p.y, p.z))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        capsule_block(self.radius, self.half_length, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        capsule_distance_block(self.radius, self.half_length, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Capsule(self))
    }

    fn core_depth(&self) -> f32 {
        self.radius
    }

    fn least_radius(&self) -> f32 {
        self.radius
    }

    fn bounds(&self) -> Option<Aabb3d> {
        centred(Vec3::new(self.radius, self.half_length + self.radius, self.radius))
    }
}

/// The solid half-space below the plane; its normal points out of it.
impl SignedDistance for InfinitePlane3d {
    fn sample(&self, p: Vec3) -> SdfSample {
        to_sample(half_space(self.normal.as_vec3().to_array(), p.x, p.y, p.z))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        half_space_block(self.normal.as_vec3(), points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        half_space_distance_block(self.normal.as_vec3(), points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::HalfSpace(self))
    }

    fn core_depth(&self) -> f32 {
        f32::INFINITY
    }

    fn least_radius(&self) -> f32 {
        f32::INFINITY
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }
}
