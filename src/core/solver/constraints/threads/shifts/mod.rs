//! Shifts: what one pass over the threads leaves to do in every substep, made up for over many ticks.
//!
//! Threads are solved one after the other, and each finds anew what the others undid. Under a load that lasts, springs
//! stay longer than their tensions say, by as much in every substep: a mesh of a square metre of 64 x 64 that hangs from two
//! corners was 8 mm too long with 20 substeps, and 40 mm with 8; a sheet 1 mm and 9 mm. So each spring is asked to be shorter than it is
//! to be, by what it was too long at the ends of the ticks before: Powell's (1969) method of shifts, which finds the multipliers of
//! constraints without ever solving them exactly. Where a cloth is at rest its springs are then as long as their tensions say.
//!
//! Shifts follow a load late, and what follows late gives energy to what swings: as the springs that are shifted hardly
//! stretch, less of it than drag takes, while shifts grow no faster than drag brakes. Without drag or air none grow. Where a cloth touches
//! nothing, a shift that is not needed any more goes sooner than it came: what is let go does not contract.
//!
//! | | springs |
//! | --- | --- |
//! | `chains` | of the chains of a mesh |
//! | `lines` | of a sheet's weft, warp and diagonals |

mod chains;
mod lines;

pub(crate) use chains::ShiftSprings;
pub(crate) use lines::{LineSprings, SheetShifts, ShiftsMut, ShiftsOfBundle};

use crate::solver::settings::Material;
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Array;

/// Rate at which shifts grow, for a rate of drag of one.
const GROWTH: f32 = 1.0;
/// Rate at which shifts grow where the cloth touches colliders, for a rate of drag of one: its corrections are of first order there,
/// which damps what they stretch, and friction stops the rest.
const GROWTH_ON_COLLIDERS: f32 = 20.0;
/// Rate at which shifts grow there at most, and at which those go that are too large \[1/s\]. With twice as much a mesh of few substeps
/// trembles on a cone. Were they to go many times sooner than they come, what trembles would take away more than it gives, and creep.
const MOST_ON_COLLIDERS: f32 = 4.0;
/// Rate at which shifts grow where the cloth carries bodies, for a rate of drag of one and substeps of one second, and a cloth that has next
/// to all of the mass \[s\]. It goes with the square of the cloth's share of the mass: drag brakes both by that, and what threads leave to
/// do is the more, the more a body weighs.
const GROWTH_UNDER_BODIES: f32 = 5.6e-3;
/// Rate at which shifts grow there at most, for a rate of drag of one, and at which those go that are too large \[1/s\]. Were they to go many
/// times sooner than they come, a swing of a body would take away more than it gives.
const MOST_UNDER_BODIES: f32 = 0.75;
/// Both rates of the shifts of a mesh, whose chains leave more to do. With twice the growth, light bodies come to swing within half a
/// minute, with eight substeps.
const OF_CHAINS_UNDER_BODIES: [f32; 2] = [5e-4, 0.25];
/// Least share of the mass that moves which a cloth has or moves as if it had (`state::carrying`), at which springs are shifted and the
/// diagonals of a sheet are solved whole. One of less hangs hardly higher by that, and what it carries swings for longer.
pub(crate) const LEAST_SHARE: f32 = 0.05;
/// Rate of drag that air stands for \[1/s\]: the drag of light cotton at a quarter of a metre a second.
pub(crate) const DRAG_OF_AIR: f32 = Material::USUAL.drag;
/// Rate at which shifts that are too large go \[1/s\].
const RELEASE: f32 = 20.0;
/// Part of an error that a tick makes up for at most.
const MOST_OF_ERROR: f32 = 1.0 / 3.0;
/// Strain for a substep of one second that is left as it is \[1/s\]. What lies on a collider would slide on for ever to make up for the last
/// of it.
const LEFT: f32 = 2.4;
/// Least shift, in rest lengths. Springs that are pushed together are few, and little.
const LEAST: f32 = -0.1;
/// Least shift of the springs of a mesh on colliders. A mesh that lies in folds is pushed together in many places, by more than its chains can
/// undo: what is asked to be longer and longer there pushes the mesh about.
const LEAST_ON_COLLIDERS: f32 = 0.0;

/// The shifts of the springs of some threads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shifts {
    /// How much shorter than it is to be a spring is asked to be \[m\].
    pub by: Array,
    /// The multipliers of the springs in the last substep \[kg m\]: what pulled at both ends, over their inverse masses.
    pub multipliers: Array,
}

