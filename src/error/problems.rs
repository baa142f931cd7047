//! Problems of cloths and colliders, each with what to do about it.

use bevy::mesh::MeshAccessError;
use bevy::prelude::*;

use crate::hang::HangError;
use crate::sdf::SavedFieldError;
use crate::solver::{ParameterError, SolverError};

/// Why a mesh cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshProblem {
    /// The entity has no mesh.
    #[error("the entity has no `Mesh3d`; insert one")]
    NoMesh,
    /// The app has no mesh assets.
    #[error("the app has no mesh assets; add `AssetPlugin` and `MeshPlugin`")]
    NoMeshAssets,
    /// Nothing loads the mesh, and it is not among the app's assets.
    #[error(
        "its mesh is not among `Assets<Mesh>`, and nothing loads it: add it there, or load it with the `AssetServer`"
    )]
    Missing,
    /// The asset server gave up loading it.
    #[error(
        "its mesh failed to load: {0}; mend its path or file, or add what loads such files (Bevy's feature `bevy_gltf`), then \
         give the entity its `Mesh3d` anew"
    )]
    LoadFailed(String),
    /// Its data went to the GPU and is no longer here.
    #[error(
        "its mesh's data was moved to the render world; load it with \
         `RenderAssetUsages::MAIN_WORLD | RenderAssetUsages::RENDER_WORLD`"
    )]
    TakenToGpu,
    /// It has no positions of three floats.
    #[error("its mesh has no `Mesh::ATTRIBUTE_POSITION` of three floats; insert it")]
    NoPositions,
    /// It is made of points or lines.
    #[error("its mesh is made of points or lines; use a triangle list or strip")]
    NotTriangles,
    /// The indices of a triangle list (or, without indices, its vertices) are no multiple of three.
    #[error(
        "its mesh is a triangle list of {0} corners, which is no multiple of three; leave out the rest"
    )]
    LooseIndices(usize),
    /// It has no triangle.
    #[error("its mesh has no triangles; give it two or more")]
    Empty,
    /// An index is beyond the vertices.
    #[error("its mesh has the index {index}, but only {vertices} vertices; mend its indices")]
    BadIndex {
        /// The index.
        index: u32,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// A position is NaN, infinite or beyond 1e6 m.
    #[error(
        "the position of vertex {0} of its mesh is not finite, or beyond 1e6 m; mend its positions"
    )]
    NonFinite(usize),
    /// No triangle has an area.
    #[error(
        "none of the {triangles} triangles of its mesh has an area: corners repeat, coincide or lie \
         on a line; look at the export's scale and welding"
    )]
    AllDegenerate {
        /// Triangles of the mesh.
        triangles: usize,
    },
    /// Only one triangle is left.
    #[error(
        "one triangle makes no cloth ({skipped} others were skipped); use a mesh of two or more"
    )]
    OneTriangle {
        /// Triangles that are the same, or have no area.
        skipped: usize,
    },
    /// It is skinned: the skeleton would move the cloth a second time.
    #[error(
        "the entity has a `SkinnedMesh`, which would move the cloth a second time; insert `ClothSkin`, which takes it over, or \
         remove it, and let pins follow the bones (`ClothPins::anchored_to`)"
    )]
    Skinned,
    /// Somebody removed the cloth's own mesh, or changed its vertices.
    #[error("its own mesh was removed or given other vertices; give the entity another `Mesh3d`")]
    Changed,
}

impl From<MeshAccessError> for MeshProblem {
    fn from(error: MeshAccessError) -> Self {
        match error {
            MeshAccessError::ExtractedToRenderWorld => Self::TakenToGpu,
            MeshAccessError::NotFound => Self::Changed,
        }
    }
}

/// Why triangles are no open grid of quads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GridProblem {
    /// An index is beyond the vertices.
    #[error("an index is beyond the last vertex")]
    BadIndex,
    /// An edge has more than two triangles, or two that face opposite sides.
    #[error("an edge has more than two triangles, or triangles that face opposite sides")]
    NotASurface,
    /// The border is not one closed line: the mesh is wrapped (a cylinder, a sphere), in pieces or
    /// has holes.
    #[error("its border is not one closed line (it is wrapped, in pieces, or has holes)")]
    Border,
    /// The counts or the connections fit no grid.
    #[error(
        "{vertices} vertices and {triangles} triangles, connected as they are, make no rows and columns"
    )]
    NotRectangular {
        /// Vertices of the mesh.
        vertices: usize,
        /// Triangles of the mesh.
        triangles: usize,
    },
}

