//! How serde sees what is not ours: entities as Bevy has them, and shapes by their fields.
//!
//! Bevy's own feature for it would compile all of Bevy anew; these few lines do not.

use bevy::prelude::*;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

/// An entity, as the number that Bevy makes of it.
pub(crate) mod entity {
    use super::*;

    pub fn serialize<S: Serializer>(entity: &Entity, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u64(entity.to_bits())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Entity, D::Error> {
        let bits = u64::deserialize(from)?;
        Entity::try_from_bits(bits).ok_or_else(|| D::Error::custom("no entity has this number"))
    }
}

/// An entity, or none.
pub(crate) mod entity_option {
    use super::*;

    pub fn serialize<S: Serializer>(entity: &Option<Entity>, to: S) -> Result<S::Ok, S::Error> {
        entity.map(Entity::to_bits).serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Entity>, D::Error> {
        let bits = Option::<u64>::deserialize(from)?;
        let entity = |bits| {
            Entity::try_from_bits(bits).ok_or_else(|| D::Error::custom("no entity has this number"))
        };
        bits.map(entity).transpose()
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Sphere")]
pub(crate) struct SphereFields {
    radius: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cuboid")]
pub(crate) struct CuboidFields {
    half_size: Vec3,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Capsule3d")]
pub(crate) struct Capsule3dFields {
    radius: f32,
    half_length: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cylinder")]
pub(crate) struct CylinderFields {
    radius: f32,
    half_height: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Torus")]
pub(crate) struct TorusFields {
    minor_radius: f32,
    major_radius: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cone")]
pub(crate) struct ConeFields {
    radius: f32,
    height: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "InfinitePlane3d")]
pub(crate) struct InfinitePlane3dFields {
    #[serde(with = "direction")]
    normal: Dir3,
}

/// A direction, as its vector.
mod direction {
    use super::*;

    pub fn serialize<S: Serializer>(direction: &Dir3, to: S) -> Result<S::Ok, S::Error> {
        direction.as_vec3().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Dir3, D::Error> {
        let vector = Vec3::deserialize(from)?;
        // What has a length of one keeps its bits.
        if vector.is_normalized() {
            return Ok(Dir3::new_unchecked(vector));
        }
        Dir3::new(vector).map_err(|problem| D::Error::custom(format!("no direction: {problem}")))
    }
}

/// Lets serde read and write a structure of one field in a form that has a version: a state of another one is
/// refused with the versions that can be read.
macro_rules! versioned {
    ($type:ident, $field:ident: $content:ty) => {
        const _: () = {
            #[derive(serde::Serialize)]
            enum Write<'a> {
                V1(&'a $content),
            }

            #[derive(serde::Deserialize)]
            enum Read {
                V1($content),
            }

            impl serde::Serialize for $type {
                fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                    Write::V1(&self.$field).serialize(to)
                }
            }

            impl<'de> serde::Deserialize<'de> for $type {
                fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                    let Read::V1($field) = Read::deserialize(from)?;
                    Ok(Self { $field })
                }
            }
        };
    };
}

pub(crate) use versioned;
