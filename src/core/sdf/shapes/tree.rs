//! A tree of boxes around the parts of a solid: what is further than what is known is passed over in whole branches.

use super::larger;
use crate::sdf::{LANES, PointBlock};
use core::ops::Range;

/// A box along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    fn union(&self, other: &Self) -> Self {
        let pick = |a: [f32; 3], b: [f32; 3], of: fn(f32, f32) -> f32| {
            [0, 1, 2].map(|axis| of(a[axis], b[axis]))
        };
        Self {
            low: pick(self.low, other.low, f32::min),
            high: pick(self.high, other.high, f32::max),
        }
    }

    /// Twice the middle along an axis: not a number where it has no ends.
    fn middle(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }

    fn longest_axis(&self) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.high[axis] - self.low[axis]);
        if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        }
    }

    /// Square of the distance to the box \[m2\], made a little less, so that rounding never makes it more than that to what
    /// is in it.
    #[inline(always)]
    fn squared_gap(&self, [x, y, z]: [f32; 3]) -> f32 {
        let beside = |axis: usize, at: f32| {
            larger(larger(self.low[axis] - at, at - self.high[axis]), 0.0)
        };
        let [x, y, z] = [beside(0, x), beside(1, y), beside(2, z)];
        (x * x + y * y + z * z) * (1.0 - 1e-5)
    }

    #[inline(always)]
    fn squared_gaps(&self, points: &PointBlock) -> [f32; LANES] {
        let mut gaps = [0.0; LANES];
        for (lane, gap) in gaps.iter_mut().enumerate() {
            *gap = self.squared_gap([points.x[lane], points.y[lane], points.z[lane]]);
        }
        gaps
    }
}

/// A balanced binary tree in breadth-first order: the children of node `i` are `2 i + 1` and `2 i + 2`.
///
/// All leaves are at the same depth, each with an equal share of the parts.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    boxes: Box<[Bounds]>,
    first_leaf: usize,
    /// The parts' numbers, leaf by leaf.
    parts: Box<[u32]>,
}

impl BoxTree {
    /// A tree of parts in these boxes, at most so many in a leaf.
    pub fn new(bounds: &[Bounds], leaf: usize) -> Self {
        let leaves = bounds.len().div_ceil(leaf).next_power_of_two();
        let mut tree = Self {
            boxes: vec![Bounds::EMPTY; 2 * leaves - 1].into(),
            first_leaf: leaves - 1,
            parts: (0..bounds.len() as u32).collect(),
        };
        tree.build(bounds, 0, 0..bounds.len());
        tree
    }

    /// The parts' numbers, leaf by leaf: in this order those that are near to each other in space are so in the list.
    pub fn order(&self) -> &[u32] {
        &self.parts
    }

    /// A box around all parts.
    pub fn bounds(&self) -> Bounds {
        self.boxes[0]
    }

    /// Memory that the tree takes beside itself \[B\].
    pub fn memory_bytes(&self) -> usize {
        size_of_val::<[Bounds]>(&self.boxes) + size_of_val::<[u32]>(&self.parts)
    }

    /// Encloses some of the parts, and halves them along the longest side of their box.
    fn build(&mut self, bounds: &[Bounds], node: usize, range: Range<usize>) {
        let parts = &mut self.parts[range.clone()];
        let of = |part: &u32| bounds[*part as usize];
        let around = parts.iter().fold(Bounds::EMPTY, |sum, part| sum.union(&of(part)));
        self.boxes[node] = around;
        if node >= self.first_leaf || parts.is_empty() {
            return;
        }
        let axis = around.longest_axis();
        let [first, second] = halves(range);
        parts.select_nth_unstable_by(first.len(), |a, b| {
            of(a).middle(axis).total_cmp(&of(b).middle(axis)).then(a.cmp(b))
        });
        self.build(bounds, 2 * node + 1, first);
        self.build(bounds, 2 * node + 2, second);
    }

    /// Calls `look` with places in [`order`](Self::order), at least with those of the parts whose boxes are no further than
    /// `limit`: the square of the distance up to which parts are looked for \[m2\], which `look` may lower.
    ///
    /// In which order is not said: of parts that tie, take the one of the least number.
    pub fn search(&self, point: [f32; 3], limit: &mut f32, mut look: impl FnMut(usize, &mut f32)) {
        let gap = self.boxes[0].squared_gap(point);
        self.descend(0, 0..self.parts.len(), gap, point, limit, &mut look);
    }

    fn descend(
        &self,
        node: usize,
        range: Range<usize>,
        gap: f32,
        point: [f32; 3],
        limit: &mut f32,
        look: &mut impl FnMut(usize, &mut f32),
    ) {
        // Of a point that is no number, nothing is near.
        let is_near = gap <= *limit;
        if !is_near {
            return;
        }
        if node >= self.first_leaf {
            range.for_each(|place| look(place, limit));
            return;
        }
        let gaps = [1, 2].map(|child| self.boxes[2 * node + child].squared_gap(point));
        let ranges = halves(range);
        let nearer = usize::from(gaps[1] < gaps[0]);
        for child in [nearer, 1 - nearer] {
            let (below, range) = (2 * node + 1 + child, ranges[child].clone());
            self.descend(below, range, gaps[child], point, limit, look);
        }
    }

    /// [`search`](Self::search) for a block of points, each with its limit. `look` may be called for what no lane asks for.
    pub fn search_block(
        &self,
        points: &PointBlock,
        limits: &mut [f32; LANES],
        mut look: impl FnMut(usize, &mut [f32; LANES]),
    ) {
        let gaps = self.boxes[0].squared_gaps(points);
        self.descend_block(0, 0..self.parts.len(), &gaps, points, limits, &mut look);
    }

    fn descend_block(
        &self,
        node: usize,
        range: Range<usize>,
        gaps: &[f32; LANES],
        points: &PointBlock,
        limits: &mut [f32; LANES],
        look: &mut impl FnMut(usize, &mut [f32; LANES]),
    ) {
        if !any_near(gaps, limits) {
            return;
        }
        if node >= self.first_leaf {
            range.for_each(|place| look(place, limits));
            return;
        }
        let gaps = [1, 2].map(|child| self.boxes[2 * node + child].squared_gaps(points));
        let ranges = halves(range);
        let nearer = usize::from(sum(&gaps[1]) < sum(&gaps[0]));
        for child in [nearer, 1 - nearer] {
            let (below, range) = (2 * node + 1 + child, ranges[child].clone());
            self.descend_block(below, range, &gaps[child], points, limits, look);
        }
    }
}

/// The halves of what a node has; empty ones where there is nothing more to halve.
fn halves(range: Range<usize>) -> [Range<usize>; 2] {
    let middle = usize::midpoint(range.start, range.end);
    [range.start..middle, middle..range.end]
}

#[inline(always)]
fn any_near(gaps: &[f32; LANES], limits: &[f32; LANES]) -> bool {
    let mut near = 0;
    for lane in 0..LANES {
        near |= u32::from(gaps[lane] <= limits[lane]);
    }
    near != 0
}

/// Which of two is nearer to a whole block: a guess, that only decides what is looked at first.
#[inline(always)]
fn sum(gaps: &[f32; LANES]) -> f32 {
    gaps.iter().sum()
}
