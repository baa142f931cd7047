//! Places where the wind is another: boxes, balls and cones.

use bevy_math::primitives::{Cone, Cuboid, Sphere};
use bevy_math::{Mat3, Vec3};

use crate::sdf::{PointBlock, SignedDistance};
use crate::solver::contact::Pose;
use crate::solver::forces::wind::Place;
use crate::solver::simd::block::{Block3, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Least distance from the middle of a radial wind that has a direction \[m\].
const LEAST_DISTANCE: f32 = 1e-6;

/// Where the wind of a zone blows.
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum WindShape {
    /// In a box.
    Cuboid(
        #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::CuboidFields"))] Cuboid,
    ),
    /// In a ball.
    Sphere(
        #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::SphereFields"))] Sphere,
    ),
    /// In a cone along y, its tip at half its height above the middle.
    Cone(#[cfg_attr(feature = "serialize", serde(with = "crate::serialize::ConeFields"))] Cone),
}

macro_rules! from_shapes {
    ($($shape:ident),*) => {
        $(impl From<$shape> for WindShape {
            fn from(shape: $shape) -> Self {
                Self::$shape(shape)
            }
        })*
    };
}

from_shapes!(Cuboid, Sphere, Cone);

impl WindShape {
    fn solid(&self) -> &dyn SignedDistance {
        match self {
            Self::Cuboid(shape) => shape,
            Self::Sphere(shape) => shape,
            Self::Cone(shape) => shape,
        }
    }

    /// Distance from the middle to the farthest point \[m\].
    fn radius(&self) -> f32 {
        match self {
            Self::Cuboid(shape) => shape.half_size.length(),
            Self::Sphere(shape) => shape.radius,
            Self::Cone(shape) => Vec3::new(shape.radius, 0.5 * shape.height, 0.0).length(),
        }
    }

    /// Where a radial wind comes from.
    fn source(&self) -> Vec3 {
        match self {
            Self::Cone(shape) => Vec3::Y * (0.5 * shape.height),
            _ => Vec3::ZERO,
        }
    }

    /// Whether every size is above zero and finite.
    pub fn is_valid(&self) -> bool {
        self.sizes().into_iter().all(usable)
    }

    /// The first size that cannot be used; else the first of all \[m\].
    pub fn worst_size(&self) -> f32 {
        let sizes = self.sizes();
        sizes.into_iter().find(|&size| !usable(size)).unwrap_or(sizes[0])
    }

    fn sizes(&self) -> [f32; 3] {
        match self {
            Self::Cuboid(shape) => shape.half_size.to_array(),
            Self::Sphere(shape) => [shape.radius; 3],
            Self::Cone(shape) => [shape.radius, shape.height, shape.height],
        }
    }
}

fn usable(size: f32) -> bool {
    size > 0.0 && size <= 1e7
}

/// Which way the wind of a zone blows, and how fast.
#[derive(Clone, Copy, Debug, PartialEq, bevy_reflect::Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub enum WindFlow {
    /// The same everywhere, a velocity \[m/s\] in the zone's own frame: it turns with the zone.
    Directional(Vec3),
    /// Away from the middle of the zone, of a cone from its tip, at this speed \[m/s\]. Below zero
    /// towards it.
    Radial(f32),
}

impl WindFlow {
    /// The highest speed \[m/s\].
    pub fn speed(&self) -> f32 {
        match self {
            Self::Directional(velocity) => velocity.length(),
            Self::Radial(speed) => speed.abs(),
        }
    }
}

/// A place where there is more wind than elsewhere, in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Where it blows, in the zone's own frame.
    pub shape: WindShape,
    /// Which way and how fast.
    pub flow: WindFlow,
    /// Depth below the border at which the wind has its full speed \[m\], in the zone's own frame.
    pub falloff: f32,
    /// Pose in world space.
    pub pose: Pose,
}

