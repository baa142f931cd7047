//! Signed distance: pure geometry, no ECS, no clock.
//!
//! A collider is anything that says how far a point is from its surface and which way is out:
//! [`SignedDistance`]. Two kinds are here.
//!
//! - [`shapes`]: exact distances of `bevy_math`'s own primitives ([`Sphere`], [`Cuboid`],
//!   [`Capsule3d`], [`InfinitePlane3d`], [`Cylinder`], [`Torus`], [`Cone`]); the trait is implemented on them
//!   directly. [`Rounded`] swells a solid, [`Compound`] puts several together, [`HeightField`] is ground, and [`Shell`] a surface
//!   with a thickness.
//! - [`DistanceField`]: a grid of distances to a closed triangle mesh, made once by
//!   [`DistanceField::bake`], or read from a file ([`DistanceField::from_bytes`]), and looked up with
//!   trilinear interpolation.
//!
//! Points are in the collider's own frame, lengths in metres. Sampling uses `+ - * /` and square roots
//! only, never a fused or a transcendental operation, so it gives the same bits wherever it runs, one
//! point at a time or [`LANES`] at once.
//!
//! [`Torus`]: bevy_math::primitives::Torus
//! [`Cone`]: bevy_math::primitives::Cone
//! [`Rounded`]: shapes::Rounded
//! [`Compound`]: shapes::Compound
//! [`HeightField`]: shapes::HeightField
//! [`Shell`]: shapes::Shell

#![forbid(unsafe_code)]

mod bake;
mod field;
mod file;
pub mod fit;
mod lookup;
mod segments;
pub mod shapes;

pub use bake::{BakeError, BakeSettings, MAX_NODES};
pub use field::DistanceField;
pub use file::SavedFieldError;
pub use lookup::{field_block, field_distance_block};
pub use segments::{NearestBlock, SegmentBlock};

use bevy_math::{
    Vec3,
    bounding::Aabb3d,
    primitives::{Capsule3d, Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere, Torus},
};

/// Number of points in a block.
///
/// One AVX-512 register, two of AVX2, four of SSE2.
pub const LANES: usize = 16;

/// The surface of a solid, as seen from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SdfSample {
    /// Distance to the surface \[m\]. Negative inside.
    pub distance: f32,
    /// Direction in which the distance grows fastest: unit length, outward.
    ///
    /// Where no single direction does (a centre, a medial axis) it is one of the shortest ways out, or
    /// [`Vec3::Y`]; it is never NaN.
    pub normal: Vec3,
}

/// [`LANES`] points \[m\] as a structure of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct PointBlock {
    /// First coordinates \[m\].
    pub x: [f32; LANES],
    /// Second coordinates \[m\].
    pub y: [f32; LANES],
    /// Third coordinates \[m\].
    pub z: [f32; LANES],
}

impl PointBlock {
    /// The point in one lane.
    ///
    /// # Panics
    ///
    /// If `lane` is not below [`LANES`].
    #[inline(always)]
    pub fn point(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Sets the point in one lane.
    ///
    /// # Panics
    ///
    /// If `lane` is not below [`LANES`].
    #[inline(always)]
    pub fn set(&mut self, lane: usize, point: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (point.x, point.y, point.z);
    }
}

/// [`LANES`] samples as a structure of arrays; see [`SdfSample`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct SampleBlock {
    /// Distances to the surface \[m\]. Negative inside.
    pub distance: [f32; LANES],
    /// First components of the normals.
    pub nx: [f32; LANES],
    /// Second components of the normals.
    pub ny: [f32; LANES],
    /// Third components of the normals.
    pub nz: [f32; LANES],
}

impl SampleBlock {
    /// Writes one lane.
    #[inline(always)]
    fn set(&mut self, lane: usize, distance: f32, normal: [f32; 3]) {
        self.distance[lane] = distance;
        self.nx[lane] = normal[0];
        self.ny[lane] = normal[1];
        self.nz[lane] = normal[2];
    }
}

