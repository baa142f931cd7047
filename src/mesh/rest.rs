//! Reads the rest shape from a mesh, and makes the mesh that a cloth draws into.

use super::ClothMesh;
use crate::cloth::{
    ClothSimulation, GridProblem,
    grid::{GridTopology, recognize},
};
use bevy::{
    asset::{LoadState, RenderAssetUsages},
    camera::{primitives::Aabb, visibility::NoAutoAabb},
    ecs::system::SystemParam,
    mesh::{Indices, MeshAccessError, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};

/// Why a mesh cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshProblem {
    /// The entity has no mesh.
    #[error("the entity has no `Mesh3d`; insert one, or use `Cloth::sheet`")]
    NoMesh,
    /// The app has no mesh assets.
    #[error(
        "the app has no mesh assets; add `AssetPlugin` and `MeshPlugin`, or use `Cloth::sheet`"
    )]
    NoMeshAssets,
    /// The asset server gave up loading it.
    #[error("its mesh failed to load: {0}")]
    LoadFailed(String),
    /// Its data went to the GPU and is no longer here.
    #[error(
        "its mesh's data was moved to the render world; load it with \
         `RenderAssetUsages::MAIN_WORLD | RenderAssetUsages::RENDER_WORLD`"
    )]
    TakenToGpu,
    /// It has no positions of three floats.
    #[error("its mesh has no positions of three floats")]
    NoPositions,
    /// It is not an indexed triangle list.
    #[error("its mesh is not an indexed triangle list")]
    NotTriangles,
    /// A position is NaN or infinite.
    #[error("the position of vertex {0} of its mesh is not finite")]
    NonFinite(usize),
    /// Its triangles are no open grid of quads.
    #[error("its mesh is not an open grid of quads, the only kind supported so far: {0}")]
    NotAGrid(#[from] GridProblem),
    /// Somebody removed the cloth's own mesh, or changed its vertices.
    #[error("its own mesh was removed or given other vertices; give the entity another `Mesh3d`")]
    Changed,
}

impl From<MeshAccessError> for MeshProblem {
    fn from(error: MeshAccessError) -> Self {
        match error {
            MeshAccessError::ExtractedToRenderWorld => Self::TakenToGpu,
            MeshAccessError::NotFound => Self::NotTriangles,
        }
    }
}

/// The shape of a cloth at rest, in its entity's frame.
pub(crate) enum RestShape {
    Sheet { size: Vec2, particles: UVec2 },
    Grid { topology: GridTopology, positions: Vec<Vec3> },
}

impl RestShape {
    /// The particle of each vertex; `None` where they are the same.
    pub fn particle_of_vertex(&self) -> Option<Box<[u32]>> {
        let vertices = self.vertex_of_particle()?;
        let mut particles = vec![0; vertices.len()].into_boxed_slice();
        for (particle, &vertex) in vertices.iter().enumerate() {
            particles[vertex as usize] = particle as u32;
        }
        Some(particles)
    }

    /// The vertex of each particle; `None` where they are the same.
    fn vertex_of_particle(&self) -> Option<&[u32]> {
        match self {
            Self::Sheet { .. } => None,
            Self::Grid { topology, .. } => {
                let vertices = &topology.vertex_of_particle;
                let same = vertices.iter().enumerate().all(|(i, &v)| i == v as usize);
                (!same).then_some(vertices)
            }
        }
    }
}

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

/// The app's meshes, where it has any.
#[derive(SystemParam)]
pub(crate) struct MeshSource<'w> {
    meshes: Option<ResMut<'w, Assets<Mesh>>>,
    server: Option<Res<'w, AssetServer>>,
}

