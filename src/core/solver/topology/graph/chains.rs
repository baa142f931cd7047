//! Chains: the threads of a mesh. Its structural springs are laid end to end into lines as straight as
//! the mesh allows, each spring in one of them, and each chain is solved whole as a lattice's threads
//! are, [`LANES`] side by side.
//!
//! On a triangulated grid the chains are its warp and weft; on other meshes they cross in all
//! directions. Chains that share a particle are in different batches, taken one after the other. A
//! chain of one spring is XPBD's (Macklin, Mueller and Chentanez 2016); a long one carries its load at
//! once.

use bevy_math::DVec3;

use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Array;
use crate::solver::topology::graph::Link;
use crate::solver::topology::graph::coloring::Palette;

/// Springs of a chain at most: longer ones carry further, but leave lanes unused.
const LONGEST: usize = 32;
/// Least cosine of the turn from one spring of a chain to the next.
const STRAIGHT: f64 = 0.5;

/// Chains side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bundle {
    /// The entry where its first row begins.
    pub first: usize,
    /// Rows of particles: springs and one.
    pub rows: usize,
}

/// All chains, in rows of [`LANES`]: a row holds a particle of each chain of a bundle and the spring
/// to it from the one before. Unused lanes have the particle beside the cloth.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chains {
    pub bundles: Vec<Bundle>,
    /// Slots of the particles.
    pub slots: Vec<u32>,
    /// Rest length \[m\]; 0 where there is no spring.
    pub rest: Array,
    /// 1 / shape factor; infinite where there is no spring.
    pub compliance: Array,
}

/// One chain: particles, and the springs between them.
#[derive(Clone, Debug, Default)]
struct Chain {
    slots: Vec<u32>,
    links: Vec<u32>,
}

impl Chains {
    /// Lays the springs of particles at rest in `positions`.
    pub fn new(positions: &[DVec3], links: &[Link]) -> Self {
        let mut chains = lay(positions, links);
        // Long ones first: they meet most others and find few colours free later on.
        chains.sort_by_key(|chain| core::cmp::Reverse(chain.links.len()));
        let mut palette = Palette::new(positions.len());
        let mut coloured: Vec<(u32, Chain)> = Vec::with_capacity(chains.len());
        for chain in chains {
            coloured.push((palette.colour(&chain.slots), chain));
        }
        coloured.sort_by_key(|&(colour, _)| colour);
        let mut out = Rows::default();
        for batch in coloured.chunk_by(|a, b| a.0 == b.0) {
            for bundle in batch.chunks(LANES) {
                out.add(bundle, links, positions.len() as u32);
            }
        }
        let array = |values: &[f32]| {
            let mut array = Array::zeros(values.len());
            array.copy_from_slice(values);
            array
        };
        Self {
            rest: array(&out.rest),
            compliance: array(&out.compliance),
            bundles: out.bundles,
            slots: out.slots,
        }
    }

    /// Rows of the longest bundle.
    pub fn longest(&self) -> usize {
        self.bundles.iter().map(|bundle| bundle.rows).max().unwrap_or(0)
    }
}

#[derive(Default)]
struct Rows {
    bundles: Vec<Bundle>,
    slots: Vec<u32>,
    rest: Vec<f32>,
    compliance: Vec<f32>,
}

impl Rows {
    fn add(&mut self, chains: &[(u32, Chain)], links: &[Link], beside: u32) {
        let rows = chains.iter().map(|(_, chain)| chain.slots.len()).max().unwrap_or(0);
        self.bundles.push(Bundle { first: self.slots.len(), rows });
        for row in 0..rows {
            for lane in 0..LANES {
                let chain = chains.get(lane).map(|(_, chain)| chain);
                let slot = chain.and_then(|chain| chain.slots.get(row));
                let before = row.checked_sub(1);
                let link = chain.zip(before).and_then(|(chain, at)| chain.links.get(at));
                let link = link.map(|&link| links[link as usize]);
                self.slots.push(slot.copied().unwrap_or(beside));
                self.rest.push(link.map_or(0.0, |link| link.rest));
                self.compliance.push(link.map_or(f32::INFINITY, |link| 1.0 / link.shape));
            }
        }
    }
}

/// Lays all springs end to end: from each that is left, both ways, as far as it goes straight on.
fn lay(positions: &[DVec3], links: &[Link]) -> Vec<Chain> {
    let mut layer = Layer::new(positions, links);
    let mut chains = Vec::new();
    for (link, &Link { ends: [a, b], .. }) in links.iter().enumerate() {
        if layer.used[link] {
            continue;
        }
        layer.used[link] = true;
        let mut chain = Chain { slots: vec![a, b], links: vec![link as u32] };
        layer.extend(&mut chain);
        chain.slots.reverse();
        chain.links.reverse();
        layer.extend(&mut chain);
        chains.push(chain);
    }
    chains
}

struct Layer<'a> {
    positions: &'a [DVec3],
    links: &'a [Link],
    used: Vec<bool>,
    /// Springs of each particle: from `first[i]` to `first[i + 1]`.
    first: Vec<u32>,
    at: Vec<u32>,
}

impl<'a> Layer<'a> {
    fn new(positions: &'a [DVec3], links: &'a [Link]) -> Self {
        let mut ends: Vec<(u32, u32)> = links
            .iter()
            .enumerate()
            .flat_map(|(link, Link { ends: [a, b], .. })| [(*a, link as u32), (*b, link as u32)])
            .collect();
        ends.sort_unstable();
        let first = (0..=positions.len() as u32)
            .map(|slot| ends.partition_point(|&(at, _)| at < slot) as u32)
            .collect();
        let at = ends.into_iter().map(|(_, link)| link).collect();
        Self { positions, links, used: vec![false; links.len()], first, at }
    }

    /// Goes on from a chain's last particle.
    fn extend(&mut self, chain: &mut Chain) {
        while chain.links.len() < LONGEST {
            let [.., before, last] = chain.slots[..] else { return };
            let Some((link, next)) = self.straightest(before, last, chain) else { return };
            self.used[link as usize] = true;
            chain.links.push(link);
            chain.slots.push(next);
        }
    }

    /// The unused spring at `last` that goes on from `before` with the least turn, to a particle that
    /// the chain does not have.
    fn straightest(&self, before: u32, last: u32, chain: &Chain) -> Option<(u32, u32)> {
        let at = |slot: u32| self.positions[slot as usize];
        let along = (at(last) - at(before)).normalize_or_zero();
        let mut best = None;
        let mut least = STRAIGHT;
        for &link in
            &self.at[self.first[last as usize] as usize..self.first[last as usize + 1] as usize]
        {
            let [a, b] = self.links[link as usize].ends;
            let next = if a == last { b } else { a };
            let straight = (at(next) - at(last)).normalize_or_zero().dot(along);
            if !self.used[link as usize] && straight > least && !chain.slots.contains(&next) {
                (best, least) = (Some((link, next)), straight);
            }
        }
        best
    }
}
