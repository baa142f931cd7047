//! The unknowns of threads that are solved side by side.

use crate::solver::simd::soa::{Array, Soa};

/// Springs of threads that are solved side by side, as elimination leaves them.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub span: Soa,
    pub length: Array,
    /// Their own tensions over their lengths, and the part of the whole that the springs before take over.
    pub own: Array,
    pub handed_on: Array,
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
            own: Array::zeros(longest),
            handed_on: Array::zeros(longest),
            across: Array::zeros(longest),
            correction: Soa::zeros(longest),
        }
    }
}
