//! The unknowns of threads that are solved side by side.

use crate::solver::simd::soa::{Array, Soa};

/// Spans and their lengths, inverse pivots and right-hand sides of threads solved side by side.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub span: Soa,
    pub length: Array,
    pub inverse_pivot: Array,
    pub residual: Array,
    /// How far springs go along the normals at their second ends, where these lie on colliders.
    pub across: Array,
    /// Corrections of their particles, where threads are taut.
    pub correction: Soa,
}

impl Line {
    /// Room for threads of so many springs, times [`LANES`].
    pub fn new(longest: usize) -> Self {
        Self {
            span: Soa::zeros(longest),
            length: Array::zeros(longest),
            inverse_pivot: Array::zeros(longest),
            residual: Array::zeros(longest),
            across: Array::zeros(longest),
            correction: Soa::zeros(longest),
        }
    }
}
