//! Which entities may have moved.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::pose::root::Root;

/// Tells which entities may be elsewhere than when the system last ran.
#[derive(SystemParam)]
pub(crate) struct Moves<'w, 's> {
    places: Query<'w, 's, (Ref<'static, Transform>, Option<Ref<'static, ChildOf>>)>,
    orphans: RemovedComponents<'w, 's, ChildOf>,
}

impl Moves<'_, '_> {
    /// Whether any entity has lost its parent, and may have moved by that.
    pub fn any_orphan(&mut self) -> bool {
        self.orphans.read().count() > 0
    }

    /// Whether a collider or an ancestor of it was changed. Inlined, as it is asked of all that stand still.
    #[inline(always)]
    pub fn moved_one(
        &self,
        entity: Entity,
        place: Option<&Ref<Transform>>,
        has_parent: bool,
    ) -> bool {
        match place {
            Some(place) if !has_parent => place.is_changed(),
            _ => self.moved(entity),
        }
    }

    /// The root of an entity.
    pub fn root(&self, entity: Entity) -> Root {
        Root::of(entity, |it| {
            let (place, parent) = self.places.get(it).ok()?;
            Some((*place, parent.map(|parent| parent.parent())))
        })
    }

    /// Whether this entity or an ancestor was changed.
    pub fn moved(&self, entity: Entity) -> bool {
        let mut at = entity;
        loop {
            let Ok((place, parent)) = self.places.get(at) else {
                return true;
            };
            if place.is_changed() {
                return true;
            }
            match parent {
                Some(parent) if parent.is_changed() => return true,
                Some(parent) => at = parent.parent(),
                None => return false,
            }
        }
    }
}
