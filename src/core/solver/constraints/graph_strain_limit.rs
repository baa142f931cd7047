//! Springs of a triangle mesh, corrected batch by batch: shear, and Provot's limit of strain.

use crate::solver::constraints::strain_check::{CLOSE, Limit};
use crate::solver::constraints::strain_limit::{
    LEAST_DIVISOR, LEAST_LENGTH, Rule, Spring, mobility,
};
use crate::solver::contact::divide;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::gather::{PlacesMut, gather_from};
use crate::solver::simd::isa::{Kernel, TransposingKernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::Largest;
use crate::solver::simd::soa::Soa;
use crate::solver::simd::transpose::Transpose;
use crate::solver::topology::graph::coloring::Pairs;
use crate::solver::topology::graph::domains::{Domain, DomainBand, cut_between_domains};

/// Moves the ends of springs towards their target lengths. Tells whether any was more than [`CLOSE`] away.
pub(crate) struct CorrectPairs<'a> {
    pub band: DomainBand,
    pub domains: &'a [Domain<Pairs>],
    pub rule: Rule,
    /// Whether any particle lies on a collider.
    pub touches: bool,
    pub places: PlacesMut<'a>,
    /// Notes of each domain, from the last look at its springs, which ones to look at again; none where a rule looks at all of them.
    pub near: Option<&'a mut [NearLimit]>,
}

/// Whether any spring of a row was near its limit when it was last looked at, by rows.
pub(crate) type NearLimit = Box<[bool]>;

cut_between_domains!(
    CorrectPairs: TransposingKernel, run_transposing;
    domains; by slot places; by domain near
);

impl TransposingKernel for CorrectPairs<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(mut self, t: impl Transpose) -> bool {
        let mut is_beyond = false;
        for (at, Domain { slots, work: pairs }) in self.domains.iter().enumerate() {
            let (touches, places) = (self.touches, self.places.within(slots));
            match self.rule {
                Rule::Shear { compliance, limit } => {
                    correct(t, pairs, touches, places, None, |spring| {
                        let elastic = (spring.length - spring.rest)
                            / (spring.inverse_masses + spring.factor * compliance);
                        larger(elastic, spring.pull_to(limit))
                    });
                }
                Rule::Limit(limit) => {
                    let near = self.near.as_mut().map(|near| (limit, &mut *near[at]));
                    let law = |spring: Spring| larger(spring.pull_to(limit.longest), 0.0);
                    is_beyond |= correct(t, pairs, touches, places, near, law);
                }
            }
        }
        is_beyond
    }
}

/// Corrects springs by a law, of the limit perhaps only those that are near it. Tells whether any is moved by more than [`CLOSE`] of
/// its rest length.
#[inline(always)]
fn correct(
    t: impl Transpose,
    pairs: &Pairs,
    touches: bool,
    mut places: PlacesMut<'_>,
    mut near: Option<(Limit, &mut [bool])>,
    law: impl Fn(Spring) -> f32 + Copy,
) -> bool {
    let mut farthest = Block::ZERO;
    for (row, at) in (0..pairs.first.len()).step_by(LANES).enumerate() {
        if let Some((limit, near)) = &near
            && !(limit.all || near[row])
        {
            continue;
        }
        let (first, second) = (&pairs.first, &pairs.second);
        let rest = Block::load(&pairs.rest, at);
        let factor = Block::load(&pairs.compliance, at);
        // Not by closures, which would be calls.
        let ((xp, wp), (xq, wq), normals) = if touches {
            let (xp, wp, np) = places.gather_lying(t, first, at);
            let (xq, wq, nq) = places.gather_lying(t, second, at);
            ((xp, wp), (xq, wq), Some([np, nq]))
        } else {
            (places.gather_moved(t, first, at), places.gather_moved(t, second, at), None)
        };
        let (mut pulls, mut lengths) = (Block3::ZERO, Block::ZERO);
        let mut strongest = Block::ZERO;
        for i in 0..LANES {
            let way = xq.at(i) - xp.at(i);
            let length = larger(way.dot(way).sqrt(), LEAST_LENGTH);
            let all = wp.0[i] + wq.0[i];
            let both = match &normals {
                Some([np, nq]) => {
                    let across = [np.at(i).dot(way), nq.at(i).dot(way)];
                    mobility(all, across, length, [wp.0[i], wq.0[i]])
                }
                None => all,
            };
            let inverse_masses = larger(both, LEAST_DIVISOR);
            let spring = Spring { length, rest: rest.0[i], factor: factor.0[i], inverse_masses };
            let strength = law(spring);
            strongest.0[i] = strength.abs();
            // What is held at both ends does not move.
            farthest.0[i] = larger(farthest.0[i], strength * both - CLOSE * rest.0[i]);
            pulls.set(i, way * (strength / length));
            lengths.0[i] = length;
        }
        if let Some((limit, near)) = &mut near {
            near[row] = is_any_longer(&lengths, &rest, limit.near());
        }
        // Few springs are beyond their limit, and to put back what has not moved is dear.
        if strongest.largest() == 0.0 {
            continue;
        }
        let (mut pull_p, mut pull_q, mut loads) = (pulls, pulls, None);
        if let Some([np, nq]) = &normals {
            let ((along_p, load_p), (along_q, load_q)) = (divide(&pulls, np), divide(&pulls, nq));
            (pull_p, pull_q, loads) = (along_p, along_q, Some([load_p, load_q.negated()]));
        }
        let (mut dp, mut dq) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            dp.set(i, pull_p.at(i) * wp.0[i]);
            dq.set(i, pull_q.at(i) * -wq.0[i]);
        }
        if let Some([load_p, load_q]) = &loads {
            places.scatter_lying(t, first, at, dp, load_p);
            places.scatter_lying(t, second, at, dq, load_q);
        } else {
            places.scatter(t, first, at, dp);
            places.scatter(t, second, at, dq);
        }
    }
    farthest.largest() > 0.0
}

/// Whether any spring is longer than so many rest lengths.
#[inline(always)]
fn is_any_longer(lengths: &Block, rest: &Block, many: f32) -> bool {
    let mut over = Block::ZERO;
    for i in 0..LANES {
        // Unused lanes have no rest length.
        over.0[i] = if rest.0[i] > 0.0 { lengths.0[i] - rest.0[i] * many } else { 0.0 };
    }
    over.is_any_above(0.0)
}

/// The largest strain of springs.
pub(crate) struct LargestStrain<'a> {
    pub band: DomainBand,
    pub domains: &'a [Domain<Pairs>],
    pub x: &'a Soa,
}

cut_between_domains!(LargestStrain: Kernel, run; domains);

impl Kernel for LargestStrain<'_> {
    type Output = Largest;

    #[inline(always)]
    fn run(self) -> Largest {
        let mut largest = Block::splat(-1.0);
        for Domain { slots, work: pairs } in self.domains {
            for at in (0..pairs.first.len()).step_by(LANES) {
                let rest = Block::load(&pairs.rest, at);
                let p = gather_from(self.x, slots.start, &pairs.first, at);
                let q = gather_from(self.x, slots.start, &pairs.second, at);
                for i in 0..LANES {
                    let way = q.at(i) - p.at(i);
                    let strain = way.dot(way).sqrt() / larger(rest.0[i], f32::MIN_POSITIVE) - 1.0;
                    let strain = if rest.0[i] > 0.0 { strain } else { -1.0 };
                    largest.0[i] = larger(strain, largest.0[i]);
                }
            }
        }
        Largest(largest.largest())
    }
}
