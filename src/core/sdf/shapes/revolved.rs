//! Cylinder, torus and cone: solids of revolution, solved in the half-plane of radius and height.

use super::{Kernel, centred, larger, length_and_direction, smaller, to_sample};
use crate::sdf::{KnownShape, LANES, PointBlock, SampleBlock, SdfSample, SignedDistance};
use bevy_math::{
    Vec3,
    bounding::Aabb3d,
    primitives::{Cone, Cylinder, Torus},
};

/// A profile's distance, and its normal as `[radial, vertical, unused]`.
type Profile = Kernel;

/// Solves `profile` at the point's radius and height and turns its normal back into space.
#[inline(always)]
fn revolve(point: Vec3, profile: impl FnOnce(f32, f32) -> Profile) -> Kernel {
    // On the axis every way across is as good.
    let (radius, across) = length_and_direction([point.x, 0.0, point.z], [1.0, 0.0, 0.0]);
    let (distance, [radial, vertical, _]) = profile(radius, point.y);
    (distance, [across[0] * radial, vertical, across[2] * radial])
}

/// [`revolve`] at a block of points.
#[inline(always)]
fn revolve_block(
    points: &PointBlock,
    out: &mut SampleBlock,
    profile: impl Fn(f32, f32) -> Profile + Copy,
) {
    for lane in 0..LANES {
        let (distance, normal) = revolve(points.point(lane), profile);
        out.set(lane, distance, normal);
    }
}

/// Distances alone of [`revolve`] at a block of points.
#[inline(always)]
fn revolve_distances(
    points: &PointBlock,
    out: &mut [f32; LANES],
    profile: impl Fn(f32, f32) -> Profile + Copy,
) {
    for (lane, distance) in out.iter_mut().enumerate() {
        *distance = revolve(points.point(lane), profile).0;
    }
}

