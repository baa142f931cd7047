//! What a graph refuses.

use crate::solver::topology::graph::Graph;

/// Why a triangle mesh is no cloth.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// Nothing to hold together.
    #[error("a cloth of triangles needs at least 2 of them, got {triangles}")]
    TooFewTriangles {
        /// Triangles given.
        triangles: usize,
    },
    /// More particles or triangles than can be counted.
    #[error(
        "{particles} particles and {triangles} triangles are more than {} and {}",
        Graph::MAX_PARTICLES,
        2 * Graph::MAX_PARTICLES
    )]
    TooLarge {
        /// Particles given.
        particles: usize,
        /// Triangles given.
        triangles: usize,
    },
    /// A triangle has a corner that does not exist.
    #[error("triangle {triangle} has the corner {corner}, but there are {particles} particles")]
    NoSuchCorner {
        /// The triangle.
        triangle: usize,
        /// The corner asked for.
        corner: u32,
        /// Particles given.
        particles: usize,
    },
    /// A rest position is NaN, infinite or beyond 1e6 m.
    #[error("the rest position of particle {particle} is not finite, or beyond 1e6 m")]
    NonFinite {
        /// The particle.
        particle: usize,
    },
    /// Two corners of a triangle coincide.
    #[error("particles {first} and {second} are neighbours but lie at the same place: weld them")]
    Coincident {
        /// One particle.
        first: usize,
        /// Its neighbour.
        second: usize,
    },
    /// A triangle has no area, or next to none.
    #[error("triangle {triangle} has no area: leave it out")]
    ZeroArea {
        /// The triangle.
        triangle: usize,
    },
    /// The same three corners twice.
    #[error("triangles {first} and {second} have the same corners: leave one out")]
    Duplicate {
        /// One triangle.
        first: usize,
        /// The other.
        second: usize,
    },
    /// A particle lies on an edge that it is no end of, and the cloth would come open there.
    #[error(
        "particle {particle} lies on the edge from {first} to {second}, whose triangle does not have it (a T-junction): \
         split that triangle there"
    )]
    TJunction {
        /// The particle.
        particle: usize,
        /// One end of the edge.
        first: usize,
        /// The other.
        second: usize,
    },
    /// A particle without a triangle.
    #[error("particle {particle} is a corner of no triangle: leave it out")]
    Isolated {
        /// The particle.
        particle: usize,
    },
    /// Weights that are not one a particle.
    #[error("{particles} particles need as many {what}, got {got}")]
    WrongWeightCount {
        /// Which weights.
        what: &'static str,
        /// Particles given.
        particles: usize,
        /// Weights given.
        got: usize,
    },
    /// A weight that is not a positive number of some use.
    #[error("the {what} of particle {particle} is {value}, but must be from 1e-3 to 1e3")]
    Weight {
        /// Which weight.
        what: &'static str,
        /// The particle.
        particle: usize,
        /// The weight.
        value: f32,
    },
}
