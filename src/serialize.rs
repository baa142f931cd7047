//! How serde sees what is not ours: entities as Bevy has them.
//!
//! Bevy's own feature for it would compile all of Bevy anew; these few lines do not.

use bevy::prelude::*;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

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