#[inline(always)]
fn cylinder(shape: &Cylinder, radius: f32, height: f32) -> Profile {
    let beyond_side = radius - shape.radius;
    let beyond_cap = height.abs() - shape.half_height;
    let nearest = if beyond_cap >= beyond_side { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
    let outside = [larger(beyond_side, 0.0), larger(beyond_cap, 0.0), 0.0];
    let (length, normal) = length_and_direction(outside, nearest);
    let distance = length + smaller(larger(beyond_side, beyond_cap), 0.0);
    (distance, [normal[0], normal[1].copysign(height), 0.0])
}

#[inline(always)]
fn torus(shape: &Torus, radius: f32, height: f32) -> Profile {
    let (length, normal) =
        length_and_direction([radius - shape.major_radius, height, 0.0], [0.0, 1.0, 0.0]);
    (length - shape.minor_radius, normal)
}

/// What is the same of a cone wherever it is asked.
#[derive(Clone, Copy)]
struct ConeProfile {
    radius: f32,
    half_height: f32,
    /// Length of a line down the side \[m\].
    slant: f32,
    side_normal: [f32; 3],
    /// Whether it is a point, which has no sides.
    is_point: bool,
}

impl ConeProfile {
    #[inline(always)]
    fn new(&Cone { radius, height }: &Cone) -> Self {
        let slant_squared = radius * radius + height * height;
        let is_point = slant_squared < f32::MIN_POSITIVE;
        let slant = if is_point { 1.0 } else { slant_squared.sqrt() };
        let side_normal = [height / slant, radius / slant, 0.0];
        Self { radius, half_height: 0.5 * height, slant, side_normal, is_point }
    }

    #[inline(always)]
    fn at(self, radius: f32, height: f32) -> Profile {
        let Self { half_height, slant, side_normal, .. } = self;
        let below_tip = half_height - height;
        let tip = length_and_direction([radius, -below_tip, 0.0], [0.0, 1.0, 0.0]);

        let beyond_side = radius * side_normal[0] - below_tip * side_normal[1];
        let beyond_base = -half_height - height;
        // How far down the side, from the tip, the foot of the perpendicular lies.
        let along_side = radius * side_normal[1] + below_tip * side_normal[0];
        let side = (beyond_side, side_normal);
        let base = (beyond_base, [0.0, -1.0, 0.0]);
        let rim =
            length_and_direction([radius - self.radius, height + half_height, 0.0], side_normal);

        // A convex polygon: inside, the nearest side line is the nearest side. Outside, exactly one of side, base, tip and rim has
        // the point in its normal cone.
        let is_inside = beyond_side <= 0.0 && beyond_base <= 0.0;
        let is_off_side = beyond_side > 0.0 && along_side >= 0.0 && along_side <= slant;
        let is_off_base = beyond_base > 0.0 && radius <= self.radius;
        let inside = pick(beyond_base >= beyond_side, base, side);
        let at_end = pick(along_side < 0.0, tip, rim);
        let outside = pick(is_off_side, side, pick(is_off_base, base, at_end));
        pick(self.is_point, tip, pick(is_inside, inside, outside))
    }
}

/// One profile or the other, number by number: so it is done in lanes.
#[inline(always)]
fn pick(first: bool, a: Profile, b: Profile) -> Profile {
    let pick = |a: f32, b: f32| if first { a } else { b };
    (pick(a.0, b.0), [pick(a.1[0], b.1[0]), pick(a.1[1], b.1[1]), 0.0])
}

/// [`Cylinder`] at a block of points.
#[inline(always)]
pub fn cylinder_block(shape: &Cylinder, points: &PointBlock, out: &mut SampleBlock) {
    revolve_block(
        points,
        out,
        #[inline(always)]
        |radius, height| cylinder(shape, radius, height),
    );
}

/// Distance alone \[m\] of a [`Cylinder`].
#[inline(always)]
pub fn cylinder_distance_block(shape: &Cylinder, points: &PointBlock, out: &mut [f32; LANES]) {
    revolve_distances(
        points,
        out,
        #[inline(always)]
        |radius, height| cylinder(shape, radius, height),
    );
}

/// [`Torus`] at a block of points.
#[inline(always)]
pub fn torus_block(shape: &Torus, points: &PointBlock, out: &mut SampleBlock) {
    revolve_block(
        points,
        out,
        #[inline(always)]
        |radius, height| torus(shape, radius, height),
    );
}

/// Distance alone \[m\] of a [`Torus`].
#[inline(always)]
pub fn torus_distance_block(shape: &Torus, points: &PointBlock, out: &mut [f32; LANES]) {
    revolve_distances(
        points,
        out,
        #[inline(always)]
        |radius, height| torus(shape, radius, height),
    );
}

/// [`Cone`] at a block of points.
#[inline(always)]
pub fn cone_block(shape: &Cone, points: &PointBlock, out: &mut SampleBlock) {
    let profile = ConeProfile::new(shape);
    revolve_block(
        points,
        out,
        #[inline(always)]
        |radius, height| profile.at(radius, height),
    );
}

/// Distance alone \[m\] of a [`Cone`].
#[inline(always)]
pub fn cone_distance_block(shape: &Cone, points: &PointBlock, out: &mut [f32; LANES]) {
    let profile = ConeProfile::new(shape);
    revolve_distances(
        points,
        out,
        #[inline(always)]
        |radius, height| profile.at(radius, height),
    );
}

impl SignedDistance for Cylinder {
    fn sample(&self, point: Vec3) -> SdfSample {
        to_sample(revolve(point, |radius, height| cylinder(self, radius, height)))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        cylinder_block(self, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        cylinder_distance_block(self, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Cylinder(self))
    }

    fn core_depth(&self) -> f32 {
        self.radius.min(self.half_height)
    }

    fn bounds(&self) -> Option<Aabb3d> {
        centred(Vec3::new(self.radius, self.half_height, self.radius))
    }
}

/// Exact where the tube does not overlap itself (`minor_radius <= major_radius`); elsewhere outside only.
impl SignedDistance for Torus {
    fn sample(&self, point: Vec3) -> SdfSample {
        to_sample(revolve(point, |radius, height| torus(self, radius, height)))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        torus_block(self, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        torus_distance_block(self, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Torus(self))
    }

    fn core_depth(&self) -> f32 {
        self.minor_radius
    }

    fn least_radius(&self) -> f32 {
        self.minor_radius
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let across = self.major_radius + self.minor_radius;
        centred(Vec3::new(across, self.minor_radius, across))
    }
}

impl SignedDistance for Cone {
    fn sample(&self, point: Vec3) -> SdfSample {
        let profile = ConeProfile::new(self);
        to_sample(revolve(point, |radius, height| profile.at(radius, height)))
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        cone_block(self, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        cone_distance_block(self, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::Cone(self))
    }

    fn bounds(&self) -> Option<Aabb3d> {
        centred(Vec3::new(self.radius, 0.5 * self.height, self.radius))
    }
}
