//! Finds the bodies of a tick's colliders.

use bevy::prelude::*;

use crate::collider::SdfCollider;
use crate::collider::mass::{BodyMemory, ColliderBody, ColliderMass};
use crate::collider::tick_body::{LoneBody, TickBody};
use crate::collider::tick_colliders::TickColliders;
use crate::error::ClothComponent;
use crate::error::failures::{Blame, Failures};
use crate::pose::moves::Moves;
use crate::pose::to_local;
use crate::solver::{ColliderMotion, Pose};

/// A collider that may be of a body.
type Parts = (With<SdfCollider>, Or<(With<ColliderMass>, With<ColliderBody>)>);

/// Finds the bodies of the tick's colliders. Those that stand still are as they were.
pub(crate) fn gather_bodies(
    parts: Query<Option<&ColliderBody>, Parts>,
    bodies: Query<(Entity, Ref<ColliderMass>, &BodyMemory)>,
    mut moves: Moves,
    transforms: TransformHelper,
    mut snapshot: ResMut<TickColliders>,
    mut failures: Failures,
    mut with_parts: Local<Vec<Entity>>,
) {
    let TickColliders { colliders, lone_bodies, .. } = snapshot.bypass_change_detection();
    with_parts.clear();
    lone_bodies.clear();
    for (entity, mass, _) in &bodies {
        if mass.is_changed() {
            failures.tell_numbers(entity, ClothComponent::ColliderMass, mass.check());
        }
    }
    let orphans = moves.any_orphan();
    for gathered in colliders {
        // One that has moved has none yet.
        let known = gathered.body.take();
        if bodies.is_empty() {
            continue;
        }
        let collider = gathered.entity;
        let (Ok(part), Some(motion)) = (parts.get(collider), gathered.motion) else { continue };
        let entity = part.map_or(collider, |part| part.0);
        let Ok((_, mass, memory)) = bodies.get(entity) else { continue };
        let is_same = |body: &TickBody| {
            body.entity == entity
                && !(mass.is_changed() || orphans)
                && body.mobility.is_none_or(|it| it.informed == memory.informed)
                && (entity == collider || !moves.moved(entity))
        };
        gathered.body = known.filter(is_same).or_else(|| {
            let (body, center) = body_now(entity, &mass, memory, &transforms)?;
            Some(TickBody { center_of_mass: to_local(&motion.end(), center), ..body })
        });
        with_parts.extend(gathered.body.map(|_| entity));
    }
    with_parts.sort_unstable();
    with_parts.dedup();
    if with_parts.len() == bodies.iter().len() {
        return;
    }
    for (entity, mass, memory) in &bodies {
        if with_parts.binary_search(&entity).is_ok() {
            continue;
        }
        if let Some((body, center)) = body_now(entity, &mass, memory, &transforms) {
            let pose = Pose::from_translation(center);
            let motion = ColliderMotion::new(&Sphere::new(1e-3), pose, pose);
            lone_bodies.push(LoneBody { body, motion });
        }
    }
}

/// A body as it is now, with the place of its centre of mass; `None` where a number of it or its place cannot be used, of which
/// is told elsewhere.
fn body_now(
    entity: Entity,
    mass: &ColliderMass,
    memory: &BodyMemory,
    transforms: &TransformHelper,
) -> Option<(TickBody, Vec3)> {
    mass.check().ok()?;
    // Its own scale may be uneven, which does not matter here.
    let global = transforms.compute_global_transform(entity).ok()?;
    let (center, rotation) = (global.transform_point(mass.center_of_mass), global.rotation());
    let usable = center.is_finite() && rotation.is_finite();
    let mobility = (!mass.sleeps).then(|| mass.mobility(rotation, memory.informed));
    let body = TickBody { entity, mobility, center_of_mass: Vec3::ZERO, cloths: 1 };
    usable.then_some((body, center))
}

/// When `ColliderMass` is removed, clears its errors. The collider stays where its engine has it.
pub(crate) fn forget_mass(removed: On<Remove, ColliderMass>, mut failures: Failures) {
    failures.clear(removed.entity, Blame::Component(ClothComponent::ColliderMass));
}
