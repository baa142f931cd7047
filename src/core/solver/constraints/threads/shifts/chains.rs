//! Shifts of the springs of a mesh, by the entries of its chains.

use super::{Row, Shifting, Shifts, are_within};
use crate::solver::simd::block::Block;
use crate::solver::simd::gather::gather_from;
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::graph::chains::Chains;
use crate::solver::topology::graph::domains::{Domain, DomainBand, Rounds, cut_between_domains};

/// Largest shift, in rest lengths. Near a corner that bears the whole cloth, few substeps leave a quarter.
const MOST: f32 = 0.3;

impl Shifts {
    /// Makes the shifts of chains, all of them zero: for each domain, round after round.
    pub fn none_of_chains(chains: &Rounds<Chains>) -> Vec<Vec<Self>> {
        let of_domain = |domain: &Domain<Chains>| Self::none(domain.work.slots.len());
        chains.0.iter().map(|round| round.iter().map(of_domain).collect()).collect()
    }

    /// Whether the springs of some chains can be shifted so, by entry, domain after domain.
    pub fn can_be(chains: &Rounds<Chains>, kept: &[f32]) -> bool {
        let rests = chains.iter().flat_map(|domain| domain.work.rest.iter().copied());
        are_within(kept, rests, MOST)
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
        for (Domain { slots, work: chains }, Shifts { by, multipliers }) in
            domains.iter().zip(shifts)
        {
            for bundle in &chains.bundles {
                let mut p = gather_from(x, slots.start, &chains.slots, bundle.first);
                for place in 1..bundle.rows {
                    let at = bundle.first + place * LANES;
                    let q = gather_from(x, slots.start, &chains.slots, at);
                    let row = Row {
                        ends: [&p, &q],
                        rest: Block::load(&chains.rest, at),
                        factor: Block::load(&chains.compliance, at),
                        multipliers: Block::load(multipliers, at),
                        compliance,
                        most: MOST,
                    };
                    row.shifted(Block::load(by, at), shifting).store(by, at);
                    p = q;
                }
            }
        }
    }
}
