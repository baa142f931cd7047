//! The unknowns of threads that are solved side by side.

use crate::solver::constraints::threads::tridiagonal::Eliminated;
use crate::solver::simd::block::Block3;

/// Springs of threads that are solved side by side, as elimination leaves them: an entry for those between two places.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub springs: Vec<Eliminated>,
    /// Corrections of their particles, where threads are taut.
    pub corrections: Vec<Block3>,
}

impl Line {
    /// Room for threads of so many particles: there is a spring less, and what eases them needs an entry for each particle.
    pub fn new(longest: usize) -> Self {
        Self {
            springs: vec![Eliminated::default(); longest],
            corrections: vec![Block3::ZERO; longest],
        }
    }
}
