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
use crate::solver::topology::buckets::Buckets;
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

/// The chains of some springs, in rows of [`LANES`]: a row holds a particle of each chain of a bundle and the spring
/// to it from the one before. Unused lanes hold the first particle of all, and no spring.
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
                out.add(bundle, links);
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
    fn add(&mut self, chains: &[(u32, Chain)], links: &[Link]) {
        let first = self.slots.len();
        let rows = chains.iter().map(|(_, chain)| chain.slots.len()).max().unwrap_or(0);
        for row in 0..rows {
            for lane in 0..LANES {
                let chain = chains.get(lane).map(|(_, chain)| chain);
                let slot = chain.and_then(|chain| chain.slots.get(row));
                let before = row.checked_sub(1);
                let link = chain.zip(before).and_then(|(chain, at)| chain.links.get(at));
                let link = link.map(|&link| links[link as usize]);
                self.slots.push(slot.copied().unwrap_or(0));
                self.rest.push(link.map_or(0.0, |link| link.rest));
                self.compliance.push(link.map_or(f32::INFINITY, |link| 1.0 / link.shape));
            }
        }
        self.bundles.push(Bundle { first, rows });
    }
}

/// Lays all springs end to end: at each particle they are paired, the straightest pair first, and from each spring it
/// goes on to its partners. A path that is too long, or comes back to where it was, is cut.
fn lay(positions: &[DVec3], links: &[Link]) -> Vec<Chain> {
    let partners = pair(positions, links);
    let mut is_laid = vec![false; links.len()];
    let mut chains = Vec::new();
    for link in 0..links.len() as u32 {
        if is_laid[link as usize] {
            continue;
        }
        let [first, second] = links[link as usize].ends;
        is_laid[link as usize] = true;
        let mut path = Chain { slots: vec![second, first], links: vec![link] };
        extend(&mut path, links, &partners, &mut is_laid);
        path.slots.reverse();
        path.links.reverse();
        extend(&mut path, links, &partners, &mut is_laid);
        path.cut(&mut chains);
    }
    chains
}

/// Goes on from a path's last particle until there is no spring left.
fn extend(path: &mut Chain, links: &[Link], partners: &[[u32; 2]], is_laid: &mut [bool]) {
    while let ([.., last], [.., link]) = (&path.slots[..], &path.links[..]) {
        let [first, _] = links[*link as usize].ends;
        let next = partners[*link as usize][usize::from(first != *last)];
        if next == NONE || is_laid[next as usize] {
            return;
        }
        let [a, b] = links[next as usize].ends;
        is_laid[next as usize] = true;
        path.slots.push(if a == *last { b } else { a });
        path.links.push(next);
    }
}

/// The spring that each goes on to at its first end, and at its second.
fn pair(positions: &[DVec3], links: &[Link]) -> Vec<[u32; 2]> {
    // Springs by particle: which, and which of its ends.
    let both = |(i, link): (u32, &Link)| [0, 1].map(|end| (link.ends[end], (i, end)));
    let ends: Vec<(u32, (u32, usize))> = (0..).zip(links).flat_map(both).collect();
    let ends = Buckets::new(positions.len(), &ends);
    let mut partners = vec![[NONE; 2]; links.len()];
    let mut turns = Vec::new();
    for (position, at_particle) in positions.iter().zip(ends.each()) {
        let away = |&(link, end): &(u32, usize)| {
            let other = links[link as usize].ends[1 - end];
            (positions[other as usize] - position).normalize_or_zero()
        };
        turns.clear();
        for (i, a) in at_particle.iter().enumerate() {
            for (j, b) in at_particle.iter().enumerate().skip(i + 1) {
                let straight = -away(a).dot(away(b));
                if straight > STRAIGHT {
                    turns.push((straight, i, j));
                }
            }
        }
        // Equals in the order of the springs.
        turns.sort_by(|a, b| b.0.total_cmp(&a.0));
        for &(_, i, j) in &turns {
            let [(a, end_a), (b, end_b)] = [at_particle[i], at_particle[j]];
            if partners[a as usize][end_a] == NONE && partners[b as usize][end_b] == NONE {
                partners[a as usize][end_a] = b;
                partners[b as usize][end_b] = a;
            }
        }
    }
    partners
}

/// No spring.
const NONE: u32 = u32::MAX;

impl Chain {
    /// Cuts a path into chains of about one length, none of which meets itself.
    fn cut(&self, chains: &mut Vec<Self>) {
        let pieces = self.links.len().div_ceil(LONGEST);
        let most = self.links.len().div_ceil(pieces);
        let mut from = 0;
        while from < self.links.len() {
            let mut to = from + 1;
            while to < self.links.len()
                && to - from < most
                && !self.slots[from..=to].contains(&self.slots[to + 1])
            {
                to += 1;
            }
            let (slots, links) = (self.slots[from..=to].to_vec(), self.links[from..to].to_vec());
            chains.push(Self { slots, links });
            from = to;
        }
    }
}
