//! Domains: what threads work on side by side of a large mesh, where a stage corrects spring by spring.
//!
//! A domain is a run of slots, and neighbours are near each other in their order (`reorder`). A spring belongs to the first
//! of three rounds in which one domain holds both of its ends. The domains of the first round are between the cuts, those
//! of the second go from the middle of each to the middle of the next and have the springs across the cuts, and the third is
//! the whole mesh. Where the cuts are depends on the mesh alone, so that bits are the same on any number of threads.

use core::ops::Range;

use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::topology::graph::Link;

/// Particles of a domain at least. Chains end where it does, so that smaller ones leave more to the next substep.
const LEAST: usize = 16_384;
/// Domains of a round at most.
const MOST: usize = 16;

/// Neighbouring slots, and the work on the springs within them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Domain<T> {
    pub slots: Range<usize>,
    pub work: T,
}

/// Rounds of domains: one round after the other, the domains of each side by side.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rounds<T>(pub Vec<Vec<Domain<T>>>);

impl<T> Rounds<T> {
    /// Shares springs out to domains. `make` is given the slots of a domain and its springs, whose ends count from the
    /// first of them.
    pub fn new(layout: Layout, links: &[Link], make: impl Fn(&Range<usize>, &[Link]) -> T) -> Self {
        let all = cuts(layout);
        let mut shared: Vec<Vec<Vec<Link>>> =
            all.iter().map(|cuts| vec![Vec::new(); cuts.len() - 1]).collect();
        for link in links {
            let within = |cuts: &Vec<usize>| domain(cuts, link.ends);
            let place =
                all.iter().enumerate().find_map(|(round, cuts)| Some((round, within(cuts)?)));
            let Some((round, domain)) = place else { continue };
            let first = all[round][domain] as u32;
            let ends = link.ends.map(|slot| slot - first);
            shared[round][domain].push(Link { ends, ..*link });
        }
        let rounds =
            all.iter().zip(&shared).filter(|(_, links)| links.iter().any(|l| !l.is_empty()));
        let domains = |(cuts, links): (&Vec<usize>, &Vec<Vec<Link>>)| {
            let domains = cuts.windows(2).zip(links).map(|(ends, links)| {
                let slots = ends[0]..ends[1];
                Domain { work: make(&slots, links), slots }
            });
            domains.collect()
        };
        Self(rounds.map(domains).collect())
    }

    /// The work of all domains, round after round.
    pub fn iter(&self) -> impl Iterator<Item = &Domain<T>> {
        self.0.iter().flatten()
    }

    /// Domains of the round of most.
    pub fn most(&self) -> usize {
        self.0.iter().map(Vec::len).max().unwrap_or(0)
    }
}

/// Where the domains of each round begin, and where the last of them ends.
fn cuts(layout: Layout) -> Vec<Vec<usize>> {
    let count = (layout.particles() / LEAST).clamp(1, MOST);
    let each = layout.len().div_ceil(count).next_multiple_of(LANES);
    let first: Vec<_> = (0..layout.len()).step_by(each).chain([layout.len()]).collect();
    if first.len() == 2 {
        return vec![first];
    }
    let middle = |ends: &[usize]| (ends[0] + ends[1]) / 2 / LANES * LANES;
    let second = first.windows(2).map(middle).collect();
    let third = vec![0, layout.len()];
    vec![first, second, third]
}

/// The domain that holds both ends.
fn domain(cuts: &[usize], ends: [u32; 2]) -> Option<usize> {
    let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])].map(|slot| slot as usize);
    let at = cuts.partition_point(|&cut| cut <= low).checked_sub(1)?;
    cuts.get(at + 1).is_some_and(|&end| high < end).then_some(at)
}

/// Some domains of a round that are worked on one after the other, or are to be cut further.
#[derive(Clone, Debug)]
pub(crate) struct DomainBand {
    count: usize,
    /// Whether they are shared out; else one follows the other.
    pub shared: bool,
}

impl DomainBand {
    /// All domains of a round.
    pub fn all<T>(round: &[Domain<T>], shared: bool) -> Self {
        Self { count: round.len(), shared }
    }

    /// The domain where it is cut next, if it is.
    pub fn middle(&self) -> Option<usize> {
        (self.count > 1).then_some(self.count / 2)
    }

    /// The domains before one, and from it on.
    pub fn cut(self, middle: usize) -> (Self, Self) {
        (Self { count: middle, ..self }, Self { count: self.count - middle, ..self })
    }
}

/// Data by domain of a round that a kernel writes, and that can be cut in two.
pub(crate) trait CutByDomain: Sized {
    /// The data before a domain, and the rest.
    fn cut_by_domain(self, domain: usize) -> (Self, Self);
}

impl<T> CutByDomain for &mut [T] {
    fn cut_by_domain(self, domain: usize) -> (Self, Self) {
        self.split_at_mut(domain)
    }
}

impl<T: CutByDomain> CutByDomain for Option<T> {
    fn cut_by_domain(self, domain: usize) -> (Self, Self) {
        self.map(|part| part.cut_by_domain(domain)).unzip()
    }
}

/// Makes a kernel with `domains` one that can be cut between them, with the fields that are by slot or by domain. What else it has, both
/// halves share.
macro_rules! cut_between_domains {
    (
        $kernel:ident: $trait:ident, $run:ident; domains
        $(; by slot $by_slot:ident)? $(; by domain $by_domain:ident)?
    ) => {
        impl $crate::solver::simd::parallel::Cut for $kernel<'_> {
            type Output = <Self as $crate::solver::simd::isa::$trait>::Output;

            fn middle(&self) -> Option<usize> {
                self.band.middle()
            }

            fn is_shared(&self) -> bool {
                self.band.shared
            }

            fn cut(self, middle: usize) -> (Self, Self) {
                $(
                    let slot = self.domains[middle].slots.start;
                    let $by_slot = $crate::solver::simd::slots::CutAt::cut(self.$by_slot, slot);
                )?
                $(
                    let $by_domain =
                        $crate::solver::topology::graph::domains::CutByDomain::cut_by_domain(
                            self.$by_domain,
                            middle,
                        );
                )?
                let domains = self.domains.split_at(middle);
                let (before, after) = self.band.cut(middle);
                (
                    Self {
                        band: before,
                        domains: domains.0,
                        $($by_slot: $by_slot.0,)?
                        $($by_domain: $by_domain.0,)?
                        ..self
                    },
                    Self {
                        band: after,
                        domains: domains.1,
                        $($by_slot: $by_slot.1,)?
                        $($by_domain: $by_domain.1,)?
                        ..self
                    },
                )
            }

            fn run(self, isa: $crate::solver::simd::isa::Isa) -> Self::Output {
                isa.$run(self)
            }
        }
    };
}

pub(crate) use cut_between_domains;
