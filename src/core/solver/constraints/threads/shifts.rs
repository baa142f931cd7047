//! Shifts: what one pass over the chains of a mesh leaves to do in every substep, made up for over many ticks.
//!
//! Chains are solved one after the other, and each finds anew what the others undid. Under a load that lasts, springs
//! stay longer than their tensions say, by as much in every substep: a square metre of 64 x 64 that hangs from two corners
//! was 8 mm too long with 20 substeps, and 40 mm with 8. So each spring is asked to be shorter than it is to be, by what it
//! was too long at the ends of the ticks before: Powell's (1969) method of shifts, which finds the multipliers of
//! constraints without ever solving them exactly. Where a mesh is at rest its springs are then as long as their tensions say.
//!
//! Shifts follow a load late, and what follows late gives energy to what swings: as the springs that are shifted hardly
//! stretch, less of it than drag takes, while shifts grow no faster than drag brakes. Without drag or air none grow. A shift
//! that is not needed any more goes sooner than it came, so that a cloth that is let go does not contract.

use crate::solver::settings::Material;
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::gather::gather_from;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::graph::chains::Chains;
use crate::solver::topology::graph::domains::{Domain, DomainBand, Rounds, cut_between_domains};

/// Rate at which shifts grow, for a rate of drag of one.
const GROWTH: f32 = 1.0;
/// Rate at which shifts grow where the cloth touches colliders, for a rate of drag of one: its corrections are of first order there,
/// which damps what they stretch, and friction stops the rest.
const GROWTH_ON_COLLIDERS: f32 = 20.0;
/// Rate at which shifts grow there at most \[1/s\]. With twice as much a mesh of few substeps trembles on a cone.
const MOST_ON_COLLIDERS: f32 = 4.0;
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
/// Largest shift, in rest lengths. Near a corner that bears the whole cloth, few substeps leave a quarter.
const MOST: f32 = 0.3;

/// The shifts of the springs of a domain's chains, by the entries of the chains.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shifts {
    /// How much shorter than it is to be a spring is asked to be \[m\].
    pub by: Array,
    /// The multipliers of the springs in the last substep \[kg m\]: what pulled at both ends, over their inverse masses.
    pub multipliers: Array,
}

impl Shifts {
    /// None, for the chains of each domain, round after round.
    pub fn none(chains: &Rounds<Chains>) -> Vec<Vec<Self>> {
        let of_domain = |domain: &Domain<Chains>| {
            let none = || Array::zeros(domain.work.slots.len());
            Self { by: none(), multipliers: none() }
        };
        chains.0.iter().map(|round| round.iter().map(of_domain).collect()).collect()
    }

    /// Whether the springs of some chains can be shifted so, by entry, domain after domain.
    pub fn are_good(by: &[f32], chains: &Rounds<Chains>) -> bool {
        let mut rests = chains.iter().flat_map(|domain| domain.work.rest.iter());
        let is_good =
            |by: &f32| rests.next().is_some_and(|rest| (LEAST * rest..=MOST * rest).contains(by));
        by.iter().all(is_good) && rests.next().is_none()
    }
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
}

impl Shifting {
    /// Shifts change so in a tick of such substeps \[s\], under a rate of drag \[1/s\]. Where that is zero, shifts that are too large go,
    /// and none grow.
    pub fn new(tick: f32, substep: f32, drag: f32, touches: bool) -> Self {
        let growth = if touches {
            smaller(GROWTH_ON_COLLIDERS * drag, MOST_ON_COLLIDERS)
        } else {
            GROWTH * drag
        };
        let part = |rate: f32| smaller(rate * tick, MOST_OF_ERROR);
        Self { grows: part(growth), goes: part(RELEASE), left: LEFT * substep }
    }

    /// Whether shifts may come to be where there were none.
    pub fn grows(&self) -> bool {
        self.grows > 0.0
    }
}

/// Shifts the springs of a round by what they are too long at the end of a tick.
pub(crate) struct ShiftSprings<'a> {
    pub band: DomainBand,
    pub domains: &'a [Domain<Chains>],
    pub shifting: Shifting,
    /// Compliance in the last substep of a spring of shape factor one \[1/kg\].
    pub compliance: f32,
    pub x: &'a Soa,
    pub shifts: &'a mut [Shifts],
}

cut_between_domains!(ShiftSprings: Kernel, run; domains; by domain shifts);

impl Kernel for ShiftSprings<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { domains, shifting, compliance, x, shifts, .. } = self;
        for (Domain { slots, work: chains }, shifts) in domains.iter().zip(shifts) {
            for bundle in &chains.bundles {
                let mut p = gather_from(x, slots.start, &chains.slots, bundle.first);
                for place in 1..bundle.rows {
                    let at = bundle.first + place * LANES;
                    let q = gather_from(x, slots.start, &chains.slots, at);
                    shift(shifting, compliance, [&p, &q], chains, shifts, at);
                    p = q;
                }
            }
        }
    }
}

/// Shifts the springs of a row, which go from `p` to `q`.
#[inline(always)]
fn shift(
    shifting: Shifting,
    compliance: f32,
    [p, q]: [&Block3; 2],
    chains: &Chains,
    shifts: &mut Shifts,
    at: usize,
) {
    let Shifting { grows, goes, left } = shifting;
    let rest = Block::load(&chains.rest, at);
    let factor = Block::load(&chains.compliance, at);
    let multipliers = Block::load(&shifts.multipliers, at);
    let mut by = Block::load(&shifts.by, at);
    for i in 0..LANES {
        let way = q.at(i) - p.at(i);
        let length = way.dot(way).sqrt();
        let error = length - rest.0[i] - multipliers.0[i] * factor.0[i] * compliance;
        let least = left * rest.0[i];
        // Nothing, where any of it is not a number.
        let error = larger(error - least, 0.0) + smaller(error + least, 0.0);
        let part = if error * by.0[i] < 0.0 { goes } else { grows };
        let next = by.0[i] + part * error;
        let next = smaller(larger(next, LEAST * rest.0[i]), MOST * rest.0[i]);
        by.0[i] = if rest.0[i] > 0.0 { next } else { 0.0 };
    }
    by.store(&mut shifts.by, at);
}
