//! Which colliders can be used: their numbers, checked at the door.

use bevy::prelude::*;

use crate::collider::SdfCollider;
use crate::collider::shape::SdfShape;
use crate::sdf::SignedDistance;
use crate::solver::ParameterError;

/// Smallest and largest length of a solid \[m\]: squares of both are well within `f32`.
const LENGTHS: core::ops::RangeInclusive<f32> = 1e-6..=1e7;

impl SdfCollider {
    /// Checks every number.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        let usable = (0.0..=1e3).contains(&self.friction);
        check("friction", self.friction, usable, "from 0 to 1000")?;
        self.shape.check()
    }
}

impl SdfShape {
    /// Checks every number. What a field holds was checked when it was baked or read.
    pub(crate) fn check(&self) -> Result<(), ParameterError> {
        match self {
            Self::Sphere(sphere) => length("the sphere's radius", sphere.radius),
            Self::Cuboid(cuboid) => {
                length("the cuboid's half size along x", cuboid.half_size.x)?;
                length("the cuboid's half size along y", cuboid.half_size.y)?;
                length("the cuboid's half size along z", cuboid.half_size.z)
            }
            Self::Capsule3d(capsule) => {
                length("the capsule's radius", capsule.radius)?;
                length_or_zero("the capsule's half length", capsule.half_length)
            }
            Self::CapsuleBetween(capsule) => {
                length("the capsule's radius", capsule.radius)?;
                place("the capsule's first end", capsule.from)?;
                place("the capsule's second end", capsule.to)
            }
            Self::InfinitePlane3d(plane) => {
                let value = plane.normal.length();
                let range = "1, a direction";
                check("the length of the plane's normal", value, (value - 1.0).abs() < 1e-3, range)
            }
            Self::Cylinder(cylinder) => {
                length("the cylinder's radius", cylinder.radius)?;
                length("the cylinder's half height", cylinder.half_height)
            }
            Self::Torus(torus) => {
                length("the torus's minor radius", torus.minor_radius)?;
                length_or_zero("the torus's major radius", torus.major_radius)
            }
            Self::Cone(cone) => {
                length("the cone's radius", cone.radius)?;
                length("the cone's height", cone.height)
            }
            Self::Field(_) => Ok(()),
            Self::Custom(shape) => check_custom(&*shape.0),
        }
    }
}

/// Checks what the solver takes on trust from a custom solid.
fn check_custom(shape: &dyn SignedDistance) -> Result<(), ParameterError> {
    let excess = shape.overestimate();
    let sound = excess >= 0.0 && excess.is_finite();
    check("the custom solid's overestimate", excess, sound, "from 0 m, and finite")?;
    let Some(bounds) = shape.bounds() else {
        return Ok(());
    };
    let size = Vec3::from(bounds.max) - Vec3::from(bounds.min);
    let sound = size.is_finite() && size.min_element() >= 0.0;
    let range = "from 0 m, and finite, or `bounds` be `None`";
    check("the least side of the custom solid's bounds", size.min_element(), sound, range)
}

fn length(name: &'static str, value: f32) -> Result<(), ParameterError> {
    check(name, value, LENGTHS.contains(&value), "from 1e-6 to 1e7 m")
}

fn place(name: &'static str, value: Vec3) -> Result<(), ParameterError> {
    // The first coordinate that is out of range, or not a number.
    let out = value.to_array().into_iter().find(|c| c.is_nan() || c.abs() > *LENGTHS.end());
    check(name, out.unwrap_or_default(), out.is_none(), "within 1e7 m of the entity")
}

fn length_or_zero(name: &'static str, value: f32) -> Result<(), ParameterError> {
    check(name, value, (0.0..=*LENGTHS.end()).contains(&value), "from 0 to 1e7 m")
}

fn check(
    name: &'static str,
    value: f32,
    sound: bool,
    range: &'static str,
) -> Result<(), ParameterError> {
    if sound { Ok(()) } else { Err(ParameterError { name, value, range }) }
}
