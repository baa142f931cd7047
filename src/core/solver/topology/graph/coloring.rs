//! Springs sorted into batches that share no particle, [`LANES`] side by side.

use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Array;
use crate::solver::topology::graph::Link;

/// Colours that are told apart; what has none of them gets a batch of its own.
const COLOURS: usize = 64;

/// Gives things that touch particles colours, the lowest that none of their particles has yet.
pub(crate) struct Palette {
    taken: Vec<u64>,
    beyond: u32,
}

impl Palette {
    pub fn new(particles: usize) -> Self {
        Self { taken: vec![0; particles], beyond: COLOURS as u32 }
    }

    pub fn colour(&mut self, slots: &[u32]) -> u32 {
        let taken = slots.iter().fold(0, |taken, &slot| taken | self.taken[slot as usize]);
        if taken == u64::MAX {
            self.beyond += 1;
            return self.beyond - 1;
        }
        let colour = taken.trailing_ones();
        for &slot in slots {
            self.taken[slot as usize] |= 1 << colour;
        }
        colour
    }
}

/// Springs in rows of [`LANES`] that share no particle. Unused lanes hold the first particle of all, at both ends of a
/// spring without rest length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pairs {
    /// Slots of first and second ends.
    pub first: Vec<u32>,
    pub second: Vec<u32>,
    /// Rest length \[m\]; 0 in unused lanes.
    pub rest: Array,
    /// 1 / shape factor; infinite in unused lanes.
    pub compliance: Array,
}

impl Pairs {
    pub fn new(particles: usize, links: &[Link]) -> Self {
        let mut palette = Palette::new(particles);
        let mut coloured: Vec<(u32, usize)> = links
            .iter()
            .enumerate()
            .map(|(link, Link { ends, .. })| (palette.colour(ends), link))
            .collect();
        coloured.sort_unstable();
        let mut order = Vec::new();
        for batch in coloured.chunk_by(|a, b| a.0 == b.0) {
            order.extend(batch.iter().map(|&(_, link)| Some(links[link])));
            order.resize(order.len().next_multiple_of(LANES), None);
        }
        let end = |i: usize| move |link: &Option<Link>| link.map_or(0, |link| link.ends[i]);
        let mut rest = Array::zeros(order.len());
        let mut compliance = Array::zeros(order.len());
        for (i, link) in order.iter().enumerate() {
            rest[i] = link.map_or(0.0, |link| link.rest);
            compliance[i] = link.map_or(f32::INFINITY, |link| 1.0 / link.shape);
        }
        Self {
            first: order.iter().map(end(0)).collect(),
            second: order.iter().map(end(1)).collect(),
            rest,
            compliance,
        }
    }
}
