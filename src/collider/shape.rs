//! The solids that a collider can be.

use std::sync::Arc;

use bevy::math::primitives::{Capsule3d, Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere, Torus};
use bevy::prelude::*;

use crate::sdf::shapes::{CapsuleBetween, Compound, HeightField, Rounded, Shell};
use crate::sdf::{DistanceField, SignedDistance};

/// The solid of an [`SdfCollider`](crate::SdfCollider), in its entity's frame.
///
/// With the feature `serialize`, fields and solids of one's own are refused by serde: the one is an asset, of
/// which to save the path, the other code.
#[derive(Reflect, Clone, Debug)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, Clone)]
pub enum SdfShape {
    /// A ball.
    Sphere(
        #[cfg_attr(
            feature = "serialize",
            serde(with = "bevy_drape_core::serialize::SphereFields")
        )]
        Sphere,
    ),
    /// A box.
    Cuboid(
        #[cfg_attr(
            feature = "serialize",
            serde(with = "bevy_drape_core::serialize::CuboidFields")
        )]
        Cuboid,
    ),
    /// A capsule along y.
    Capsule3d(
        #[cfg_attr(
            feature = "serialize",
            serde(with = "bevy_drape_core::serialize::Capsule3dFields")
        )]
        Capsule3d,
    ),
    /// A capsule between any two points, such as the ends of a bone.
    CapsuleBetween(CapsuleBetween),
    /// The half-space below a plane.
    InfinitePlane3d(
        #[cfg_attr(
            feature = "serialize",
            serde(with = "bevy_drape_core::serialize::InfinitePlane3dFields")
        )]
        InfinitePlane3d,
    ),
    /// A cylinder along y.
    Cylinder(
        #[cfg_attr(
            feature = "serialize",
            serde(with = "bevy_drape_core::serialize::CylinderFields")
        )]
        Cylinder,
    ),
    /// A ring around y.
    Torus(
        #[cfg_attr(feature = "serialize", serde(with = "bevy_drape_core::serialize::TorusFields"))]
        Torus,
    ),
    /// A cone along y.
    Cone(
        #[cfg_attr(feature = "serialize", serde(with = "bevy_drape_core::serialize::ConeFields"))]
        Cone,
    ),
    /// A mesh, baked to a field; `asset_server.load("rock.sdf")` loads a saved one. Left out until it is
    /// there.
    #[cfg_attr(feature = "serialize", serde(skip))]
    Field(Handle<DistanceField>),
    /// Anything else.
    #[cfg_attr(feature = "serialize", serde(skip))]
    Custom(CustomSdf),
}

/// A solid of one's own.
#[derive(Reflect, Clone, Debug, Deref)]
#[reflect(opaque, Debug, Clone)]
pub struct CustomSdf(pub Arc<dyn SignedDistance>);

impl SdfShape {
    /// Whether it is the same solid: by its numbers, or by what it points to.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Sphere(a), Self::Sphere(b)) => a == b,
            (Self::Cuboid(a), Self::Cuboid(b)) => a == b,
            (Self::Capsule3d(a), Self::Capsule3d(b)) => a == b,
            (Self::CapsuleBetween(a), Self::CapsuleBetween(b)) => a == b,
            (Self::InfinitePlane3d(a), Self::InfinitePlane3d(b)) => a == b,
            (Self::Cylinder(a), Self::Cylinder(b)) => a == b,
            (Self::Torus(a), Self::Torus(b)) => a == b,
            (Self::Cone(a), Self::Cone(b)) => a == b,
            (Self::Field(a), Self::Field(b)) => a == b,
            (Self::Custom(a), Self::Custom(b)) => Arc::ptr_eq(&a.0, &b.0),
            _ => false,
        }
    }

    /// The solid itself, to ask for distances; `None` while its field is not there.
    pub fn get<'a>(
        &'a self,
        fields: Option<&'a Assets<DistanceField>>,
    ) -> Option<&'a dyn SignedDistance> {
        Some(match self {
            Self::Sphere(shape) => shape,
            Self::Cuboid(shape) => shape,
            Self::Capsule3d(shape) => shape,
            Self::CapsuleBetween(shape) => shape,
            Self::InfinitePlane3d(shape) => shape,
            Self::Cylinder(shape) => shape,
            Self::Torus(shape) => shape,
            Self::Cone(shape) => shape,
            Self::Field(field) => fields?.get(field)?,
            Self::Custom(shape) => &*shape.0,
        })
    }

    /// The solid itself, to keep; `None` if it is a field.
    #[cfg(any(feature = "avian", feature = "rapier"))]
    pub(crate) fn to_solid(&self) -> Option<Arc<dyn SignedDistance>> {
        Some(match self {
            Self::Sphere(shape) => Arc::new(*shape),
            Self::Cuboid(shape) => Arc::new(*shape),
            Self::Capsule3d(shape) => Arc::new(*shape),
            Self::CapsuleBetween(shape) => Arc::new(*shape),
            Self::InfinitePlane3d(shape) => Arc::new(*shape),
            Self::Cylinder(shape) => Arc::new(*shape),
            Self::Torus(shape) => Arc::new(*shape),
            Self::Cone(shape) => Arc::new(*shape),
            Self::Field(_) => return None,
            Self::Custom(shape) => shape.0.clone(),
        })
    }
}

macro_rules! from_shapes {
    ($($variant:ident($shape:ty)),* $(,)?) => {
        $(impl From<$shape> for SdfShape {
            fn from(shape: $shape) -> Self {
                Self::$variant(shape)
            }
        })*
    };
}

from_shapes!(
    Sphere(Sphere),
    Cuboid(Cuboid),
    Capsule3d(Capsule3d),
    CapsuleBetween(CapsuleBetween),
    InfinitePlane3d(InfinitePlane3d),
    Cylinder(Cylinder),
    Torus(Torus),
    Cone(Cone),
    Field(Handle<DistanceField>),
    Custom(CustomSdf),
);

impl From<Arc<dyn SignedDistance>> for SdfShape {
    fn from(shape: Arc<dyn SignedDistance>) -> Self {
        Self::Custom(CustomSdf(shape))
    }
}

macro_rules! from_custom_shapes {
    ($($shape:ty),* $(,)?) => {
        $(impl From<$shape> for SdfShape {
            fn from(shape: $shape) -> Self {
                Self::Custom(CustomSdf(Arc::new(shape)))
            }
        })*
    };
}

from_custom_shapes!(Rounded, Compound, HeightField, Shell);
