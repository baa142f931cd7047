//! The law that shear springs on the bias are held to.

use crate::solver::constraints::threads::tridiagonal::{Law, Reach};
use crate::solver::simd::block::larger;

/// Least compliance of a spring, relative to the inverse masses of its ends. Weft, warp and both diagonals correct what the others
/// left, and where all are stiff they contend. Three times as much leaves a sheet that hangs by two corners 1.7 times as far from where it
/// hangs with many substeps; half as much shakes one whose pins are further apart than it reaches.
const LEAST_COMPLIANCE: f32 = 0.2;
/// Compliance of a spring that is at its limit, as far. A harder limit makes a sheet on a cube tremble at 8 substeps, a much softer one
/// holds no sheet that collapses.
const LIMIT_COMPLIANCE: f32 = 0.1;

/// The law of diagonals, which are springs as soft and as long as this.
#[derive(Clone, Copy)]
pub(crate) struct ShearLaw(pub Reach);

impl Law for ShearLaw {
    #[inline(always)]
    fn reach(&self) -> &Reach {
        &self.0
    }

    /// To the rest length, or to the limit where that takes a larger pull: the pull at the limit, and what it takes to come back to it.
    #[inline(always)]
    fn hold(&self, length: f32, rest: f32, factor: f32, both: f32) -> (f32, f32) {
        let (soft, hard) =
            (larger(factor * self.0.compliance, both * LEAST_COMPLIANCE), both * LIMIT_COMPLIANCE);
        let longest = rest * self.0.limit;
        let (elastic, beyond) = (length - rest, length - longest);
        // Between two held ones nothing moves, and the limit would take a pull without end.
        if both > 0.0 && beyond * (both + soft) > elastic * (both + hard) {
            (hard, beyond + hard / soft * (longest - rest))
        } else {
            (soft, elastic)
        }
    }
}
