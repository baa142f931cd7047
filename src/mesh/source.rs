//! Reads the rest shape from a mesh, and makes the mesh that a cloth draws into.

use std::sync::Arc;

use bevy::asset::{LoadState, RenderAssetUsages};
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::NoAutoAabb;
use bevy::ecs::message::MessageCursor;
use bevy::ecs::system::SystemParam;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use crate::error::problems::MeshProblem;
use crate::mesh::drawn::ClothMesh;
use crate::mesh::faces::grid_triangles;
use crate::mesh::proxy::{Coarse, Proxy};
use crate::mesh::raw::{RawMesh, fingerprint};
use crate::mesh::rest_cache::RestCache;
use crate::mesh::rest_shape::{RestShape, sheet_points};

/// The mesh that a cloth's rest shape comes from: not the one that it draws into.
pub(crate) fn source_of<'a>(
    mesh3d: Option<&'a Mesh3d>,
    own: Option<&'a ClothMesh>,
) -> Option<&'a Handle<Mesh>> {
    let given = mesh3d.map(|mesh3d| &mesh3d.0);
    match own {
        Some(own) if given.is_none_or(|given| *given == own.handle) => own.source.as_ref(),
        _ => given,
    }
}

/// The mesh that a cloth had before it drew into one of its own. A copy of the entity, cloned or out of a saved world, has this in
/// place of the handle that another cloth draws into.
#[derive(Component, Reflect, Clone, Debug)]
#[reflect(Component, Debug, Clone)]
pub(crate) struct ClothSource {
    /// The mesh; none where the cloth is a sheet.
    source: Option<Handle<Mesh>>,
    /// The one that was drawn into.
    drawn: Handle<Mesh>,
}

impl ClothSource {
    /// The mesh that an entity had before it was copied, if what it has now is another cloth's own.
    pub fn of_copy(&self, mesh3d: Option<&Mesh3d>) -> Option<Option<&Handle<Mesh>>> {
        mesh3d.is_some_and(|mesh3d| mesh3d.0 == self.drawn).then_some(self.source.as_ref())
    }
}

/// The app's meshes, where it has any.
#[derive(SystemParam)]
pub(crate) struct MeshSource<'w, 's> {
    meshes: Option<ResMut<'w, Assets<Mesh>>>,
    server: Option<Res<'w, AssetServer>>,
    events: Option<Res<'w, Messages<AssetEvent<Mesh>>>>,
    cursor: Local<'s, MessageCursor<AssetEvent<Mesh>>>,
    /// Meshes that came or were changed, and whether they were changed.
    changed: Local<'s, HashMap<AssetId<Mesh>, bool>>,
}

impl MeshSource<'_, '_> {
    /// Notes which meshes came or were changed since it was last asked.
    pub fn note_changes(&mut self) {
        let Self { events, cursor, changed, .. } = self;
        changed.clear();
        let Some(events) = events else { return };
        for event in cursor.read(events) {
            match event {
                AssetEvent::Added { id } => _ = changed.entry(*id).or_insert(false),
                AssetEvent::Modified { id } => _ = changed.insert(*id, true),
                _ => {}
            }
        }
    }

    /// Whether a mesh that was there is among those that were changed.
    pub fn was_modified(&self, handle: Option<&Handle<Mesh>>) -> bool {
        handle.is_some_and(|handle| self.changed.get(&handle.id()) == Some(&true))
    }

    /// Whether a mesh is another than a shape was read from, in what a cloth is made of.
    pub fn is_another(&self, handle: Option<&Handle<Mesh>>, shape: &RestShape) -> bool {
        let RestShape::Mesh(shape) = shape else { return false };
        let mesh = handle.and_then(|handle| self.meshes.as_ref()?.get(handle));
        mesh.is_some_and(|mesh| fingerprint(mesh).is_ok_and(|now| now != shape.fingerprint))
    }

    /// Whether a mesh is among those noted.
    pub fn has_changed(&self, handle: Option<&Handle<Mesh>>) -> bool {
        handle.is_some_and(|handle| self.changed.contains_key(&handle.id()))
    }

    /// The mesh; `None` while it is loading.
    pub fn get(&self, handle: Option<&Handle<Mesh>>) -> Result<Option<&Mesh>, MeshProblem> {
        let meshes = self.meshes.as_ref().ok_or(MeshProblem::NoMeshAssets)?;
        let handle = handle.ok_or(MeshProblem::NoMesh)?;
        if let Some(mesh) = meshes.get(handle) {
            return Ok(Some(mesh));
        }
        match self.server.as_ref().and_then(|server| server.get_load_state(handle)) {
            // A part of a file that is loading has not been asked for itself.
            Some(LoadState::Loading | LoadState::NotLoaded) => Ok(None),
            Some(LoadState::Failed(error)) => Err(MeshProblem::LoadFailed(error.to_string())),
            _ => Err(MeshProblem::Missing),
        }
    }

