//! Baking: from a closed triangle mesh to a grid of exact distances.
//!
//! The signed Euclidean distance transform in three dimensions (3-SEDT), in stages, one a file:
//!
//! 1. [`mesh`]: weld the vertices by position, refuse what is not closed and consistently oriented;
//! 2. [`layout`]: place the grid;
//! 3. [`band`]: exact point-triangle distances at the nodes near the surface, and which triangle it was;
//! 4. [`sweep`]: raster sweeps carry *the triangle* from neighbour to neighbour and measure the exact
//!    distance to it, so a wrong guess can only ever be too far;
//! 5. [`tree`]: prove every swept node against a tree of the triangles, and mend it where one is nearer.
//!    Where triangles are smaller than cells, some are the nearest of no node in the band and so are never
//!    carried: the sweeps leave errors of up to 0.1 cells. They make the proof cheap;
//! 6. [`sign`]: inside or outside, from the pseudonormal of the nearest face, edge or vertex.
//!
//! Geometry is in `f64`; only the finished distances are rounded to `f32`.

mod band;
mod layout;
mod mesh;
mod sign;
mod sweep;
mod tree;
mod triangle;

pub(super) use layout::is_usable_cell_size;

use super::DistanceField;
use bevy_math::Vec3;
use layout::Layout;
use thiserror::Error;

/// Largest number of nodes that a field may have: 256 MiB of distances.
///
/// Baking takes four times as much while it runs.
pub const MAX_NODES: usize = 1 << 26;

/// How fine a field to bake, and how far around the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Spacing of the grid's nodes \[m\]. Smaller follows the mesh closer; time and memory grow with its cube.
    pub cell_size: f32,
    /// How far the grid reaches beyond the mesh, at least \[m\]. Larger keeps distances exact further out.
    pub margin: f32,
}

impl BakeSettings {
    /// As many cells along the longest side of the mesh's box, and a margin of two cells.
    ///
    /// `cells` below one count as one. Without finite positions there is no size to divide, and
    /// [`DistanceField::bake`] then refuses the mesh.
    pub fn for_mesh(positions: &[Vec3], cells: u32) -> Self {
        let mut min = Vec3::INFINITY;
        let mut max = Vec3::NEG_INFINITY;
        for &position in positions {
            min = min.min(position);
            max = max.max(position);
        }
        let cell_size = (max - min).max_element() / cells.max(1) as f32;
        Self { cell_size, margin: 2.0 * cell_size }
    }
}

/// Why a mesh could not be baked.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum BakeError {
    /// There is no triangle.
    #[error("the mesh has no triangles: give at least a closed tetrahedron")]
    Empty,
    /// No cell is asked for.
    #[error("no cells along the mesh's longest side were asked for: give at least 1")]
    NoCells,
    /// The index count is not a multiple of three.
    #[error(
        "{index_count} indices are not whole triangles: give a triangle list, three indices each"
    )]
    PartialTriangle {
        /// Number of indices given.
        index_count: usize,
    },
    /// An index points past the vertices.
    #[error(
        "index {index} is out of range for {vertex_count} vertices: give the index buffer that belongs to them"
    )]
    IndexOutOfRange {
        /// The index.
        index: u32,
        /// Number of vertices given.
        vertex_count: usize,
    },
    /// A used vertex has a coordinate that is NaN or infinite.
    #[error("vertex {index} is not finite: repair the mesh's positions")]
    NonFinite {
        /// Number of the vertex.
        index: u32,
    },
    /// Some edges have a triangle on one side only.
    #[error(
        "the mesh is not closed, {open_edges} edges have one triangle only: fill its holes, or give its surface a thickness (`BakeSdf::thickness`, or `Shell`)"
    )]
    NotClosed {
        /// Number of such edges.
        open_edges: usize,
    },
    /// Some edges have more than two triangles.
    #[error(
        "{edges} edges have more than two triangles: separate the parts that touch there, or remove inner walls"
    )]
    NonManifold {
        /// Number of such edges.
        edges: usize,
    },
    /// Some neighbouring triangles are wound in opposite senses.
    #[error(
        "triangles are wound inconsistently across {edges} edges: recalculate the mesh's normals or winding"
    )]
    Inconsistent {
        /// Number of such edges.
        edges: usize,
    },
    /// The mesh encloses nothing.
    #[error("the mesh encloses no volume: give it a thickness")]
    NoVolume,
    /// The cell size is not from 1e-9 to 1e9 m.
    #[error("a cell size of {cell_size} m cannot be used: give a length from 1e-9 to 1e9 m")]
    CellSize {
        /// The size asked for \[m\].
        cell_size: f32,
    },
    /// The margin is negative or not finite.
    #[error("a margin of {margin} m cannot be used: give zero or a positive length")]
    Margin {
        /// The margin asked for \[m\].
        margin: f32,
    },
    /// The grid would be too large.
    #[error(
        "the grid would have {nodes} nodes, more than {limit}: give larger cells or a smaller margin"
    )]
    TooLarge {
        /// Number of nodes asked for, as far as it can be counted.
        nodes: u64,
        /// [`MAX_NODES`].
        limit: usize,
    },
}

