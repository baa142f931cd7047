//! Whether anything may have changed of what is asked of each collider in each tick, and is seldom otherwise than before.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::cloth::pins::ClothPins;
use crate::collider::mass::{ColliderBody, ColliderMass};
use crate::engines::adapted::Adapted;
use crate::engines::engine::Engine;

/// Tells whether colliders may be of other bodies than when the system last ran, or their bodies of another kind.
#[derive(SystemParam)]
pub(crate) struct BodyChanges<'w, 's, E: Engine> {
    parents: Query<'w, 's, (), Changed<ChildOf>>,
    bodies: Query<'w, 's, (), Changed<<E as Engine>::Body>>,
    disabled: Query<'w, 's, (), Added<<E as Engine>::BodyDisabled>>,
    no_children: RemovedComponents<'w, 's, ChildOf>,
    no_bodies: RemovedComponents<'w, 's, <E as Engine>::Body>,
    enabled: RemovedComponents<'w, 's, <E as Engine>::BodyDisabled>,
}

impl<E: Engine> BodyChanges<'_, '_, E> {
    /// Asked once a run: what was removed is read by it.
    pub fn any(&mut self) -> bool {
        let removed = self.no_children.read().count()
            + self.no_bodies.read().count()
            + self.enabled.read().count();
        let is_same = self.parents.is_empty() && self.bodies.is_empty() && self.disabled.is_empty();
        removed > 0 || !is_same
    }
}

/// Tells whether the friction of colliders may be another than when the system last ran.
#[derive(SystemParam)]
pub(crate) struct FrictionChanges<'w, 's, E: Engine> {
    bodies: BodyChanges<'w, 's, E>,
    changed: Query<'w, 's, (), Changed<<E as Engine>::Friction>>,
    removed: RemovedComponents<'w, 's, <E as Engine>::Friction>,
}

impl<E: Engine> FrictionChanges<'_, '_, E> {
    /// Asked once a run: what was removed is read by it.
    pub fn any(&mut self) -> bool {
        let removed = self.removed.read().count();
        // Asked in any case, so that it has read.
        let others = self.bodies.any();
        removed > 0 || others || !self.changed.is_empty()
    }
}

/// Tells whether cloths may move other bodies than when the system last ran.
#[derive(SystemParam)]
pub(crate) struct CouplingChanges<'w, 's, E: Engine> {
    bodies: BodyChanges<'w, 's, E>,
    adapted: Query<'w, 's, (), Or<(Changed<Adapted>, Changed<ColliderBody>, Changed<ClothPins>)>>,
    not_adapted: RemovedComponents<'w, 's, Adapted>,
    no_parts: RemovedComponents<'w, 's, ColliderBody>,
    not_pinned: RemovedComponents<'w, 's, ClothPins>,
    no_masses: RemovedComponents<'w, 's, ColliderMass>,
}

impl<E: Engine> CouplingChanges<'_, '_, E> {
    /// Asked once a run: what was removed is read by it.
    pub fn any(&mut self) -> bool {
        let removed = self.not_adapted.read().count()
            + self.no_parts.read().count()
            + self.not_pinned.read().count()
            + self.no_masses.read().count();
        // Both are asked, so that both have read.
        let others = self.bodies.any();
        removed > 0 || others || !self.adapted.is_empty()
    }
}
