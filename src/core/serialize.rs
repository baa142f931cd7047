//! How serde sees Bevy's shapes: by their fields.
//!
//! Bevy's own feature for it would compile all of Bevy anew; these few lines do not.
#![allow(missing_docs, reason = "each has the fields of the shape it is named after")]

use bevy_math::{Dir3, Vec3, primitives::*};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Sphere")]
pub struct SphereFields {
    radius: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cuboid")]
pub struct CuboidFields {
    half_size: Vec3,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Capsule3d")]
pub struct Capsule3dFields {
    radius: f32,
    half_length: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cylinder")]
pub struct CylinderFields {
    radius: f32,
    half_height: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Torus")]
pub struct TorusFields {
    minor_radius: f32,
    major_radius: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Cone")]
pub struct ConeFields {
    radius: f32,
    height: f32,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "InfinitePlane3d")]
pub struct InfinitePlane3dFields {
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
