//! The law that shear springs on the bias are held to.

use crate::solver::constraints::threads::tridiagonal::Law;
use crate::solver::simd::block::larger;

/// Least compliance of a spring, relative to the inverse masses of its ends. Weft, warp and both diagonals correct what the others
/// left, and where all are stiff they contend: the diagonals leave the threads to carry. Half of it makes a sheet that is as stiff
/// across as along hang less accurately; twice as much makes soft ones sag more under what lies on them.
const LEAST_COMPLIANCE: f32 = 0.6;
/// Compliance of a spring that is at its limit, as far. A harder limit makes a sheet on a cube tremble at 8 substeps, a much softer one
/// holds no sheet that collapses.
const LIMIT_COMPLIANCE: f32 = 0.1;

/// How soft shear springs are, and how long they may be.
#[derive(Clone, Copy)]
pub(crate) struct ShearLaw {
    /// `1 / (k h^2)` of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    /// Longest that a spring may be, in rest lengths.
    pub limit: f32,
    /// Largest correction by one spring at which a taut diagonal does not tremble \[m\].
    pub steady: f32,
}

impl Law for ShearLaw {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn steady(&self) -> f32 {
        self.steady
    }

    /// To the rest length, or to the limit where that takes a larger pull: the pull at the limit, and what it takes to come back to it.
    #[inline(always)]
    fn hold(&self, length: f32, rest: f32, factor: f32, both: f32) -> (f32, f32) {
        let (soft, hard) =
            (larger(factor * self.compliance, both * LEAST_COMPLIANCE), both * LIMIT_COMPLIANCE);
        let longest = rest * self.limit;
        let (elastic, beyond) = (length - rest, length - longest);
        // Between two held ones nothing moves, and the limit would take a pull without end.
        if both > 0.0 && beyond * (both + soft) > elastic * (both + hard) {
            (hard, beyond + hard / soft * (longest - rest))
        } else {
            (soft, elastic)
        }
    }
}
