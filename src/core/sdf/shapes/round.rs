//! Sphere, capsule and half-space: the distance to a point, a segment and a plane.

use super::{Kernel, centred, larger, length_and_direction, smaller, to_sample};
use crate::sdf::{
    KnownShape, LANES, NearestBlock, PointBlock, SampleBlock, SdfSample, SegmentBlock,
    SignedDistance,
};
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
        let part = within(from.dot(way) / squared);
        // On the line every way across is as short, and this one is across.
        let across =
            if way.x.abs() < way.y.abs() { [0.0, -way.z, way.y] } else { [-way.z, 0.0, way.x] };
        let (_, across) = length_and_direction(across, [0.0, 1.0, 0.0]);
        let (length, normal) = length_and_direction((from - way * part).to_array(), across);
        (length - self.radius, normal)
    }
}

impl From<Capsule3d> for CapsuleBetween {
    #[inline(always)]
    fn from(Capsule3d { radius, half_length }: Capsule3d) -> Self {
        let to = Vec3::new(0.0, half_length, 0.0);
        Self { from: -to, to, radius }
    }
}

impl SignedDistance for CapsuleBetween {
    fn sample(&self, p: Vec3) -> SdfSample {
        to_sample(self.kernel(p))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        capsule_between_block(self, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        for (i, distance) in out.iter_mut().enumerate() {
            *distance = self.kernel(points.point(i)).0;
        }
    }

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        nearest_to_capsule(self, segments, out);
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

/// Part of a segment, within it; NaN where `part` is.
#[inline(always)]
fn within(part: f32) -> f32 {
    smaller(larger(part, 0.0), 1.0)
}

/// Places of segments that are nearest to a [`Sphere`] of this `radius` \[m\].
#[inline(always)]
pub fn nearest_to_sphere(radius: f32, segments: &SegmentBlock, out: &mut NearestBlock) {
    for i in 0..LANES {
        let (from, way) = (segments.from.point(i), segments.way.point(i));
        let at = within(-from.dot(way) / larger(way.dot(way), f32::MIN_POSITIVE));
        let nearest = from + way * at;
        out.at[i] = at;
        out.distance[i] = nearest.dot(nearest).sqrt() - radius;
    }
    out.least = out.distance;
}

/// Places of segments that are nearest to a capsule: those of two segments that are nearest to each other (Ericson 2005, *Real-Time
/// Collision Detection*, section 5.1.9). Of a segment that is parallel to the capsule, or nearly so, it is the one closest to the
/// segment's middle: its distance may be larger than the least by a thousandth of the segment.
#[inline(always)]
pub fn nearest_to_capsule(shape: &CapsuleBetween, segments: &SegmentBlock, out: &mut NearestBlock) {
    // Square of the sine of an angle below which two segments count as parallel, and what that may add, as a part of a segment.
    const PARALLEL: f32 = 1e-6;
    const ADDED: f32 = 2e-3;
    let axis = shape.to - shape.from;
    let axis_squared = larger(axis.dot(axis), f32::MIN_POSITIVE);
    for i in 0..LANES {
        let (from, way) = (segments.from.point(i) - shape.from, segments.way.point(i));
        let squared = larger(way.dot(way), f32::MIN_POSITIVE);
        let (along, out_of) = (way.dot(axis), way.dot(from));
        let beside = axis.dot(from);
        let across = squared * axis_squared - along * along;
        let is_parallel = across <= PARALLEL * squared * axis_squared;
        let divisor = if is_parallel { 1.0 } else { across };
        let at = (along * beside - out_of * axis_squared) / divisor;
        let at = if is_parallel { 0.5 } else { within(at) };
        let on_axis = within((along * at + beside) / axis_squared);
        let at = within((along * on_axis - out_of) / squared);
        let apart = from + way * at - axis * on_axis;
        out.at[i] = at;
        out.distance[i] = apart.dot(apart).sqrt() - shape.radius;
        out.least[i] = out.distance[i] - ADDED * squared.sqrt();
    }
}

/// Places of segments that are nearest to the half-space below the plane through the origin with this unit `normal`: the lower
/// ends, and the middle of what is level.
#[inline(always)]
pub fn nearest_to_half_space(normal: Vec3, segments: &SegmentBlock, out: &mut NearestBlock) {
    for i in 0..LANES {
        let (from, way) = (normal.dot(segments.from.point(i)), normal.dot(segments.way.point(i)));
        let at_end = if way < 0.0 { 1.0 } else { 0.0 };
        out.at[i] = if way == 0.0 { 0.5 } else { at_end };
        out.distance[i] = from + smaller(way, 0.0);
    }
    out.least = out.distance;
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

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        nearest_to_sphere(self.radius, segments, out);
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

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        nearest_to_capsule(&(*self).into(), segments, out);
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

    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        nearest_to_half_space(self.normal.as_vec3(), segments, out);
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