/// Why the transform of a cloth, a collider or a wind zone cannot be used. Vectors are its scale in the world.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ScaleProblem {
    /// Any part of the transform is NaN or infinite.
    #[error("its transform (with its parents') is not finite; change it to finite numbers")]
    NotFinite,
    /// An axis is scaled to nothing, or mirrored.
    #[error(
        "its scale (with its parents') is {0}, but must be positive; to hide the entity use `Visibility`, to mirror it mirror the mesh"
    )]
    NotPositive(Vec3),
    /// Axes are scaled differently.
    #[error(
        "its scale (with its parents') is {0}, but must be the same along all axes; put the uneven scale into the mesh or the size, and normalize rotations"
    )]
    Uneven(Vec3),
    /// It is turned below a parent that scales axes differently.
    #[error(
        "its scale (with its parents') is {0}, but must not be sheared by the uneven scale of a parent; make that uniform"
    )]
    Sheared(Vec3),
    /// The shape cannot be used in this size.
    #[error(
        "its scale (with its parents') is {0}, but must be neither too large nor too small for its mesh or size; use metres"
    )]
    OutOfRange(f32),
}

/// Why a [`ClothGrab`](crate::ClothGrab) holds nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GrabProblem {
    /// There is no such particle.
    #[error("there is no particle {particle}: the cloth has {count}")]
    NoSuchParticle {
        /// The particle asked for.
        particle: u32,
        /// Particles of the cloth.
        count: usize,
    },
    /// No particle is within the ball.
    #[error("no particle is within its ball: make it larger, or start it on the cloth")]
    Nothing,
    /// A place is not finite, or beyond 1e7 m.
    #[error("its {0} is not finite, or beyond 1e7 m")]
    Place(&'static str),
    /// A number is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// Why a cloth does not start hung from its pins.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum HangProblem {
    /// No cloth hangs from such places.
    #[error(transparent)]
    Places(#[from] HangError),
    /// The cloth is worn.
    #[error("a cloth with `ClothSkin` starts where its skin is; remove `HangOnStart`")]
    Worn,
    /// The cloth did not come to rest, but diverged.
    #[error("on the way to rest, {0}")]
    Relaxing(#[from] SolverError),
}

/// Why a [`Pin`](crate::Pin) holds nothing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PinProblem {
    /// There is no such vertex.
    #[error("there is no vertex {vertex}; choose from 0 to {}", count.saturating_sub(1))]
    NoSuchVertex {
        /// The vertex asked for.
        vertex: u32,
        /// Vertices of the cloth.
        count: usize,
    },
    /// No triangle of the cloth uses the vertex.
    #[error("no triangle of the cloth uses vertex {0}; choose another, or pins `within` a box")]
    UnusedVertex(u32),
    /// The box or the colours choose nothing.
    #[error(
        "no particle is chosen; compare the box with the mesh's positions in its own frame, or the threshold with its colours"
    )]
    Empty,
    /// The mesh has no colours.
    #[error("its mesh has no vertex colours; paint it, or choose vertices or a box")]
    NoColors,
    /// The mesh has no rows and columns.
    #[error("its mesh is no grid of rows and columns; choose vertices, a box or a colour")]
    NotAGrid,
    /// The anchor does not exist, or has no `Transform`.
    #[error(
        "its anchor {0} is not there, or it or one of its parents has no `Transform`; its particles are released until it is"
    )]
    NoAnchor(Entity),
    /// The anchor is where nothing can be, or is not scaled alike along its axes.
    #[error("of its anchor {anchor}: {problem}; or anchor to another entity")]
    AnchorScale {
        /// The anchor.
        anchor: Entity,
        /// The problem of its transform.
        problem: ScaleProblem,
    },
    /// A number of a soft pin is out of its range.
    #[error("{0}; change its `hold`")]
    Hold(ParameterError),
}

/// Why [`ClothWeights`](crate::ClothWeights) cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WeightProblem {
    /// The mesh has no colours.
    #[error("`{field}` goes by vertex colour, but its mesh has none; use `VertexFactor::Data`")]
    NoColors {
        /// The field of `ClothWeights`.
        field: &'static str,
    },
    /// The list has not one number a vertex.
    #[error("`{field}` has {got} numbers, but there are {expected} vertices; give one for each")]
    WrongLength {
        /// The field of `ClothWeights`.
        field: &'static str,
        /// Vertices of the cloth.
        expected: usize,
        /// Numbers given.
        got: usize,
    },
    /// A factor is NaN or out of range.
    #[error("`{field}` of vertex {vertex} is {value}, but must be from 0.001 to 1000")]
    OutOfRange {
        /// The field of `ClothWeights`.
        field: &'static str,
        /// The vertex.
        vertex: usize,
        /// Its factor.
        value: f32,
    },
}

/// Why a collider's distance field is not there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldProblem {
    /// Its file holds no field.
    #[error("the distance field `{path}` cannot be used: {problem}")]
    Content {
        /// The file, as it was asked for.
        path: String,
        /// The problem with it.
        problem: SavedFieldError,
    },
    /// Its file cannot be loaded.
    #[error("the distance field `{path}` cannot be loaded: {reason}")]
    LoadFailed {
        /// The file, as it was asked for.
        path: String,
        /// The asset server's message.
        reason: String,
    },
    /// Nothing loads it, and it is not among the app's assets.
    #[error(
        "its distance field is not among `Assets<DistanceField>`, and nothing loads it: add it there, or load it \
         with the `AssetServer`"
    )]
    Missing,
}