    /// Positions and indices of a mesh's triangles; `None` while it is loading.
    pub fn triangles(
        &self,
        handle: Option<&Handle<Mesh>>,
    ) -> Result<Option<(Vec<Vec3>, Vec<u32>)>, MeshProblem> {
        let Some(mesh) = self.get(handle)? else {
            return Ok(None);
        };
        let raw = RawMesh::read(mesh)?;
        Ok(Some((raw.positions, raw.triangles.into_flattened())))
    }

    /// The rest shape of a mesh; `None` while it is loading, or made in the background.
    pub fn read(
        &self,
        handle: Option<&Handle<Mesh>>,
        cache: &mut RestCache,
    ) -> Result<Option<RestShape>, MeshProblem> {
        let Some(mesh) = self.get(handle)? else {
            return Ok(None);
        };
        let shape = cache.mesh(fingerprint(mesh)?, mesh)?;
        Ok(shape.map(RestShape::Mesh))
    }

    /// A mesh that was made to be simulated in the place of another, and its fingerprint; `None` while it is loading.
    pub fn read_coarse(&self, handle: &Handle<Mesh>) -> Result<Option<Coarse>, MeshProblem> {
        let Some(mesh) = self.get(Some(handle))? else {
            return Ok(None);
        };
        Ok(Some(Coarse::Mesh(RawMesh::read(mesh)?, fingerprint(mesh)?)))
    }

    /// A mesh of its own for a cloth, with vertex `colors` or without; nothing where the app has no meshes.
    pub fn own_mesh(
        &mut self,
        rest: &RestShape,
        proxy: Option<&Arc<Proxy>>,
        source: Option<&Handle<Mesh>>,
        colors: bool,
    ) -> Option<impl Bundle + use<>> {
        let meshes = self.meshes.as_mut()?;
        let (mesh, source) = match rest {
            RestShape::Sheet { size, particles } => (sheet_mesh(*size, *particles), None),
            RestShape::Mesh(_) => (copy_of(meshes.get(source?)?, colors), source.cloned()),
        };
        let handle = meshes.add(mesh);
        let kept = ClothSource { source: source.clone(), drawn: handle.clone() };
        let own = ClothMesh::new(handle.clone(), source, rest.clone(), proxy.cloned());
        Some((Mesh3d(handle), own, kept, Aabb::default(), NoAutoAabb))
    }

    /// Draws the vertex colours of a cloth's mesh, or leaves them out.
    pub fn show_colors(&mut self, own: &ClothMesh, shows: bool) {
        let Some(meshes) = &mut self.meshes else { return };
        let has = |handle: &Handle<Mesh>, meshes: &Assets<Mesh>| {
            let mesh = meshes.get(handle)?;
            mesh.try_contains_attribute(Mesh::ATTRIBUTE_COLOR).ok()
        };
        if has(&own.handle, meshes) == Some(shows) {
            return;
        }
        let of_source = || {
            let mesh = meshes.get(own.source.as_ref()?)?;
            mesh.try_attribute_option(Mesh::ATTRIBUTE_COLOR).ok()?.cloned()
        };
        let colors = if shows { of_source() } else { None };
        let Some(mut mesh) = meshes.get_mut(&own.handle) else { return };
        // The data are here, as the cloth is drawn into them.
        let _ = match colors {
            Some(colors) => mesh.try_insert_attribute(Mesh::ATTRIBUTE_COLOR, colors),
            None => mesh.try_remove_attribute(Mesh::ATTRIBUTE_COLOR).map(|_| ()),
        };
    }
}

/// A copy that stays in the main world, with normals to write and no joints to follow.
fn copy_of(source: &Mesh, colors: bool) -> Mesh {
    let mut mesh = source.clone();
    if !colors {
        // Nothing to remove is as good.
        let _ = mesh.try_remove_attribute(Mesh::ATTRIBUTE_COLOR);
    }
    mesh.asset_usage = RenderAssetUsages::default();
    if let (Ok(false), count) =
        (mesh.try_contains_attribute(Mesh::ATTRIBUTE_NORMAL), mesh.count_vertices())
    {
        mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; count]);
    }
    for joints in [Mesh::ATTRIBUTE_JOINT_INDEX, Mesh::ATTRIBUTE_JOINT_WEIGHT] {
        // Nothing to remove is as good.
        let _ = mesh.try_remove_attribute(joints);
    }
    mesh
}

/// A flat sheet, facing +y.
fn sheet_mesh(size: Vec2, particles: UVec2) -> Mesh {
    let (columns, rows) = (particles.x, particles.y);
    let (last_column, last_row) = ((columns - 1) as f32, (rows - 1) as f32);
    let uvs: Vec<_> = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| [c as f32 / last_column, r as f32 / last_row]))
        .collect();
    let positions = sheet_points(size, particles);
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; positions.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(grid_triangles(particles).into_flattened()))
}
