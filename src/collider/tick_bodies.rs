//! The bodies of a tick: which colliders are of one that cloths move, and how it answers.

use bevy::prelude::*;

use crate::collider::SdfCollider;
use crate::collider::mass::{BodyMemory, ColliderBody, ColliderMass};
use crate::collider::tick_colliders::TickColliders;
use crate::error::ClothComponent;
use crate::error::failures::{Blame, Failures};
use crate::pose::to_local;
use crate::solver::Mobility;

/// The body that a collider is a part of.
#[derive(Clone, Copy)]
pub(crate) struct TickBody {
    /// The entity with its `ColliderMass`.
    pub entity: Entity,
    /// How it answers to impulses; `None` while it sleeps.
    pub mobility: Option<Mobility>,
    /// Its centre of mass in the collider's frame \[m\].
    pub center_of_mass: Vec3,
    /// How many cloths are near it, each of which meets a part of it.
    pub cloths: u32,
}

impl TickBody {
    /// How it answers to one of the cloths that are near it.
    pub fn part(&self) -> Option<Mobility> {
        let Mobility { inverse_mass, inverse_inertia, .. } = self.mobility?;
        let cloths = self.cloths.max(1) as f32;
        let (inverse_mass, inverse_inertia) = (inverse_mass * cloths, inverse_inertia * cloths);
        Some(Mobility { inverse_mass, inverse_inertia, ..self.mobility? })
    }
}

/// A collider that may be of a body.
type Parts = (With<SdfCollider>, Or<(With<ColliderMass>, With<ColliderBody>)>);

/// Finds the bodies of the tick's colliders.
pub(crate) fn gather_bodies(
    parts: Query<(Entity, Option<&ColliderBody>), Parts>,
    bodies: Query<(Entity, Ref<ColliderMass>, &BodyMemory)>,
    transforms: TransformHelper,
    mut snapshot: ResMut<TickColliders>,
    mut failures: Failures,
) {
    for gathered in snapshot.bypass_change_detection().colliders.iter_mut() {
        gathered.body = None;
    }
    for (entity, mass, _) in &bodies {
        if mass.is_changed() {
            failures.tell_numbers(entity, ClothComponent::ColliderMass, mass.check());
        }
    }
    for (collider, part) in &parts {
        let entity = part.map_or(collider, |part| part.0);
        let Ok((_, mass, memory)) = bodies.get(entity) else { continue };
        let Some(gathered) = snapshot.gathered_mut(collider) else { continue };
        let Some(motion) = gathered.motion.filter(|_| mass.check().is_ok()) else { continue };
        // Its own scale may be uneven, which does not matter here.
        let Ok(global) = transforms.compute_global_transform(entity) else { continue };
        let (center, rotation) = (global.transform_point(mass.center_of_mass), global.rotation());
        if !(center.is_finite() && rotation.is_finite()) {
            continue;
        }
        let mobility = mass.mobility(rotation, entity.to_bits(), memory.informed);
        gathered.body = Some(TickBody {
            entity,
            mobility: (!mass.sleeps).then_some(mobility),
            center_of_mass: to_local(&motion.end(), center),
            cloths: 1,
        });
    }
}

/// When `ColliderMass` is removed, clears its errors. The collider stays where its engine has it.
pub(crate) fn forget_mass(removed: On<Remove, ColliderMass>, mut failures: Failures) {
    failures.clear(removed.entity, Blame::Component(ClothComponent::ColliderMass));
}
