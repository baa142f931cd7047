//! Exact signed distances of `bevy_math`'s primitives.
//!
//! Each shape is one kernel of a few lines without branches, used for single points and for blocks
//! alike, so both give the same bits. The `*_block` and `nearest_to_*` functions are inlined always: called from code that is
//! compiled for a wider instruction set, they become that set's instructions.
//!
//! Axes are those of `bevy_math`: [`Capsule3d`], [`Cylinder`] and [`Cone`] stand along Y, centred (the
//! cone's tip at `+height / 2`), and the [`Torus`] lies in the XZ plane. An [`InfinitePlane3d`] is the solid
//! half-space below the plane through the origin. Sizes are expected to be finite and not negative;
//! others give a meaningless distance, but no panic.
//!
//! Solids made of others or of many numbers, [`Rounded`], [`Compound`], [`HeightField`] and [`Shell`], say in their own
//! words where they are exact, and check what they are given.
//!
//! [`Capsule3d`]: bevy_math::primitives::Capsule3d
//! [`Cylinder`]: bevy_math::primitives::Cylinder
//! [`Cone`]: bevy_math::primitives::Cone
//! [`Torus`]: bevy_math::primitives::Torus
//! [`InfinitePlane3d`]: bevy_math::primitives::InfinitePlane3d

mod compound;
mod cuboid;
mod face;
mod height_field;
mod revolved;
mod round;
mod rounded;
mod shell;
mod tree;

pub use compound::{Compound, CompoundError, Part};
pub use cuboid::{cuboid_block, cuboid_distance_block};
pub use height_field::{
    HeightField, HeightFieldCell, HeightFieldError, height_field_block, height_field_distance_block,
};
pub use revolved::{
    cone_block, cone_distance_block, cylinder_block, cylinder_distance_block, torus_block,
    torus_distance_block,
};
pub use round::{
    CapsuleBetween, capsule_between_block, capsule_block, capsule_distance_block, half_space_block,
    half_space_distance_block, nearest_to_capsule, nearest_to_half_space, nearest_to_sphere,
    sphere_block, sphere_distance_block,
};
pub use rounded::Rounded;
pub use shell::{Shell, ShellError, nearest_to_shell, shell_block, shell_distance_block};

use super::SdfSample;
use bevy_math::{Vec3, bounding::Aabb3d};

/// Distance and normal, as a kernel returns them.
type Kernel = (f32, [f32; 3]);

/// The larger one, as one machine instruction; NaN if `a` is.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The smaller one, as one machine instruction; NaN if `a` is.
#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// Length and direction of `v`; `fallback` where `v` has no direction that `f32` can tell (or is NaN).
#[inline(always)]
pub(super) fn length_and_direction(v: [f32; 3], fallback: [f32; 3]) -> Kernel {
    let squared = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let length = squared.sqrt();
    let known = (f32::MIN_POSITIVE..=f32::MAX).contains(&squared);
    let inverse = 1.0 / length;
    let direction = [v[0] * inverse, v[1] * inverse, v[2] * inverse];
    (length, if known { direction } else { fallback })
}

/// A kernel's result as a sample.
#[inline(always)]
fn to_sample((distance, normal): Kernel) -> SdfSample {
    SdfSample { distance, normal: Vec3::new(normal[0], normal[1], normal[2]) }
}

/// The box of this half size around the origin; built plainly, since `Aabb3d::new` asserts on sizes.
fn centred(half_size: Vec3) -> Option<Aabb3d> {
    let half_size = half_size.abs();
    Some(Aabb3d { min: (-half_size).into(), max: half_size.into() })
}
