//! Corrections carried on: what threads, shear and tethers did in the last substep is expected again, by
//! half, and the corrections do what is lacking.
//!
//! A correction stands for the force at the substep's end, and where that alone moves the cloth, what swings
//! is damped at the rate `omega^2 h / 2`: the method is Euler's implicit one, of first order. With the
//! forces filtered, `p' = p / 2 + f' h^2 / 2` and `x'' - 2 x' + x = p'`, it is Houbolt's (1950), the
//! generalized-alpha method whose highest frequencies die in a substep (Chung and Hulbert 1993, for a
//! spectral radius of zero): `2 x3 - 5 x2 + 4 x1 - x0 = h^2 f3`, of second order, stable for every step, and
//! what swings is damped at `omega^4 h^3 / 2`.
//!
//! The filter holds the pulls of a particle's springs, not its velocity: gravity, air, bending and contact
//! are no part of it, and an impulse of a collider is neither repeated nor foreseen. The pulls of a cloth
//! sum up to none but at its pins, so that carrying a part of all of them keeps its momentum.
//!
//! A particle on a collider does not follow all of its pulls, and the collider bears the rest. That is a pull all
//! the same, and is noted as one (`contact`). What holds springs to their strain limit is not carried on, nor is
//! anything where the cloth is far out of shape or struck: there it mends, and is no force that lasts. Threads are of
//! first order there, and so is a mesh that is so stiff that one pass over its chains of edges leaves too much to do.
//!
//! A mesh that lies on colliders carries on a third: its chains leave more to do than threads, and contact follows with a delay.

use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{PartMut, Soa};

/// Part of the pulls that goes on. A half makes the method one of second order, and is the most that is
/// stable.
pub(crate) const CARRIED: f32 = 0.5;
/// Part of the pulls that a mesh on a collider carries on. At rest it stretches the less, the more is carried on; at 0.4 some meshes
/// tremble, at this none of those that were measured.
pub(crate) const CARRIED_BY_CHAINS_ON_COLLIDERS: f32 = 1.0 / 3.0;
/// Strain beyond which nothing is carried: what is so far out of shape is to be mended, and a correction
/// that mends is no force that lasts.
pub(crate) const MOST_STRAIN: f32 = 0.5;

/// How a substep notes its corrections.
pub(crate) enum PullFilter<'a> {
    /// Nothing.
    No,
    /// From where the particles are to be before them \[m\].
    Begin(PartMut<'a>),
    /// The same, with a part of the last substep's.
    GoOn(PartMut<'a>, f32),
}

impl<'a> PullFilter<'a> {
    /// Notes pulls where any are noted in this tick, and carries on this part of the last ones.
    pub fn new(notes: bool, part: Option<f32>, pull: &'a mut Soa) -> Self {
        match part {
            _ if !notes => Self::No,
            Some(part) => Self::GoOn(pull.part_mut(), part),
            None => Self::Begin(pull.part_mut()),
        }
    }
}

impl CutAt for PullFilter<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        match self {
            Self::No => (Self::No, Self::No),
            Self::Begin(pull) => {
                let (above, below) = pull.cut(slot);
                (Self::Begin(above), Self::Begin(below))
            }
            Self::GoOn(pull, part) => {
                let (above, below) = pull.cut(slot);
                (Self::GoOn(above, part), Self::GoOn(below, part))
            }
        }
    }
}