impl MeshSource<'_> {
    /// The mesh; `None` while it is loading.
    fn get(&self, handle: Option<&Handle<Mesh>>) -> Result<Option<&Mesh>, MeshProblem> {
        let meshes = self.meshes.as_ref().ok_or(MeshProblem::NoMeshAssets)?;
        let handle = handle.ok_or(MeshProblem::NoMesh)?;
        let mesh = meshes.get(handle);
        if mesh.is_none()
            && let Some(server) = &self.server
            && let Some(LoadState::Failed(error)) = server.get_load_state(handle)
        {
            return Err(MeshProblem::LoadFailed(error.to_string()));
        }
        Ok(mesh)
    }

    /// Positions and indices of a triangle list; `None` while it is loading.
    pub fn triangles(
        &self,
        handle: Option<&Handle<Mesh>>,
    ) -> Result<Option<(Vec<Vec3>, Vec<u32>)>, MeshProblem> {
        let Some(mesh) = self.get(handle)? else {
            return Ok(None);
        };
        if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
            return Err(MeshProblem::NotTriangles);
        }
        let Some(VertexAttributeValues::Float32x3(positions)) =
            mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION)?
        else {
            return Err(MeshProblem::NoPositions);
        };
        let positions: Vec<_> = positions.iter().map(|p| Vec3::from_array(*p)).collect();
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(MeshProblem::NonFinite(vertex));
        }
        let indices = mesh.try_indices()?.iter().map(|index| index as u32).collect();
        Ok(Some((positions, indices)))
    }

    /// The rest shape of a mesh; `None` while it is loading.
    pub fn read(&self, handle: Option<&Handle<Mesh>>) -> Result<Option<RestShape>, MeshProblem> {
        let Some((positions, indices)) = self.triangles(handle)? else {
            return Ok(None);
        };
        let (triangles, rest) = indices.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(MeshProblem::NotTriangles);
        }
        let topology = recognize(triangles, positions.len())?;
        let in_order = topology.vertex_of_particle.iter().map(|&v| positions[v as usize]).collect();
        Ok(Some(RestShape::Grid { topology, positions: in_order }))
    }

    /// A mesh of its own for a cloth; nothing where the app has no meshes.
    pub fn own_mesh(
        &mut self,
        cloth: &ClothSimulation,
        rest: &RestShape,
        source: Option<&Handle<Mesh>>,
    ) -> Option<impl Bundle + use<>> {
        let meshes = self.meshes.as_mut()?;
        let (mesh, source) = match rest {
            RestShape::Sheet { size, particles } => (sheet_mesh(*size, *particles), None),
            RestShape::Grid { .. } => (copy_of(meshes.get(source?)?), source.cloned()),
        };
        let handle = meshes.add(mesh);
        let own = ClothMesh::new(
            handle.clone(),
            source,
            rest.vertex_of_particle().map(Box::from),
            cloth.rows(),
            cloth.columns(),
        );
        Some((Mesh3d(handle), own, Aabb::default(), NoAutoAabb))
    }
}

/// A copy that stays in the main world, with normals to write.
fn copy_of(source: &Mesh) -> Mesh {
    let mut mesh = source.clone();
    mesh.asset_usage = RenderAssetUsages::default();
    if let (Ok(false), count) =
        (mesh.try_contains_attribute(Mesh::ATTRIBUTE_NORMAL), mesh.count_vertices())
    {
        mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; count]);
    }
    mesh
}

/// A flat sheet, facing +y. Cells are split along alternating diagonals, so that no direction is
/// favoured.
fn sheet_mesh(size: Vec2, particles: UVec2) -> Mesh {
    let (columns, rows) = (particles.x, particles.y);
    let (last_column, last_row) = ((columns - 1) as f32, (rows - 1) as f32);
    let uvs: Vec<_> = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| [c as f32 / last_column, r as f32 / last_row]))
        .collect();
    let place = |[u, v]: &[f32; 2]| [size.x * (u - 0.5), 0.0, size.y * (v - 0.5)];
    let positions: Vec<_> = uvs.iter().map(place).collect();
    let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| (r, c)));
    let indices: Vec<_> = cells
        .flat_map(|(r, c)| {
            let a = r * columns + c;
            let (b, c2, d) = (a + 1, a + columns, a + columns + 1);
            if (r + c).is_multiple_of(2) { [a, c2, b, b, c2, d] } else { [a, c2, d, a, d, b] }
        })
        .collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 1.0, 0.0]; positions.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_indices(Indices::U32(indices))
}
