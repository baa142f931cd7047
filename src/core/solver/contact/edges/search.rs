//! The place of an edge that is nearest to a solid, by golden-section search (Kiefer 1953), and that of a face, by a few of
//! them: 16 at a time.

use crate::sdf::PointBlock;
use crate::solver::contact::collider::{Frame, Motion};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

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

/// The slots of so many edges or faces.
pub(super) type Corners<const N: usize> = [[usize; N]; LANES];

/// Where corners are to be, in a collider's frame.
fn corner<const N: usize>(
    corners: &Corners<N>,
    which: usize,
    x: &Soa,
    d: &Soa,
    frame: &Frame,
) -> PointBlock {
    let mut points = PointBlock::default();
    for (lane, slots) in corners.iter().enumerate() {
        let slot = slots[which];
        points.set(lane, frame.to_local(x.get(slot) + d.get(slot)));
    }
    points
}

/// The places of faces that are nearest, as parts of their corners, and their distances. The distance to a convex solid is a
/// convex function: along a line from a corner, along one beside the opposite side, and along the first again.
pub(super) fn nearest_on_faces(
    corners: &Corners<3>,
    x: &Soa,
    d: &Soa,
    motion: &Motion<'_>,
) -> ([[f32; 3]; LANES], [f32; LANES]) {
    let [a, b, c] = [0, 1, 2].map(|which| corner(corners, which, x, d, &motion.after));
    // How far from the first corner to the opposite side, and how far along that.
    let (mut out, mut beside) = ([1.0; LANES], [0.5; LANES]);
    let mut distance = [0.0; LANES];
    for round in 0..3 {
        let (mut from, mut to) = (PointBlock::default(), PointBlock::default());
        for i in 0..LANES {
            let [a, b, c] = [&a, &b, &c].map(|corner| corner.point(i));
            if round == 1 {
                from.set(i, a.lerp(b, out[i]));
                to.set(i, a.lerp(c, out[i]));
            } else {
                from.set(i, a);
                to.set(i, b.lerp(c, beside[i]));
            }
        }
        let (at, found) = Search::between(from, &to).nearest(motion);
        if round == 1 {
            beside = at;
        } else {
            out = at;
        }
        distance = found;
    }
    let mut parts = [[0.0; 3]; LANES];
    for i in 0..LANES {
        parts[i] = [1.0 - out[i], out[i] * (1.0 - beside[i]), out[i] * beside[i]];
    }
    (parts, distance)
}

impl Search {
    pub fn new(ends: &Corners<2>, x: &Soa, d: &Soa, frame: &Frame) -> Self {
        Self::between(corner(ends, 0, x, d, frame), &corner(ends, 1, x, d, frame))
    }

    fn between(from: PointBlock, to: &PointBlock) -> Self {
        let mut way = PointBlock::default();
        for lane in 0..LANES {
            way.set(lane, to.point(lane) - from.point(lane));
        }
        Self { from, way }
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
