//! Corrections carried on: what threads, shear and tethers did in the last substeps is expected again, in
//! part, and the corrections do what is lacking.
//!
//! A correction stands for the force at the substep's end, and where that alone moves the cloth, what swings
//! is damped at the rate `omega^2 h / 2`: the method is Euler's implicit one, of first order. With the
//! forces filtered, `p' = p / 2 + f' h^2 / 2` and `x'' - 2 x' + x = p'`, it is Houbolt's (1950), the
//! generalized-alpha method whose highest frequencies die in a substep (Chung and Hulbert 1993, for a
//! spectral radius of zero): `2 x3 - 5 x2 + 4 x1 - x0 = h^2 f3`, of second order, stable for every step, and
//! what swings is damped at `omega^4 h^3 / 2`.
//!
//! That holds where corrections are solved whole. The chains of a mesh are solved one after the other, and a pass leaves a part `l` of
//! each way in which the mesh stretches: the correction is `-(1 - l) / l` times what is left. `l` need not be real, as later chains undo
//! what earlier ones did. Houbolt's method is stable for real parts, and near one for hardly any others: some meshes shook themselves, by
//! 3 % more in each substep. It is one of the filters of second order whose memory fades at a rate `k`,
//! `x3 - (2 + k) x2 + (1 + 2 k) x1 - k x0 = h^2 (k f3 + (1 - 2 k) f2)`: that of `k = 1/2`, with which what is infinitely stiff is at rest
//! after a substep. With a larger `k` more of such parts are stable, and corrections have more to do: they stand for `k f3`. A mesh has
//! `k = 0.6`, and what swings is damped at `9/8 omega^4 h^3`.
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
//! A mesh that lies on colliders carries on a third, and is of first order: its chains leave more to do than threads, and contact
//! follows with a delay. So is what carries heavy bodies (`state::carrying`): of second order, a sheet whose strain limit bears them
//! swings for ever.

use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{PartMut, Soa};

/// How forces are filtered: `q' = keeps q + c`, where `c` are a substep's corrections, which stand for the part `now` of the forces at
/// its end. Ahead of them particles move by `keeps moves q`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Filter {
    /// Part of what has been pulled that is kept.
    pub keeps: f32,
    /// Part of what is kept that moves the particles.
    pub moves: f32,
    /// Part of a substep's force that its corrections stand for.
    pub now: f32,
}

impl Filter {
    /// Houbolt's: of those of second order the one with which what is infinitely stiff is at rest after a substep.
    pub const HOUBOLT: Self = Self::of_second_order(0.5);
    /// That of a mesh, whose chains leave much to the next substep. With 0.5 some of 48 x 48 vertices shake themselves, with 0.55 none
    /// did of those that were measured.
    pub const OF_CHAINS: Self = Self::of_second_order(0.6);
    /// A filter of first order: corrections stand for all that is not kept. The more it keeps, the less a mesh
    /// stretches while it moves; of those on colliders that kept 0.4 more trembled.
    pub const OF_FIRST_ORDER: Self = Self { keeps: 1.0 / 3.0, moves: 1.0, now: 1.0 - 1.0 / 3.0 };

    /// The filter of second order that keeps a part: the forces that it sums up are a substep old in the mean, as the acceleration is
    /// that it stands for.
    const fn of_second_order(keeps: f32) -> Self {
        let lost = (1.0 - keeps) / keeps;
        Self { keeps, moves: lost * lost, now: keeps }
    }
}

/// Strain beyond which nothing is carried: what is so far out of shape is to be mended, and a correction
/// that mends is no force that lasts.
pub(crate) const MOST_STRAIN: f32 = 0.5;

/// How a substep notes its corrections.
pub(crate) enum PullFilter<'a> {
    /// Nothing.
    No,
    /// From where the particles are to be before them \[m\].
    Begin(PartMut<'a>),
    /// All of them, with what is kept of the last substep's, and the part of it that moves: the two parts of the filter.
    GoOn(PartMut<'a>, [f32; 2]),
}

impl<'a> PullFilter<'a> {
    /// Notes pulls where any are noted in this tick, and carries on those of the last substep.
    pub fn new(notes: bool, carried: Option<Filter>, pull: &'a mut Soa) -> Self {
        match carried {
            _ if !notes => Self::No,
            Some(Filter { keeps, moves, .. }) => Self::GoOn(pull.part_mut(), [keeps, moves]),
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
            Self::GoOn(pull, parts) => {
                let (above, below) = pull.cut(slot);
                (Self::GoOn(above, parts), Self::GoOn(below, parts))
            }
        }
    }
}
