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

/// Regions of a cloth at most.
const MOST: usize = 8;

/// A box of vectors \[m\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub low: Vec3,
    pub high: Vec3,
}

impl Extent {
    /// The box of nothing but zero.
    pub const ZERO: Self = Self { low: Vec3::ZERO, high: Vec3::ZERO };

    /// No box.
    pub const NOTHING: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// The box around both.
    pub fn with(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// All of it, with this much around it.
    pub fn grown(&self, by: f32) -> Self {
        Self { low: self.low - by, high: self.high + by }
    }

    #[inline(always)]
    pub fn contains(&self, p: Vec3) -> bool {
        self.low.cmple(p).all() && p.cmple(self.high).all()
    }

    /// Square of the largest difference between a vector in one box and one in another.
    #[inline(always)]
    pub fn difference(&self, other: &Self) -> f32 {
        let most = (self.high - other.low).max(other.high - self.low);
        most.dot(most)
    }

    /// Distance of two boxes, along the axis where they are furthest apart.
    pub fn gap(&self, other: &Self) -> f32 {
        (self.low - other.high).max(other.low - self.high).max_element()
    }

    /// All of it, moved.
    pub fn shifted(&self, shift: Vec3) -> Self {
        Self { low: self.low + shift, high: self.high + shift }
    }
}

/// The regions of a cloth.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    layout: Layout,
    /// Rows of a region: of a sheet, or pages of a mesh.
    each: usize,
    /// Boxes of what was measured last, region by region.
    pub extents: Vec<Extent>,
}

impl Regions {
    pub fn new(layout: Layout) -> Self {
        let each = layout.rows.div_ceil(MOST);
        let count = layout.rows.div_ceil(each);
        Self { layout, each, extents: Vec::with_capacity(count) }
    }

    /// The slots of a region's particles.
    pub fn slots(&self, region: usize) -> impl Iterator<Item = usize> + '_ {
        let layout = self.layout;
        let first = region * self.each;
        (first..layout.rows.min(first + self.each)).flat_map(move |row| {
            let columns = layout.inside(row, 0).min(layout.columns);
            let first = layout.slot(row, 0);
            first..first + columns
        })
    }

    /// Measures where particles are. Those of a cloth follow each other, from some place on.
    pub fn look(&mut self, isa: Isa, at: &Soa, first: usize) {
        isa.run(Measure { regions: self, at, first, from: None });
    }

    /// Measures how far particles at `x + d` have moved since they were at `from`, from some place on.
    pub fn measure(&mut self, isa: Isa, x: &Soa, d: &Soa, from: &Soa, first: usize) {
        isa.run(Measure { regions: self, at: x, first: 0, from: Some((d, from, first)) });
    }
}

/// How far the regions of a cloth may move.
#[derive(Clone, Debug)]
pub(super) struct Travel {
    regions: Regions,
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

impl Travelled {
    pub const NOTHING: Self = Self { most: 0.0, is_too_far: false };

    /// Takes in two regions that have moved relative to each other by the square root of `moved`, and were allowed to move so far.
    #[inline(always)]
    pub fn add(&mut self, moved: f32, allowed: f32, margin: f32) {
        self.is_too_far |= moved >= allowed * allowed;
        let near = if allowed <= margin { moved } else { 0.0 };
        self.most = larger(near, self.most);
    }

    /// All regions have been taken in.
    pub fn finished(self) -> Self {
        Self { most: self.most.sqrt(), ..self }
    }
}

/// How far two regions may move relative to each other, where pairs are up to `margin` further apart than they touch, `reach` apart
/// at most \[m\].
pub(super) fn allowed(a: &Extent, b: &Extent, margin: f32, reach: f32) -> f32 {
    larger(a.gap(b) - reach, 0.0) + margin
}

impl Travel {
    pub fn new(layout: Layout) -> Self {
        let regions = Regions::new(layout);
        let count = regions.extents.capacity();
        Self { regions, allowed: Vec::with_capacity(count * (count + 1) / 2) }
    }

    /// Begins to measure from these places, where particles are pairs that are up to `margin` further apart than they touch, `reach`
    /// apart at most.
    pub fn begin(&mut self, isa: Isa, at: &Soa, margin: f32, reach: f32) {
        self.regions.look(isa, at, 0);
        let extents = &self.regions.extents;
        self.allowed.clear();
        for (i, a) in extents.iter().enumerate() {
            self.allowed.extend(extents[..=i].iter().map(|b| allowed(a, b, margin, reach)));
        }
    }

    /// Measures how far particles at `x + d` have moved since they were at `from`.
    pub fn measure(&mut self, isa: Isa, x: &Soa, d: &Soa, from: &Soa, margin: f32) -> Travelled {
        self.regions.measure(isa, x, d, from, 0);
        let mut travelled = Travelled::NOTHING;
        let extents = &self.regions.extents;
        let mut allowed = self.allowed.iter();
        for (i, a) in extents.iter().enumerate() {
            for (b, &allowed) in extents[..=i].iter().zip(&mut allowed) {
                travelled.add(a.difference(b), allowed, margin);
            }
        }
        travelled.finished()
    }
}

/// Makes the boxes of the regions: of positions, or of how far `at + d` is from where particles were.
struct Measure<'a> {
    regions: &'a mut Regions,
    at: &'a Soa,
    /// Place of the first particle in `at`.
    first: usize,
    /// Displacements, where particles were, and the place of the first there.
    from: Option<(&'a Soa, &'a Soa, usize)>,
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { regions, at, first: first_at, from } = self;
        let Regions { layout, each, extents } = regions;
        let blocks = layout.blocks_across();
        extents.clear();
        for first in (0..layout.rows).step_by(*each) {
            let (mut low, mut high) =
                (Block3::splat(Vec3::INFINITY), Block3::splat(Vec3::NEG_INFINITY));
            for row in first..layout.rows.min(first + *each) {
                let slot = layout.slot(row, 0);
                let x = Blocks3::new(at, first_at + slot, blocks);
                #[expect(
                    clippy::manual_map,
                    reason = "a closure that is not inlined keeps the baseline's instructions"
                )]
                let moved = match from {
                    Some((d, from, first)) => Some((
                        Blocks3::new(d, slot, blocks),
                        Blocks3::new(from, first + slot, blocks),
                    )),
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

/// Adds up positions and displacements, and a shift; what comes out begins at some place.
pub(super) struct AddUp<'a> {
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub shift: Vec3,
    pub to: &'a mut Soa,
    pub first: usize,
}

impl Kernel for AddUp<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { x, d, shift, to, first } = self;
        for (to, x, d, shift) in [
            (&mut to.x, &x.x, &d.x, shift.x),
            (&mut to.y, &x.y, &d.y, shift.y),
            (&mut to.z, &x.z, &d.z, shift.z),
        ] {
            for (to, (x, d)) in to[first..].iter_mut().zip(x.iter().zip(&**d)) {
                *to = x + d + shift;
            }
        }
    }
}
