//! From the capsules of bodies to colliders on their joints.

use bevy::prelude::*;
use bevy::time::Real;
use std::time::Duration;

use crate::collider::body::fit::Skinned;
use crate::collider::body::{ClothBody, ClothBodyFitted};
use crate::error::ClothErrorKind;
use crate::error::body::BodyProblem;
use crate::error::failures::{Blame, Failures};
use crate::mesh::source::MeshSource;

/// How long a character may take until it has a skinned mesh.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long it takes until what cannot be read is looked at again.
const PAUSE: Duration = Duration::from_secs(1);

/// What there is of a body.
#[derive(Component, Default)]
pub(crate) struct BodyParts {
    /// Colliders, each for the capsule of its place; `None` for one that cannot be used.
    colliders: Vec<Option<Entity>>,
    /// When it was first looked at, and when it is looked at next.
    since: Option<Duration>,
    next: Duration,
}

/// Fits capsules to bodies that have none.
pub(crate) fn fit_bodies(
    mut bodies: Query<(Entity, &mut ClothBody, &mut BodyParts)>,
    skinned: Skinned,
    meshes: MeshSource,
    mut commands: Commands,
    time: Option<Res<Time<Real>>>,
    mut failures: Failures,
) {
    let now = time.map_or(Duration::ZERO, |time| time.elapsed());
    for (entity, mut body, mut parts) in &mut bodies {
        if body.capsules.is_some() || (now < parts.next && !body.is_changed()) {
            continue;
        }
        let since = *parts.since.get_or_insert(now);
        match skinned.fit(entity, &meshes) {
            Ok(Some(capsules)) => {
                body.capsules = Some(capsules);
                *parts =
                    BodyParts { colliders: core::mem::take(&mut parts.colliders), ..default() };
                commands.trigger(ClothBodyFitted { entity });
            }
            Ok(None) => {}
            // A file may still be on its way.
            Err(BodyProblem::NoSkinnedMesh) if now < since + PATIENCE => {}
            Err(problem) => {
                failures.report(entity, ClothErrorKind::Body(problem));
                parts.next = now + PAUSE;
            }
        }
    }
}

/// Puts colliders on joints, and takes off those that are not listed any more.
pub(crate) fn place_bodies(
    mut bodies: Query<(Entity, &ClothBody, &mut BodyParts), Changed<ClothBody>>,
    entities: Query<(), With<Transform>>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for (entity, body, mut parts) in &mut bodies {
        let Some(capsules) = &body.capsules else { continue };
        let mut before = core::mem::take(&mut parts.colliders).into_iter();
        let mut outcome = Ok(());
        for (capsule, wanted) in capsules.iter().enumerate() {
            let old = before.next().flatten().filter(|it| entities.contains(*it));
            let collider = body.collider(wanted);
            let joint = wanted.joint;
            let checked = match collider.check() {
                _ if !entities.contains(joint) => Err(BodyProblem::JointGone { capsule, joint }),
                checked => checked.map_err(|problem| BodyProblem::Capsule { capsule, problem }),
            };
            let new = match (checked, old) {
                (Ok(()), Some(old)) => {
                    commands.entity(old).try_insert((collider, ChildOf(joint)));
                    Some(old)
                }
                (Ok(()), None) => Some(commands.spawn((collider, ChildOf(joint))).id()),
                (Err(problem), old) => {
                    outcome = outcome.and(Err(ClothErrorKind::Body(problem)));
                    drop_all(&mut commands, old);
                    None
                }
            };
            parts.colliders.push(new);
        }
        drop_all(&mut commands, before.flatten());
        failures.tell(entity, Blame::Body, outcome);
    }
}

/// When a body is gone, so are its colliders.
pub(crate) fn forget_body(
    removed: On<Remove, ClothBody>,
    bodies: Query<&BodyParts>,
    mut commands: Commands,
    mut failures: Failures,
) {
    if let Ok(parts) = bodies.get(removed.entity) {
        drop_all(&mut commands, parts.colliders.iter().copied().flatten());
    }
    commands.entity(removed.entity).try_remove::<BodyParts>();
    failures.clear(removed.entity, Blame::Body);
}

fn drop_all(commands: &mut Commands, colliders: impl IntoIterator<Item = Entity>) {
    for collider in colliders {
        if let Ok(mut collider) = commands.get_entity(collider) {
            collider.try_despawn();
        }
    }
}
