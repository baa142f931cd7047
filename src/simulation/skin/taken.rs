//! The skin that was taken off an entity, so that the renderer does not move its cloth a second time.

use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy::ecs::entity::EntityMapper;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use crate::cloth::skin::ClothSkin;
use crate::error::failures::{Blame, Failures};
use crate::mesh::drawn::ClothMesh;
use crate::mesh::source::ClothSource;
use crate::simulation::ClothSimulation;

/// The skin that was taken off an entity whose cloth is worn. A copy of the entity, cloned or out of a saved world, has this in its place,
/// with its own joints.
#[derive(Component, Reflect, Clone, Debug)]
#[reflect(Component, Debug, Clone)]
#[component(map_entities = map_joints)]
pub(crate) struct TakenSkin {
    pub skinned: SkinnedMesh,
    /// Whether Bevy worked out its bounds from its joints.
    pub has_bounds: bool,
}

fn map_joints<M: EntityMapper>(taken: &mut TakenSkin, mapper: &mut M) {
    for joint in &mut taken.skinned.joints {
        *joint = mapper.get_mapped(*joint);
    }
}

/// Takes the skin off an entity.
pub(crate) fn take(entity: &mut EntityCommands, skinned: &SkinnedMesh, has_bounds: bool) {
    entity
        .try_remove::<(SkinnedMesh, DynamicSkinnedMeshBounds)>()
        .try_insert(TakenSkin { skinned: skinned.clone(), has_bounds });
}

/// When `ClothSkin` is removed, lets the mesh be drawn skinned as before.
pub(crate) fn give_back(
    removed: On<Remove, ClothSkin>,
    skins: Query<(&TakenSkin, Option<&ClothMesh>, Option<&Mesh3d>)>,
    mut commands: Commands,
    mut failures: Failures,
) {
    for blame in [Blame::Skin, Blame::Joints] {
        failures.clear(removed.entity, blame);
    }
    if let Ok((taken, own, shown)) = skins.get(removed.entity) {
        put_on(&mut commands.entity(removed.entity), taken, own, shown);
    }
}

/// Puts the skin on an entity again, whose cloth is gone.
pub(crate) fn put_on(
    entity: &mut EntityCommands,
    taken: &TakenSkin,
    own: Option<&ClothMesh>,
    shown: Option<&Mesh3d>,
) {
    entity.try_remove::<(ClothSimulation, ClothMesh, ClothSource, TakenSkin, Aabb, NoAutoAabb)>();
    // It may have been given another mesh meanwhile.
    let own = own.filter(|own| shown.is_none_or(|shown| shown.0 == own.handle));
    if let Some(source) = own.and_then(|own| own.source.clone()) {
        entity.try_insert(Mesh3d(source));
    }
    entity.try_insert(taken.skinned.clone());
    if taken.has_bounds {
        entity.try_insert(DynamicSkinnedMeshBounds);
    }
}
