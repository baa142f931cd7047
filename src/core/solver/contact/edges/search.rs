//! The place of an edge that is nearest to a solid, by golden-section search (Kiefer 1953): 16 edges at a time.

use super::super::super::lanes::{LANES, Soa};
use super::super::collider::{Frame, Motion};
use crate::sdf::PointBlock;

/// Steps of the search: each leaves 0.618 of the edge. Two ends of a bracket come before them.
const STEPS: usize = 6;
/// Part of an edge by which the place that the search finds may be off.
pub(super) const UNSURE: f32 = 0.06;
/// The smaller part of a golden section.
const GOLDEN: f32 = 0.381_966_02;

/// Edges in a collider's frame, of which the places nearest to it are searched.
pub(super) struct Search {
    from: PointBlock,
    way: PointBlock,
}

impl Search {
    pub fn new(ends: &[[usize; 2]; LANES], x: &Soa, d: &Soa, frame: &Frame) -> Self {
        let mut search = Self { from: PointBlock::default(), way: PointBlock::default() };
        for (lane, &[a, b]) in ends.iter().enumerate() {
            let (from, to) = (x.get(a) + d.get(a), x.get(b) + d.get(b));
            let (from, to) = (frame.to_local(from), frame.to_local(to));
            search.from.set(lane, from);
            search.way.set(lane, to - from);
        }
        search
    }

    /// The nearest places, as parts of the ways, and their distances.
    pub fn nearest(&self, motion: &Motion<'_>) -> ([f32; LANES], [f32; LANES]) {
        let (mut low, mut high) = ([0.0; LANES], [1.0; LANES]);
        let mut inner = [[GOLDEN; LANES], [1.0 - GOLDEN; LANES]];
        let mut found = [self.distances(&inner[0], motion), self.distances(&inner[1], motion)];
        for _ in 0..STEPS {
            let mut probe = [0.0; LANES];
            for i in 0..LANES {
                let is_low = found[0][i] < found[1][i];
                low[i] = if is_low { low[i] } else { inner[0][i] };
                high[i] = if is_low { inner[1][i] } else { high[i] };
                let width = (high[i] - low[i]) * GOLDEN;
                probe[i] = if is_low { low[i] + width } else { high[i] - width };
            }
            let new = self.distances(&probe, motion);
            for i in 0..LANES {
                let is_low = found[0][i] < found[1][i];
                let kept =
                    if is_low { (inner[0][i], found[0][i]) } else { (inner[1][i], found[1][i]) };
                let new = (probe[i], new[i]);
                let (first, second) = if is_low { (new, kept) } else { (kept, new) };
                (inner[0][i], found[0][i]) = first;
                (inner[1][i], found[1][i]) = second;
            }
        }
        let (mut at, mut distance) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let is_first = found[0][i] < found[1][i];
            at[i] = if is_first { inner[0][i] } else { inner[1][i] };
            distance[i] = if is_first { found[0][i] } else { found[1][i] };
        }
        (at, distance)
    }

    fn distances(&self, at: &[f32; LANES], motion: &Motion<'_>) -> [f32; LANES] {
        let mut points = PointBlock::default();
        for (i, at) in at.iter().enumerate() {
            points.x[i] = self.from.x[i] + self.way.x[i] * at;
            points.y[i] = self.from.y[i] + self.way.y[i] * at;
            points.z[i] = self.from.z[i] + self.way.z[i] * at;
        }
        let mut distances = [0.0; LANES];
        motion.shape.distance_block(&points, &mut distances);
        distances
    }
}
