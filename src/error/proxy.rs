//! Problems of shapes that are simulated in the place of others, each with what to do about it.

use bevy::prelude::*;

use crate::error::problems::{GridProblem, MeshProblem};

/// Why a [`ClothProxy`](crate::ClothProxy) cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProxyProblem {
    /// The columns or rows are too few, or more than are drawn.
    #[error(
        "{} columns and {} rows are asked for, but there must be at least 2 of each, and no more than the {} and {} that are drawn",
        asked.x, asked.y, drawn.x, drawn.y
    )]
    Grid {
        /// Columns and rows asked for.
        asked: UVec2,
        /// Columns and rows that are drawn.
        drawn: UVec2,
    },
    /// Columns and rows are asked for of a mesh that has none.
    #[error(
        "its mesh is no grid of columns and rows: {0}; use `ClothProxy::Ratio` or a mesh of your own"
    )]
    NotAGrid(GridProblem),
    /// The part of the particles is out of its range.
    #[error("the ratio is {0}, but must be above 0 and at most 1")]
    Ratio(f32),
    /// A mesh that is no grid cannot be simplified without the feature.
    #[error(
        "its mesh is no grid of columns and rows, and needs the feature `simplify` of bevy_drape to be simplified; enable it, or use a \
         mesh of your own"
    )]
    NoSimplifier,
    /// The mesh was simplified so far that it is another.
    #[error(
        "simplified by the ratio {ratio}, its mesh is {distance} m away from particle {particle} of the one that is drawn, which is more than \
         a quarter of its size of {size} m; use a larger ratio or a mesh of your own"
    )]
    TooSimple {
        /// The ratio asked for.
        ratio: f32,
        /// A particle of the drawn mesh.
        particle: usize,
        /// Its distance from the shape that is to be simulated \[m\].
        distance: f32,
        /// The longest side of the drawn mesh \[m\].
        size: f32,
    },
    /// The simplifier left out whole parts.
    #[error(
        "of its {from} parts, which nothing connects, {got} are left when it is simplified; use a larger ratio or a mesh of your own"
    )]
    LostParts {
        /// Parts of the drawn mesh.
        from: usize,
        /// Parts that are left.
        got: usize,
    },
    /// The shape that is to be simulated makes no cloth.
    #[error("of the shape that is to be simulated: {0}")]
    Mesh(MeshProblem),
    /// A vertex of the drawn mesh is far from the shape that is to be simulated.
    #[error(
        "the drawn mesh is {distance} m away from the proxy's at particle {particle}, which is more than a quarter of its size of {size} m; \
         make both in the same frame, and of the same size"
    )]
    TooFar {
        /// A particle of the drawn mesh.
        particle: usize,
        /// Its distance from the shape that is to be simulated \[m\].
        distance: f32,
        /// The longest side of the drawn mesh \[m\].
        size: f32,
    },
}