impl DistanceField {
    /// Bakes a field from a closed triangle mesh.
    ///
    /// `positions` \[m\] and `indices` are a triangle list; vertices at the same position are taken as one,
    /// so seams of normals or texture coordinates do no harm, and triangles without area are dropped. A
    /// mesh that is inside out as a whole is turned. Parts that overlap or lie in each other are each
    /// taken at their own word: the sign is that of the nearest surface.
    ///
    /// Some 0.7 s for 60,000 triangles at 64 cells along the longest side, on one core, and 3.6 s at 128.
    ///
    /// # Errors
    ///
    /// [`BakeError`] says what is wrong with the mesh or the settings, and what to do about it.
    ///
    /// # Sources
    ///
    /// Nearest point of a triangle: C. Ericson, *Real-Time Collision Detection* (2005), section 5.1.5.
    /// Sweeps: P.-E. Danielsson, *Euclidean Distance Mapping* (1980), in three dimensions, carrying
    /// features instead of offsets. Sign: J. A. Baerentzen and H. Aanaes, *Signed Distance Computation
    /// Using the Angle Weighted Pseudonormal* (2005).
    pub fn bake(
        positions: &[Vec3],
        indices: &[u32],
        settings: &BakeSettings,
    ) -> Result<Self, BakeError> {
        Self::bake_with_progress(positions, indices, settings, &mut |_| {})
    }

    /// [`bake`](Self::bake) that reports how much is done, as a share that rises from 0 to 1.
    ///
    /// # Errors
    ///
    /// As [`bake`](Self::bake).
    pub fn bake_with_progress(
        positions: &[Vec3],
        indices: &[u32],
        settings: &BakeSettings,
        progress: &mut dyn FnMut(f32),
    ) -> Result<Self, BakeError> {
        progress(0.0);
        let mesh = mesh::ClosedMesh::new(positions, indices)?;
        let layout = Layout::new(mesh.min, mesh.max, settings)?;
        let triangles = mesh.triangles();
        if triangles.is_empty() {
            return Err(BakeError::NoVolume);
        }
        let tree = tree::DiscTree::new(triangles);

        let mut nearest = Nearest::new(layout.node_count());
        let triangles = &tree.triangles;
        band::measure(&layout, triangles, &mut nearest, &mut share(progress, 0.0, 0.2));
        sweep::propagate(&layout, triangles, &mut nearest, &mut share(progress, 0.2, 0.6));
        tree.prove(&layout, &mut nearest, &mut share(progress, 0.6, 0.9));
        let values =
            sign::finish(&layout, &mesh, triangles, &nearest, &mut share(progress, 0.9, 1.0));

        Ok(Self {
            origin: layout.origin,
            cell_size: layout.cell_size,
            dims: layout.dims,
            values,
            surface_min: mesh.min,
            surface_max: mesh.max,
        })
    }
}

/// One stage's progress as its share of the whole.
fn share(progress: &mut dyn FnMut(f32), from: f32, to: f32) -> impl FnMut(f32) {
    move |done| progress(from + (to - from) * done)
}

/// The nearest triangle found so far, at every node.
struct Nearest {
    /// Squared distance to `triangle` \[m2\]; infinite while there is none.
    squared: Vec<f64>,
    /// The nearest triangle found, as its place among the tree's triangles.
    triangle: Vec<u32>,
}

impl Nearest {
    /// No triangle.
    const NONE: u32 = u32::MAX;

    fn new(node_count: usize) -> Self {
        Self { squared: vec![f64::INFINITY; node_count], triangle: vec![Self::NONE; node_count] }
    }
}
