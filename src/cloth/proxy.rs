//! Cloth that is drawn finer than it is simulated.

use bevy::prelude::*;

/// Simulates a coarser shape in the place of the one that is drawn. It goes beside [`Cloth`](crate::Cloth).
///
/// The drawn mesh stays as fine as it is. Each of its vertices is bound, at rest, to a triangle of the coarse shape, and goes where that
/// goes: on a surface that is curved by the normals (Boubekeur and Alexa 2008, *Phong Tessellation*), so that no facets are seen, and off
/// it by as much as at rest. The time of a tick falls with the number of particles; folds become as wide as the coarse
/// shape can show.
///
/// Whatever goes by vertex goes by the drawn mesh: pins, [`ClothWeights`](crate::ClothWeights), the maps of
/// [`ClothSkin`](crate::ClothSkin), colours and joints. A particle takes what the drawn vertex nearest to it has, and a vertex
/// stands for the particle nearest to it. Vertices between held particles are drawn where what holds them is, and so are those whose own
/// max distance is 0.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothProxy, prelude::*};
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((
///     Cloth::sheet(Vec2::splat(2.0), UVec2::splat(100)),
///     // 2025 particles carry 10,000 vertices.
///     ClothProxy::grid(45, 45),
///     ClothPins::vertices([0, 99]),
/// ));
/// # }
/// ```
///
/// Changing or removing the component changes the shape that is simulated. The cloth goes on where it is, with the velocities that it has.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Debug, PartialEq, Clone)]
pub enum ClothProxy {
    /// So many columns and rows over the same surface, at least 2 each and no more than are drawn. For sheets, and for meshes that are
    /// an open grid of quads.
    Grid(UVec2),
    /// This part of the particles, above 0 and at most 1. A grid keeps as much of its columns as of its rows. Other meshes are simplified
    /// by [meshoptimizer](https://docs.rs/meshopt), which the feature `simplify` brings.
    Ratio(f32),
    /// A mesh of your own, in the same frame as the one that is drawn and about as large. Its vertices, triangles and nothing else of
    /// it are used. With the feature `serialize`, it is refused by serde: it is an asset.
    #[cfg_attr(feature = "serialize", serde(skip))]
    Mesh(Handle<Mesh>),
}

impl ClothProxy {
    /// So many columns and rows over the same surface. See [`ClothProxy::Grid`].
    pub fn grid(columns: u32, rows: u32) -> Self {
        Self::Grid(UVec2::new(columns, rows))
    }

    /// A part of the particles. See [`ClothProxy::Ratio`].
    pub fn ratio(ratio: f32) -> Self {
        Self::Ratio(ratio)
    }

    /// A mesh of your own. See [`ClothProxy::Mesh`].
    pub fn mesh(mesh: Handle<Mesh>) -> Self {
        Self::Mesh(mesh)
    }

    /// The mesh, where it is one.
    pub(crate) fn own_mesh(&self) -> Option<&Handle<Mesh>> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            _ => None,
        }
    }
}