impl Zone {
    /// Speeds beyond this are refused \[m/s\].
    pub const FASTEST: f32 = 1e5;

    /// Whether every number can be used.
    pub fn is_valid(&self) -> bool {
        self.shape.is_valid()
            && self.flow.speed() <= Self::FASTEST
            && self.falloff >= 0.0
            && self.falloff <= 1e7
            && self.pose.is_valid()
    }

    /// Whether any of the zone can be in a box.
    pub(super) fn meets(&self, place: &Place) -> bool {
        let centre = self.pose.translation - place.origin;
        let nearest = centre.clamp(place.min, place.max);
        let reach = self.shape.radius() * self.pose.scale;
        centre.distance_squared(nearest) <= reach * reach
    }

    /// Whether any of the zone can be in a box of the world, given by its corners.
    pub fn reaches(&self, (min, max): (Vec3, Vec3)) -> bool {
        self.meets(&Place { origin: Vec3::ZERO, min, max })
    }

    /// The zone as seen from an origin.
    pub(super) fn seen_from(&self, origin: Vec3) -> Local<'_> {
        Local {
            zone: self,
            middle: self.pose.translation - origin,
            to_world: Mat3::from_quat(self.pose.rotation),
            inverse_scale: 1.0 / self.pose.scale,
            source: self.shape.source(),
        }
    }
}

/// A zone in the coordinates of a cloth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local<'a> {
    zone: &'a Zone,
    middle: Vec3,
    to_world: Mat3,
    inverse_scale: f32,
    source: Vec3,
}

impl Local<'_> {
    /// The wind at a place \[m/s\].
    pub fn at(&self, place: Vec3) -> Vec3 {
        let own = self.own(place);
        self.wind(own, self.zone.shape.solid().distance(own))
    }

    /// A place in the zone's own frame.
    #[inline(always)]
    fn own(&self, place: Vec3) -> Vec3 {
        let away = place - self.middle;
        let Mat3 { x_axis, y_axis, z_axis } = self.to_world;
        Vec3::new(x_axis.dot(away), y_axis.dot(away), z_axis.dot(away)) * self.inverse_scale
    }

    /// The wind at a place of the zone's own frame, at a distance from its border.
    #[inline(always)]
    fn wind(&self, own: Vec3, distance: f32) -> Vec3 {
        let depth = -distance;
        let part = if depth < self.zone.falloff { depth / self.zone.falloff } else { 1.0 };
        let part = if depth > 0.0 { part } else { 0.0 };
        let smooth = part * part * (3.0 - 2.0 * part);
        let velocity = match self.zone.flow {
            WindFlow::Directional(velocity) => velocity,
            WindFlow::Radial(speed) => {
                let away = own - self.source;
                away * (speed / larger(away.dot(away).sqrt(), LEAST_DISTANCE))
            }
        };
        let Mat3 { x_axis, y_axis, z_axis } = self.to_world;
        (x_axis * velocity.x + y_axis * velocity.y + z_axis * velocity.z) * smooth
    }
}

/// Adds the wind of a zone.
pub(super) struct AddZone<'a> {
    pub zone: Local<'a>,
    pub places: &'a Soa,
    pub wind: &'a mut Soa,
}

impl Kernel for AddZone<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let solid = self.zone.zone.shape.solid();
        let mut points = PointBlock::default();
        let mut distances = [0.0; LANES];
        for at in (0..self.places.x.len()).step_by(LANES) {
            let places = Block3::load(self.places, at);
            for i in 0..LANES {
                let own = self.zone.own(places.at(i));
                (points.x[i], points.y[i], points.z[i]) = (own.x, own.y, own.z);
            }
            solid.distance_block(&points, &mut distances);
            let mut wind = Block3::load(self.wind, at);
            for (i, &distance) in distances.iter().enumerate() {
                wind.set(i, wind.at(i) + self.zone.wind(points.point(i), distance));
            }
            wind.store(self.wind, at);
        }
    }
}
