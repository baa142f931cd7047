//! A tree of discs around the triangles, and the proof by it that no triangle is nearer.
//!
//! A flat patch seen from afar nearly ties with its neighbours, and boxes along the axes, thick wherever the
//! patch is slanted, cannot tell them apart. A disc along the patch's mean normal is as thin as the patch.

use super::{Nearest, band::exact_within, layout::Layout, triangle::Triangle};
use bevy_math::DVec3;

/// Most triangles in a leaf.
const LEAF: usize = 4;

/// A binary tree in breadth-first order: the children of disc `i` are `2 i + 1` and `2 i + 2`.
///
/// All leaves are at the same depth, each with an equal share of the triangles.
pub(super) struct DiscTree {
    /// The triangles, ordered so that each leaf's are neighbours.
    pub(super) triangles: Vec<Triangle>,
    discs: Vec<Disc>,
    first_leaf: usize,
}

/// A flat round cylinder.
#[derive(Clone, Copy)]
struct Disc {
    centre: DVec3,
    axis: DVec3,
    radius: f64,
    half_thickness: f64,
}

impl Disc {
    const EMPTY: Self =
        Self { centre: DVec3::ZERO, axis: DVec3::Y, radius: 0.0, half_thickness: 0.0 };

    /// A disc around the triangles, which lie about `middle`.
    fn around(triangles: &[Triangle], middle: DVec3) -> Self {
        let sum: DVec3 = triangles.iter().map(|triangle| triangle.normal).sum();
        let axis = sum.try_normalize().unwrap_or(DVec3::Y);
        let (mut low, mut high, mut radius_squared) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for corner in triangles.iter().flat_map(Triangle::corners) {
            let from_middle = corner - middle;
            let height = axis.dot(from_middle);
            low = low.min(height);
            high = high.max(height);
            radius_squared = radius_squared.max((from_middle - axis * height).length_squared());
        }
        let centre = middle + axis * (0.5 * (low + high));
        Self { centre, axis, radius: radius_squared.sqrt(), half_thickness: 0.5 * (high - low) }
    }

    /// Squared distance that no point of the disc is nearer than \[m2\].
    #[inline(always)]
    fn squared_distance(&self, point: DVec3) -> f64 {
        let from_centre = point - self.centre;
        let height = self.axis.dot(from_centre);
        let above = (height.abs() - self.half_thickness).max(0.0);
        let across = (from_centre.length_squared() - height * height).max(0.0).sqrt();
        let beside = (across - self.radius).max(0.0);
        above * above + beside * beside
    }
}

impl DiscTree {
    pub(super) fn new(triangles: Vec<Triangle>) -> Self {
        let leaf_count = triangles.len().div_ceil(LEAF).next_power_of_two();
        let mut tree = Self {
            triangles,
            discs: vec![Disc::EMPTY; 2 * leaf_count - 1],
            first_leaf: leaf_count - 1,
        };
        tree.build(0, 0, tree.triangles.len());
        tree
    }

    /// Encloses the triangles from `start` to `end`, and halves them along the longest side of their box.
    fn build(&mut self, node: usize, start: usize, end: usize) {
        if start == end {
            return;
        }
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for triangle in &self.triangles[start..end] {
            let bounds = triangle.bounds();
            min = min.min(bounds.0);
            max = max.max(bounds.1);
        }
        self.discs[node] = Disc::around(&self.triangles[start..end], 0.5 * (min + max));
        if node >= self.first_leaf {
            return;
        }
        let size = max - min;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let centre = |triangle: &Triangle| {
            let (min, max) = triangle.bounds();
            min[axis] + max[axis]
        };
        let middle = usize::midpoint(start, end);
        self.triangles[start..end].select_nth_unstable_by(middle - start, |a, b| {
            centre(a).total_cmp(&centre(b)).then(a.source.cmp(&b.source))
        });
        self.build(2 * node + 1, start, middle);
        self.build(2 * node + 2, middle, end);
    }

    /// Makes sure, at every node beyond the band, that its triangle is the nearest of all.
    pub(super) fn prove(
        &self,
        layout: &Layout,
        nearest: &mut Nearest,
        progress: &mut dyn FnMut(f32),
    ) {
        let [width, height, depth] = layout.size();
        let exact = exact_within(layout);
        let mut pending = Vec::new();
        for z in 0..depth {
            progress(z as f32 / depth as f32);
            for y in 0..height {
                for x in 0..width {
                    let node = layout.index(x, y, z);
                    if nearest.squared[node] > exact {
                        let known = (nearest.squared[node], nearest.triangle[node]);
                        let point = layout.node(x, y, z);
                        (nearest.squared[node], nearest.triangle[node]) =
                            self.nearer(point, known, &mut pending);
                    }
                }
            }
        }
    }

    /// The nearest triangle and its squared distance \[m2\], given one that is known.
    fn nearer(&self, point: DVec3, known: (f64, u32), pending: &mut Vec<(f64, u32)>) -> (f64, u32) {
        let (mut squared, mut found) = known;
        pending.clear();
        pending.push((self.discs[0].squared_distance(point), 0));
        while let Some((lower, node)) = pending.pop() {
            if lower >= squared {
                continue;
            }
            let node = node as usize;
            if node >= self.first_leaf {
                for number in self.leaf(node) {
                    let candidate = self.triangles[number].squared_distance(point);
                    if candidate < squared {
                        (squared, found) = (candidate, number as u32);
                    }
                }
                continue;
            }
            for child in [2 * node + 1, 2 * node + 2] {
                let lower = self.discs[child].squared_distance(point);
                if lower < squared {
                    pending.push((lower, child as u32));
                }
            }
        }
        (squared, found)
    }

    /// The triangles of a leaf: the same halving as in [`build`](Self::build), from the root down.
    fn leaf(&self, node: usize) -> core::ops::Range<usize> {
        let leaf_count = self.first_leaf + 1;
        let leaf = node - self.first_leaf;
        let (mut start, mut end) = (0, self.triangles.len());
        let mut bit = leaf_count >> 1;
        while bit > 0 {
            let middle = usize::midpoint(start, end);
            if leaf & bit == 0 {
                end = middle;
            } else {
                start = middle;
            }
            bit >>= 1;
        }
        start..end
    }
}