/// A solid known by the signed distance to its surface.
///
/// All points and lengths are in the solid's own frame \[m\]. A point with a coordinate that is NaN has a
/// distance that is NaN or infinite, so that `distance < epsilon` is false for it, and still a unit normal.
///
/// A block gives the same bits, lane by lane, as the single point does.
pub trait SignedDistance: Send + Sync + core::fmt::Debug + 'static {
    /// Distance \[m\] and normal at `point`.
    fn sample(&self, point: Vec3) -> SdfSample;

    /// Distance at `point` \[m\]: that of [`sample`](Self::sample), for less work where there is less.
    fn distance(&self, point: Vec3) -> f32 {
        self.sample(point).distance
    }

    /// [`sample`](Self::sample) at every point of a block.
    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        for lane in 0..LANES {
            let sample = self.sample(points.point(lane));
            out.set(lane, sample.distance, sample.normal.to_array());
        }
    }

    /// [`distance`](Self::distance) at every point of a block.
    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        for (lane, distance) in out.iter_mut().enumerate() {
            *distance = self.distance(points.point(lane));
        }
    }

    /// The place on each segment of a block that is nearest, and the distance there. All of `out` is written, lane by lane; a segment with a
    /// coordinate that is NaN is near to nothing.
    ///
    /// The default searches it by golden section, and finds it where the distance along a segment has one minimum, as around a convex
    /// solid. A shape that can compute it is both faster and exact.
    fn nearest_on_segments(&self, segments: &SegmentBlock, out: &mut NearestBlock) {
        segments::search(segments, out, |points, out| self.distance_block(points, out));
    }

    /// Smallest box around the surface \[m\], or `None` where there is none (a half-space).
    fn bounds(&self) -> Option<Aabb3d>;

    /// How deep a point may be \[m\] for the nearest way out still to be on the side where it came in.
    ///
    /// A particle that moves further than this in one substep is tested along its whole path.
    /// Zero, the default, is right for every shape; more saves work.
    fn core_depth(&self) -> f32 {
        0.0
    }

    /// Least radius of curvature of the surface \[m\], where it is convex; zero, the default, where it has edges or
    /// tips, or where that is not known.
    ///
    /// Between particles that are close together beside this radius, a cloth is held out of a solid by its particles
    /// alone. More saves work.
    fn least_radius(&self) -> f32 {
        0.0
    }

    /// Which of the known solids this is. Code that is compiled for an instruction set of its own can
    /// call their `*_block` functions, which are inlined into it.
    fn known(&self) -> Option<KnownShape<'_>> {
        None
    }

    /// How far [`distance`](Self::distance) may exceed the true distance, at most \[m\].
    ///
    /// Zero for a shape that is computed exactly (up to the rounding of `f32`). What skips points or
    /// traces rays by the distance subtracts this first.
    fn overestimate(&self) -> f32 {
        0.0
    }
}

/// A solid whose block functions are inlined where they are called.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum KnownShape<'a> {
    /// [`shapes::sphere_block`].
    Sphere(&'a Sphere),
    /// [`shapes::half_space_block`].
    HalfSpace(&'a InfinitePlane3d),
    /// [`shapes::capsule_block`].
    Capsule(&'a Capsule3d),
    /// [`shapes::capsule_between_block`].
    CapsuleBetween(&'a shapes::CapsuleBetween),
    /// [`shapes::cuboid_block`].
    Cuboid(&'a Cuboid),
    /// [`shapes::cylinder_block`].
    Cylinder(&'a Cylinder),
    /// [`shapes::torus_block`].
    Torus(&'a Torus),
    /// [`shapes::cone_block`].
    Cone(&'a Cone),
    /// [`field_block`].
    Field(&'a DistanceField),
    /// [`shapes::height_field_block`].
    HeightField(&'a shapes::HeightField),
    /// [`shapes::shell_block`].
    Shell(&'a shapes::Shell),
}

impl KnownShape<'_> {
    /// [`sample_block`](SignedDistance::sample_block) of the shape, inlined.
    #[inline(always)]
    pub fn sample_block(self, points: &PointBlock, out: &mut SampleBlock) {
        match self {
            Self::Sphere(s) => shapes::sphere_block(s.radius, points, out),
            Self::HalfSpace(s) => shapes::half_space_block(s.normal.as_vec3(), points, out),
            Self::Capsule(s) => shapes::capsule_block(s.radius, s.half_length, points, out),
            Self::CapsuleBetween(s) => shapes::capsule_between_block(s, points, out),
            Self::Cuboid(s) => shapes::cuboid_block(s.half_size, points, out),
            Self::Cylinder(s) => shapes::cylinder_block(s, points, out),
            Self::Torus(s) => shapes::torus_block(s, points, out),
            Self::Cone(s) => shapes::cone_block(s, points, out),
            Self::Field(field) => field_block(field, points, out),
            Self::HeightField(field) => shapes::height_field_block(field, points, out),
            Self::Shell(shell) => shapes::shell_block(shell, points, out),
        }
    }

    /// [`nearest_on_segments`](SignedDistance::nearest_on_segments) of the shape, inlined.
    #[inline(always)]
    pub fn nearest_on_segments(self, segments: &SegmentBlock, out: &mut NearestBlock) {
        match self {
            Self::Sphere(s) => shapes::nearest_to_sphere(s.radius, segments, out),
            Self::HalfSpace(s) => {
                shapes::nearest_to_half_space(s.normal.as_vec3(), segments, out);
            }
            Self::Capsule(s) => shapes::nearest_to_capsule(&(*s).into(), segments, out),
            Self::CapsuleBetween(s) => shapes::nearest_to_capsule(s, segments, out),
            Self::Cuboid(s) => segments::search(
                segments,
                out,
                #[inline(always)]
                |points, out| shapes::cuboid_distance_block(s.half_size, points, out),
            ),
            Self::Cylinder(s) => segments::search(
                segments,
                out,
                #[inline(always)]
                |points, out| shapes::cylinder_distance_block(s, points, out),
            ),
            Self::Torus(s) => segments::search(
                segments,
                out,
                #[inline(always)]
                |points, out| shapes::torus_distance_block(s, points, out),
            ),
            Self::Cone(s) => segments::search(
                segments,
                out,
                #[inline(always)]
                |points, out| shapes::cone_distance_block(s, points, out),
            ),
            Self::Field(field) => segments::search(
                segments,
                out,
                #[inline(always)]
                |points, out| field_distance_block(field, points, out),
            ),
            Self::HeightField(field) => segments::search(
                segments,
                out,
                #[inline(always)]
                |points, out| shapes::height_field_distance_block(field, points, out),
            ),
            Self::Shell(shell) => shapes::nearest_to_shell(shell, segments, out),
        }
    }
}
