//! Any triangle mesh becomes the rest shape of a cloth.

use std::sync::Arc;

use bevy::math::{UVec2, Vec3};
use bevy_drape_core::surface::NormalGroups;

use crate::error::problems::{GridProblem, MeshProblem};
use crate::mesh::grid::{GridTopology, recognize};
use crate::mesh::raw::RawMesh;
use crate::mesh::surface::{SkippedTriangles, Surface, follow};

/// The account of how a mesh was made a cloth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClothIntake {
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Particles of the cloth: places that triangles use.
    pub particles: usize,
    /// Vertices at places that no triangle of the cloth uses. They are drawn with a neighbour, or
    /// with the first particle.
    pub unused_vertices: usize,
    /// Triangles of the cloth.
    pub triangles: usize,
    /// Triangles that are not.
    pub skipped: SkippedTriangles,
    /// Edges with more than two triangles. They stretch like others, and do not bend.
    pub crowded_edges: usize,
    /// Parts that nothing connects. More than one may mean a seam whose sides are too far apart to
    /// be welded.
    pub pieces: usize,
    /// Columns and rows, where the mesh is an open grid of quads; else why it is none. Grids are
    /// faster.
    pub grid: Result<UVec2, GridProblem>,
}

impl ClothIntake {
    /// Vertices that share the particle of another. With a [`ClothProxy`](crate::ClothProxy) most of them stand for one that is near.
    pub fn welded_vertices(&self) -> usize {
        (self.vertices - self.unused_vertices).saturating_sub(self.particles)
    }
}

/// A mesh as the rest shape of cloths. Shared by all cloths of equal meshes.
#[derive(Debug)]
pub(crate) struct MeshShape {
    /// Tells it from other meshes.
    pub fingerprint: u64,
    /// Rest positions in the entity's frame \[m\], by particle.
    pub positions: Vec<Vec3>,
    pub connection: Connection,
    /// The particle that each vertex is drawn at.
    pub particle_of_vertex: Box<[u32]>,
    /// The vertices that are only drawn there, ascending.
    pub unused: Box<[u32]>,
    /// Which vertices tell of which particle, where these are those of another shape, which is drawn.
    pub told_by: Option<Box<[(u32, u32)]>>,
    /// By vertex.
    pub colors: Option<Arc<[[f32; 4]]>>,
    pub intake: ClothIntake,
    pub(crate) normals: NormalPlan,
}

/// How particles are connected.
#[derive(Debug)]
pub(crate) enum Connection {
    /// In rows and columns.
    Grid { rows: usize, columns: usize },
    /// By triangles.
    Triangles(Vec<[u32; 3]>),
}

/// How the normals of a mesh are worked out.
#[derive(Debug)]
pub(crate) enum NormalPlan {
    /// By rows and columns: a grid without seams. The vertex of each particle, `None` where they
    /// are the same.
    Grid { columns: usize, vertex_of_particle: Option<Box<[u32]>> },
    /// By groups of vertices.
    Groups(NormalGroups),
}

impl MeshShape {
    /// # Errors
    /// [`MeshProblem`] where the mesh is no cloth.
    pub fn new(raw: RawMesh, fingerprint: u64) -> Result<Self, MeshProblem> {
        let surface = Surface::new(&raw.positions, &raw.triangles)?;
        let mut intake = ClothIntake {
            vertices: raw.positions.len(),
            particles: surface.vertex_of_particle.len(),
            unused_vertices: 0,
            triangles: surface.triangles.len(),
            skipped: surface.skipped,
            crowded_edges: surface.crowded_edge_count(),
            pieces: surface.piece_count(),
            grid: Err(GridProblem::Border),
        };
        let grid = recognize(&surface.triangles, intake.particles);
        intake.grid =
            grid.as_ref().map(|g| UVec2::new(g.columns as u32, g.rows as u32)).map_err(|e| *e);

        let mut particle_of_vertex = surface.particle_of_vertex;
        let mut vertex_of_particle = surface.vertex_of_particle;
        let connection = match grid {
            Ok(grid) => {
                renumber(&grid, &mut particle_of_vertex, &mut vertex_of_particle);
                Connection::Grid { rows: grid.rows, columns: grid.columns }
            }
            Err(_) => Connection::Triangles(surface.triangles),
        };
        let unused = follow(&mut particle_of_vertex, &raw.positions, &raw.triangles);
        intake.unused_vertices = unused.len();
        let normals = match connection {
            Connection::Grid { columns, .. } if intake.vertices == intake.particles => {
                let same = vertex_of_particle.iter().enumerate().all(|(i, &v)| i == v as usize);
                let map = (!same).then(|| vertex_of_particle.clone().into());
                NormalPlan::Grid { columns, vertex_of_particle: map }
            }
            _ => NormalPlan::Groups(NormalGroups::new(
                &particle_of_vertex,
                intake.particles,
                raw.normals.as_deref(),
                &raw.triangles,
            )),
        };
        Ok(Self {
            fingerprint,
            positions: vertex_of_particle.iter().map(|&v| raw.positions[v as usize]).collect(),
            connection,
            particle_of_vertex: particle_of_vertex.into(),
            unused,
            told_by: None,
            colors: raw.colors.map(Arc::from),
            intake,
            normals,
        })
    }

    /// The particle of a vertex; `None` where there is no such vertex, or no triangle uses it.
    pub fn particle_of(&self, vertex: u32) -> Option<u32> {
        let particle = *self.particle_of_vertex.get(vertex as usize)?;
        self.unused.binary_search(&vertex).is_err().then_some(particle)
    }

    /// The vertices that tell of particles, which triangles use, and these particles.
    pub fn used_vertices(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let mut unused = self.unused.iter().copied().peekable();
        let (told_by, own) = match &self.told_by {
            Some(told_by) => (&**told_by, &[][..]),
            None => (&[][..], &*self.particle_of_vertex),
        };
        let own = own.iter().enumerate();
        own.filter(move |(vertex, _)| unused.next_if_eq(&(*vertex as u32)).is_none())
            .map(|(vertex, &particle)| (vertex, particle as usize))
            .chain(told_by.iter().map(|&(vertex, particle)| (vertex as usize, particle as usize)))
    }
}

/// Renumbers particles row by row.
fn renumber(
    grid: &GridTopology,
    particle_of_vertex: &mut [u32],
    vertex_of_particle: &mut Vec<u32>,
) {
    let in_order = |old: &u32| vertex_of_particle[*old as usize];
    let by_row: Vec<_> = grid.vertex_of_particle.iter().map(in_order).collect();
    let mut new_of_old = vec![0; by_row.len()];
    for (new, &old) in grid.vertex_of_particle.iter().enumerate() {
        new_of_old[old as usize] = new as u32;
    }
    for particle in particle_of_vertex {
        // Vertices without a particle keep none.
        *particle = new_of_old.get(*particle as usize).copied().unwrap_or(*particle);
    }
    *vertex_of_particle = by_row;
}
