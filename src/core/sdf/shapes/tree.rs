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
        let beside =
            |axis: usize, at: f32| larger(larger(self.low[axis] - at, at - self.high[axis]), 0.0);
        let [x, y, z] = [beside(0, x), beside(1, y), beside(2, z)];
        (x * x + y * y + z * z) * (1.0 - 1e-5)
    }

    /// Whether any of the points is near enough, each within its own limit.
    #[inline(always)]
    fn is_near_any(&self, points: &PointBlock, limits: &[f32; LANES]) -> bool {
        let mut near = 0;
        for (lane, limit) in limits.iter().enumerate() {
            let gap = self.squared_gap([points.x[lane], points.y[lane], points.z[lane]]);
            near |= i32::from(gap <= *limit);
        }
        near != 0
    }
}

/// A balanced binary tree in breadth-first order: the children of node `i` are `2 i + 1` and `2 i + 2`.
///
/// All leaves are at the same depth, each with an equal share of the parts.
#[derive(Clone, Debug)]
pub(super) struct BoxTree {
    boxes: Box<[Bounds]>,
    first_leaf: usize,
    /// Where the parts of each leaf begin, and where those of the last end.
    starts: Box<[u32]>,
}

impl BoxTree {
    /// A tree of parts in these boxes, at most so many in a leaf; and the parts' numbers, leaf by leaf: the order that the tree
    /// takes them to be kept in.
    pub fn new(bounds: &[Bounds], leaf: usize) -> (Self, Vec<u32>) {
        let leaves = bounds.len().div_ceil(leaf).next_power_of_two();
        let mut tree = Self {
            boxes: vec![Bounds::EMPTY; 2 * leaves - 1].into(),
            first_leaf: leaves - 1,
            starts: vec![bounds.len() as u32; leaves + 1].into(),
        };
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        tree.build(bounds, &mut order, 0, 0..bounds.len());
        (tree, order)
    }

    /// A box around all parts.
    pub fn bounds(&self) -> Bounds {
        self.boxes[0]
    }

    /// Memory that the tree takes beside itself \[B\].
    pub fn memory_bytes(&self) -> usize {
        size_of_val::<[Bounds]>(&self.boxes) + size_of_val::<[u32]>(&self.starts)
    }

    /// Encloses some of the parts, and halves them along the longest side of their box.
    fn build(&mut self, bounds: &[Bounds], order: &mut [u32], node: usize, range: Range<usize>) {
        let parts = &mut order[range.clone()];
        let of = |part: &u32| bounds[*part as usize];
        let around = parts.iter().fold(Bounds::EMPTY, |sum, part| sum.union(&of(part)));
        self.boxes[node] = around;
        if let Some(leaf) = node.checked_sub(self.first_leaf) {
            self.starts[leaf] = range.start as u32;
            return;
        }
        let middle = usize::midpoint(range.start, range.end);
        if !parts.is_empty() {
            let axis = around.longest_axis();
            parts.select_nth_unstable_by(middle - range.start, |a, b| {
                of(a).middle(axis).total_cmp(&of(b).middle(axis)).then(a.cmp(b))
            });
        }
        self.build(bounds, order, 2 * node + 1, range.start..middle);
        self.build(bounds, order, 2 * node + 2, middle..range.end);
    }

    /// The places of a leaf's parts.
    #[inline(always)]
    fn leaf(&self, leaf: usize) -> Range<usize> {
        self.starts[leaf] as usize..self.starts[leaf + 1] as usize
    }
}

/// Most nodes that wait: one for each level, of which there are fewer than bits in a part's number.
const DEEPEST: usize = 33;

/// A way through a tree, which goes to what is near first.
///
/// It comes to all parts whose boxes are no further than a limit, and to others as well. In which order is not
/// said: of parts that tie, take the one of the first place.
pub(super) struct Walk {
    waiting: [u32; DEEPEST],
    count: usize,
    /// The walk goes first to the nodes that are nearest to this place \[m\].
    towards: [f32; 3],
}

impl Walk {
    /// A way from the root, for one point.
    #[inline(always)]
    pub fn to_point(point: [f32; 3]) -> Self {
        Self { waiting: [0; DEEPEST], count: 1, towards: point }
    }

    /// A way from the root, for a block of points.
    #[inline(always)]
    pub fn to_block(points: &PointBlock) -> Self {
        let middle = |along: &[f32; LANES]| {
            let mut sum = 0.0;
            for at in along {
                sum += at;
            }
            sum * (1.0 / LANES as f32)
        };
        Self::to_point([middle(&points.x), middle(&points.y), middle(&points.z)])
    }

    /// Places of parts within a limit, the square of a distance \[m2\]; `None` at the end.
    #[inline(always)]
    pub fn next(&mut self, tree: &BoxTree, limit: f32) -> Option<Range<usize>> {
        while let Some(node) = self.pop() {
            // Nothing is near to a point that is no number.
            let is_near = tree.boxes[node].squared_gap(self.towards) <= limit;
            if is_near && let Some(leaf) = self.enter(tree, node) {
                return Some(tree.leaf(leaf));
            }
        }
        None
    }

    /// [`next`](Self::next) for a block of points, each with its limit.
    #[inline(always)]
    pub fn next_of_block(
        &mut self,
        tree: &BoxTree,
        points: &PointBlock,
        limits: &[f32; LANES],
    ) -> Option<Range<usize>> {
        while let Some(node) = self.pop() {
            let is_near = tree.boxes[node].is_near_any(points, limits);
            if is_near && let Some(leaf) = self.enter(tree, node) {
                return Some(tree.leaf(leaf));
            }
        }
        None
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<usize> {
        self.count = self.count.checked_sub(1)?;
        Some(self.waiting[self.count] as usize)
    }

    /// A leaf's number; below any other node, its children wait.
    #[inline(always)]
    fn enter(&mut self, tree: &BoxTree, node: usize) -> Option<usize> {
        if node >= tree.first_leaf {
            return Some(node - tree.first_leaf);
        }
        let [first, second] = [2 * node + 1, 2 * node + 2];
        let gap = |node: usize| tree.boxes[node].squared_gap(self.towards);
        let (near, far) = if gap(second) < gap(first) { (second, first) } else { (first, second) };
        self.waiting[self.count] = far as u32;
        self.waiting[self.count + 1] = near as u32;
        self.count += 2;
        None
    }
}