impl Shifts {
    /// Makes shifts of so many springs, all of them zero.
    pub fn none(springs: usize) -> Self {
        Self { by: Array::zeros(springs), multipliers: Array::zeros(springs) }
    }
}

/// Kinds of things that a cloth touches, as far as its shifts differ by them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Touches {
    Nothing,
    /// Colliders that it does not move.
    Colliders,
    /// Bodies that it has met, or what presses on it where it is pinned; and the cloth's share of the mass that moves, its own and that of what it
    /// carries of them.
    Carried {
        share: f32,
    },
}

/// How shifts change in a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shifting {
    /// Part of an error by which a shift grows that is too small.
    grows: f32,
    /// Part of an error by which a shift shrinks that is too large.
    goes: f32,
    /// Strain that is left as it is.
    left: f32,
    /// Strain that a spring is held to, whatever pulls at it.
    most_strain: f32,
    /// Least shift, in rest lengths.
    least_shift: f32,
}

impl Shifting {
    /// Shifts change so in a tick of such substeps \[s\], under a rate of drag \[1/s\]. Where that is zero, shifts that are too large go,
    /// and none grow.
    pub fn new(
        [tick, substep]: [f32; 2],
        drag: f32,
        touches: Touches,
        is_of_chains: bool,
        most_strain: f32,
    ) -> Self {
        let [under_bodies, most_under_bodies] = match is_of_chains {
            true => OF_CHAINS_UNDER_BODIES,
            false => [GROWTH_UNDER_BODIES, MOST_UNDER_BODIES],
        };
        let on_colliders = smaller(GROWTH_ON_COLLIDERS * drag, MOST_ON_COLLIDERS);
        let (growth, release) = match touches {
            Touches::Nothing => (GROWTH * drag, RELEASE),
            Touches::Colliders => (on_colliders, MOST_ON_COLLIDERS),
            Touches::Carried { share } => {
                let growth = under_bodies * share * share / substep;
                (smaller(growth, most_under_bodies) * drag, most_under_bodies)
            }
        };
        let part = |rate: f32| smaller(rate * tick, MOST_OF_ERROR);
        let least_shift = match touches {
            Touches::Colliders if is_of_chains => LEAST_ON_COLLIDERS,
            _ => LEAST,
        };
        let (grows, goes, left) = (part(growth), part(release), LEFT * substep);
        Self { grows, goes, left, most_strain, least_shift }
    }

    /// Keeps shifts from growing.
    pub fn without_growth(self) -> Self {
        Self { grows: 0.0, ..self }
    }

    /// Whether shifts may come to be where there were none.
    pub fn grows(&self) -> bool {
        self.grows > 0.0
    }
}

/// Springs of a row, from one end to the other.
struct Row<'a> {
    ends: [&'a Block3; 2],
    rest: Block,
    /// One over their shape factors.
    factor: Block,
    multipliers: Block,
    /// Compliance in the last substep of a spring of shape factor one \[1/kg\].
    compliance: f32,
    /// Largest shift, in rest lengths.
    most: f32,
}

impl Row<'_> {
    /// Shifts after a tick, for those before.
    #[inline(always)]
    fn shifted(&self, mut by: Block, shifting: Shifting) -> Block {
        let Self { ends: [p, q], rest, factor, multipliers, compliance, most } = self;
        let Shifting { grows, goes, left, most_strain, least_shift } = shifting;
        for i in 0..LANES {
            let way = q.at(i) - p.at(i);
            let length = way.dot(way).sqrt();
            let elastic = multipliers.0[i] * factor.0[i] * compliance;
            let error = length - rest.0[i] - smaller(elastic, rest.0[i] * most_strain);
            let least = left * rest.0[i];
            // Nothing, where any of it is not a number.
            let error = larger(error - least, 0.0) + smaller(error + least, 0.0);
            let part = if error * by.0[i] < 0.0 { goes } else { grows };
            let next = by.0[i] + part * error;
            let next = smaller(larger(next, least_shift * rest.0[i]), most * rest.0[i]);
            by.0[i] = if rest.0[i] > 0.0 { next } else { 0.0 };
        }
        by
    }
}

/// Whether springs of such rest lengths can be shifted so, by no more than `most` rest lengths.
fn are_within(by: &[f32], mut rests: impl Iterator<Item = f32>, most: f32) -> bool {
    let is_good =
        |by: &f32| rests.next().is_some_and(|rest| (LEAST * rest..=most * rest).contains(by));
    by.iter().all(is_good) && rests.next().is_none()
}
