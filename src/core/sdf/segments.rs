//! Which place of a segment is nearest to a solid.

use super::shapes::{larger, smaller};
use super::{LANES, PointBlock};

/// Steps of the search: each leaves 0.618 of a segment. Two places in it come before them.
const STEPS: usize = 6;
/// The smaller part of a golden section.
const GOLDEN: f32 = 0.381_966_02;
/// Part of a segment that stands for what distances are rounded by.
const ROUNDED: f32 = 1e-3;

/// [`LANES`] segments \[m\] as a structure of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentBlock {
    /// Where they begin \[m\].
    pub from: PointBlock,
    /// From there to where they end \[m\].
    pub way: PointBlock,
}

impl SegmentBlock {
    /// The segments between two blocks of points.
    #[inline(always)]
    pub fn between(from: &PointBlock, to: &PointBlock) -> Self {
        let mut way = PointBlock::default();
        for i in 0..LANES {
            way.x[i] = to.x[i] - from.x[i];
            way.y[i] = to.y[i] - from.y[i];
            way.z[i] = to.z[i] - from.z[i];
        }
        Self { from: *from, way }
    }

    /// The places at these parts of the ways.
    #[inline(always)]
    pub fn at(&self, parts: &[f32; LANES]) -> PointBlock {
        let Self { from, way } = self;
        let mut points = PointBlock::default();
        for (i, part) in parts.iter().enumerate() {
            points.x[i] = from.x[i] + way.x[i] * part;
            points.y[i] = from.y[i] + way.y[i] * part;
            points.z[i] = from.z[i] + way.z[i] * part;
        }
        points
    }

    /// The distances at these parts of the ways. It is no closure of [`search`]: that would not be compiled for the instructions around it.
    #[inline(always)]
    fn distances(
        &self,
        at: &[f32; LANES],
        measure: &mut impl FnMut(&PointBlock, &mut [f32; LANES]),
    ) -> [f32; LANES] {
        let mut distances = [0.0; LANES];
        measure(&self.at(at), &mut distances);
        distances
    }
}

/// The places of [`LANES`] segments that are nearest to a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NearestBlock {
    /// Parts of the ways to them, from 0 to 1.
    pub at: [f32; LANES],
    /// Distances there \[m\]. Negative inside.
    pub distance: [f32; LANES],
    /// No place of a segment is nearer than this, if the solid is convex or made of convex parts \[m\]. It is as true as the distances
    /// are: [`overestimate`](crate::sdf::SignedDistance::overestimate) still comes off.
    pub least: [f32; LANES],
}

/// Searches the nearest places by golden section (Kiefer 1953): where the distance is a convex function, as it is around a
/// convex solid, it finds them, and tells from what it saw beside them how much less it may be in between.
#[inline(always)]
pub(super) fn search(
    segments: &SegmentBlock,
    out: &mut NearestBlock,
    mut measure: impl FnMut(&PointBlock, &mut [f32; LANES]),
) {
    let (mut low, mut high) = ([0.0; LANES], [1.0; LANES]);
    let (mut first, mut second) = ([GOLDEN; LANES], [1.0 - GOLDEN; LANES]);
    let (mut at_first, mut at_second) =
        (segments.distances(&first, &mut measure), segments.distances(&second, &mut measure));
    // The ends are not measured.
    let (mut at_low, mut at_high) = ([f32::INFINITY; LANES], [f32::INFINITY; LANES]);
    for _ in 0..STEPS {
        // All is loaded first, and then chosen between: so it is done in lanes.
        let mut probe = [0.0; LANES];
        for i in 0..LANES {
            let (from, to, one, other) = (low[i], high[i], first[i], second[i]);
            let is_low = at_first[i] < at_second[i];
            let (from, to) = (if is_low { from } else { one }, if is_low { other } else { to });
            let width = (to - from) * GOLDEN;
            let (near, far) = (from + width, to - width);
            (low[i], high[i]) = (from, to);
            probe[i] = if is_low { near } else { far };
        }
        for i in 0..LANES {
            let (from, to, one, other) = (at_low[i], at_high[i], at_first[i], at_second[i]);
            at_low[i] = if one < other { from } else { one };
            at_high[i] = if one < other { other } else { to };
        }
        let new = segments.distances(&probe, &mut measure);
        for i in 0..LANES {
            let (one, other, probe) = (first[i], second[i], probe[i]);
            let (at_one, at_other, new) = (at_first[i], at_second[i], new[i]);
            let is_low = at_one < at_other;
            first[i] = if is_low { probe } else { other };
            second[i] = if is_low { one } else { probe };
            at_first[i] = if is_low { new } else { at_other };
            at_second[i] = if is_low { at_one } else { new };
        }
    }
    for i in 0..LANES {
        let (one, other) = (first[i], second[i]);
        let (at_one, at_other) = (at_first[i], at_second[i]);
        let is_first = at_one < at_other;
        let found = if is_first { at_one } else { at_other };
        out.at[i] = if is_first { one } else { other };
        out.distance[i] = found;
        // Beyond a place, a convex function lies above the line on which it came there. Of the two places and the two ends of what is
        // left, the one that was found has these beside it.
        let (before, at_before) = if is_first { (low[i], at_low[i]) } else { (one, at_one) };
        let (after, at_after) = if is_first { (other, at_other) } else { (high[i], at_high[i]) };
        let (to_before, to_after) = (out.at[i] - before, after - out.at[i]);
        let less_before = (at_after - found) * (to_before / to_after);
        let less_after = (at_before - found) * (to_after / to_before);
        // A distance changes by no more than the way.
        let way = segments.way.point(i);
        let length = way.dot(way).sqrt();
        let less_before = smaller(less_before, length * to_before);
        let less_after = smaller(less_after, length * to_after);
        let less = larger(less_before, less_after) + ROUNDED * length;
        out.least[i] = found - less;
    }
}
