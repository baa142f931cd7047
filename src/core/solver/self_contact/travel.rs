//! How far particles have moved relative to each other since pairs were found.
//!
//! One number for the whole cloth would be large wherever it swings or turns, though what is near each other hardly moves apart. So
//! a cloth has some regions, each with the box of its displacements. No two particles of two regions have moved relative to each
//! other by more than their boxes are wide together. Regions that were far from each other may move further than those that were
//! near before one of their particles can touch.

use bevy_math::Vec3;

use crate::solver::simd::block::{Block3, Blocks3, larger, smaller};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Regions at most.
const MOST: usize = 8;

/// A box of vectors \[m\].
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    /// Square of the largest difference between a vector in one box and one in another.
    #[inline(always)]
    fn difference(&self, other: &Self) -> f32 {
        let most = (self.high - other.low).max(other.high - self.low);
        most.dot(most)
    }

    /// Distance of two boxes, along the axis where they are furthest apart.
    fn gap(&self, other: &Self) -> f32 {
        (self.low - other.high).max(other.low - self.high).max_element()
    }
}

/// The regions of a cloth.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    layout: Layout,
    /// Rows of a region: of a sheet, or pages of a mesh.
    each: usize,
    /// Boxes of what was measured last, region by region.
    extents: Vec<Extent>,
    /// How far two regions may move relative to each other before particles that are no pair may touch, for each and those up to
    /// itself \[m\].
    allowed: Vec<f32>,
}

/// How far particles have moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Travelled {
    /// Relative to each other, of regions that were near each other when pairs were found \[m\].
    pub most: f32,
    /// Whether particles may touch that are no pair.
    pub is_too_far: bool,
}

impl Regions {
    pub fn new(layout: Layout) -> Self {
        let each = layout.rows.div_ceil(MOST);
        let count = layout.rows.div_ceil(each);
        Self {
            layout,
            each,
            extents: Vec::with_capacity(count),
            allowed: Vec::with_capacity(count * (count + 1) / 2),
        }
    }

    /// Begins to measure from these places, where particles are pairs that are up to `margin` further apart than they touch, `reach`
    /// apart at most.
    pub fn begin(&mut self, isa: Isa, at: &Soa, margin: f32, reach: f32) {
        isa.run(Measure { regions: self, at, from: None });
        self.allowed.clear();
        for (i, a) in self.extents.iter().enumerate() {
            for b in &self.extents[..=i] {
                self.allowed.push(larger(a.gap(b) - reach, 0.0) + margin);
            }
        }
    }

    /// Measures how far particles at `x + d` have moved since they were at `from`.
    pub fn measure(&mut self, isa: Isa, x: &Soa, d: &Soa, from: &Soa, margin: f32) -> Travelled {
        isa.run(Measure { regions: self, at: x, from: Some((d, from)) });
        let mut travelled = Travelled { most: 0.0, is_too_far: false };
        let mut allowed = self.allowed.iter();
        for (i, a) in self.extents.iter().enumerate() {
            for (b, &allowed) in self.extents[..=i].iter().zip(&mut allowed) {
                let moved = a.difference(b);
                travelled.is_too_far |= moved >= allowed * allowed;
                let near = if allowed <= margin { moved } else { 0.0 };
                travelled.most = larger(near, travelled.most);
            }
        }
        travelled.most = travelled.most.sqrt();
        travelled
    }
}

/// Makes the boxes of the regions: of positions, or of how far `at + d` is from where particles were.
struct Measure<'a> {
    regions: &'a mut Regions,
    at: &'a Soa,
    from: Option<(&'a Soa, &'a Soa)>,
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { regions, at, from } = self;
        let Regions { layout, each, extents, .. } = regions;
        let blocks = layout.blocks_across();
        extents.clear();
        for first in (0..layout.rows).step_by(*each) {
            let (mut low, mut high) =
                (Block3::splat(Vec3::INFINITY), Block3::splat(Vec3::NEG_INFINITY));
            for row in first..layout.rows.min(first + *each) {
                let slot = layout.slot(row, 0);
                let x = Blocks3::new(at, slot, blocks);
                #[expect(
                    clippy::manual_map,
                    reason = "a closure that is not inlined keeps the baseline's instructions"
                )]
                let moved = match from {
                    Some((d, from)) => {
                        Some((Blocks3::new(d, slot, blocks), Blocks3::new(from, slot, blocks)))
                    }
                    None => None,
                };
                for block in 0..blocks {
                    let inside = layout.inside(row, block * LANES);
                    let mut p = x.at(block);
                    if let Some((d, from)) = &moved {
                        let (d, from) = (d.at(block), from.at(block));
                        for i in 0..LANES {
                            p.set(i, p.at(i) + d.at(i) - from.at(i));
                        }
                    }
                    for i in 0..LANES {
                        let (p, a, b) = (p.at(i), low.at(i), high.at(i));
                        let least =
                            Vec3::new(smaller(p.x, a.x), smaller(p.y, a.y), smaller(p.z, a.z));
                        let most = Vec3::new(larger(p.x, b.x), larger(p.y, b.y), larger(p.z, b.z));
                        low.set(i, if i < inside { least } else { a });
                        high.set(i, if i < inside { most } else { b });
                    }
                }
            }
            extents.push(Extent {
                low: Vec3::new(low.x.smallest(), low.y.smallest(), low.z.smallest()),
                high: Vec3::new(high.x.largest(), high.y.largest(), high.z.largest()),
            });
        }
    }
}

/// Adds up positions and displacements.
pub(super) struct AddUp<'a> {
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub to: &'a mut Soa,
}

impl Kernel for AddUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { x, d, to } = self;
        for (to, x, d) in
            [(&mut to.x, &x.x, &d.x), (&mut to.y, &x.y, &d.y), (&mut to.z, &x.z, &d.z)]
        {
            for (to, (x, d)) in to.iter_mut().zip(x.iter().zip(&**d)) {
                *to = x + d;
            }
        }
    }
}
