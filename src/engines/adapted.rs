//! What is known of a collider that is adapted.

use bevy::prelude::*;

use crate::engines::ClothCollider;
use crate::engines::solid::EngineSolid;

/// Is on a collider whose `SdfCollider` is kept here, or would be if it could be used.
#[derive(Component)]
pub(crate) struct Adapted {
    pub(super) engine: &'static str,
    /// What was asked for.
    pub(super) wish: ClothCollider,
    /// `None` where it cannot be used.
    pub(super) solid: Option<(EngineSolid, f32)>,
    /// Whether something of it is still baked.
    pub(super) waits: bool,
    /// Whether an `SdfCollider` is inserted with it, which is then not the user's.
    pub(super) brings: bool,
}

impl Adapted {
    /// Whether it is a collider of an engine.
    pub fn is_of(&self, engine: &str) -> bool {
        self.engine == engine
    }

    /// Whether cloths move its body, if it is of this engine.
    pub fn moves(&self, engine: &str) -> bool {
        self.is_of(engine) && self.solid.is_some() && !self.wish.one_way
    }

    /// Whether something of it is baked, and not yet there.
    pub(super) fn is_waiting(&self) -> bool {
        let solid = self.solid.as_ref().filter(|_| self.waits);
        solid.is_some_and(|(solid, _)| matches!(solid.shape(), Ok(None)))
    }

    /// Whether the collider has what it is to have.
    pub(super) fn is_given(&self, has_solid: bool) -> bool {
        !self.waits && (self.solid.is_none() || has_solid)
    }
}
