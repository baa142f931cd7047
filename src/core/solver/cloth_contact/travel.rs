//! How far particles have moved relative to each other since pairs were found.
//!
//! One number for the whole cloth would be large wherever it swings or turns, though what is near each other hardly moves apart. So
//! a cloth has some regions, each with the box of its displacements. No two particles of two regions have moved relative to each
//! other by more than their boxes are wide together. Regions that were far from each other may move further than those that were
//! near before one of their particles can touch.
//!
//! The same is measured from substep to substep. Summed up, it is the length of a path, by which pairs sleep that were not near
//! enough when they were looked at last.

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
}

/// The regions of a cloth.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    layout: Layout,
    /// Rows of a region: of a sheet, or pages of a mesh.
    each: usize,
    /// Boxes of what was measured last, region by region.
    pub extents: Vec<Extent>,
    /// Boxes of how far particles had moved then since they were measured before.
    pub steps: Vec<Extent>,
}

impl Regions {
    pub fn new(layout: Layout) -> Self {
        let each = layout.rows.div_ceil(MOST);
        let count = layout.rows.div_ceil(each);
        let [extents, steps] = [Vec::with_capacity(count), Vec::with_capacity(count)];
        Self { layout, each, extents, steps }
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
        isa.run(Look { regions: self, at, first });
    }

    /// Measures how far particles at `x + d`, and a shift further, have moved since they were at `from`, and since they were at `last`,
    /// from some place on. Then writes where they are to `last`.
    pub fn measure(&mut self, isa: Isa, (x, d, shift): (&Soa, &Soa, Vec3), since: Since<'_>) {
        isa.run(Measure { regions: self, x, d, shift, since });
    }
}

/// Where particles were, those of a cloth from some place on.
pub(super) struct Since<'a> {
    pub from: &'a Soa,
    pub last: &'a mut Soa,
    pub first: usize,
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Travelled {
    /// Relative to each other, of regions that were near each other when pairs were found \[m\].
    pub most: f32,
    /// The same since they were measured before \[m\].
    pub step: f32,
    /// Whether particles may touch that are no pair.
    pub is_too_far: bool,
}

impl Travelled {
    pub const NOTHING: Self = Self { most: 0.0, step: 0.0, is_too_far: false };

    /// Takes in two regions that have moved relative to each other by the square root of `moved`, in the last step by that of `step`, and
    /// were allowed to move so far.
    #[inline(always)]
    pub fn add(&mut self, [moved, step]: [f32; 2], allowed: f32, margin: f32) {
        self.is_too_far |= moved >= allowed * allowed;
        let are_near = allowed <= margin;
        self.most = larger(if are_near { moved } else { 0.0 }, self.most);
        self.step = larger(if are_near { step } else { 0.0 }, self.step);
    }

    /// All regions have been taken in.
    pub fn finished(self) -> Self {
        Self { most: self.most.sqrt(), step: self.step.sqrt(), ..self }
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

    /// Measures how far particles at `x + d` have moved.
    pub fn measure(
        &mut self,
        isa: Isa,
        (x, d): (&Soa, &Soa),
        since: Since<'_>,
        margin: f32,
    ) -> Travelled {
        self.regions.measure(isa, (x, d, Vec3::ZERO), since);
        let mut travelled = Travelled::NOTHING;
        let Regions { extents, steps, .. } = &self.regions;
        let mut allowed = self.allowed.iter();
        for (i, a) in extents.iter().enumerate() {
            for (j, &allowed) in (0..=i).zip(&mut allowed) {
                let moved = [a.difference(&extents[j]), steps[i].difference(&steps[j])];
                travelled.add(moved, allowed, margin);
            }
        }
        travelled.finished()
    }
}

/// A box of vectors in lanes.
struct Wide {
    low: Block3,
    high: Block3,
}

impl Wide {
    #[inline(always)]
    fn nothing() -> Self {
        Self { low: Block3::splat(Vec3::INFINITY), high: Block3::splat(Vec3::NEG_INFINITY) }
    }

    /// Takes in the lanes that are inside a cloth.
    #[inline(always)]
    fn take(&mut self, p: &Block3, inside: usize) {
        for i in 0..LANES {
            let (p, a, b) = (p.at(i), self.low.at(i), self.high.at(i));
            let least = Vec3::new(smaller(p.x, a.x), smaller(p.y, a.y), smaller(p.z, a.z));
            let most = Vec3::new(larger(p.x, b.x), larger(p.y, b.y), larger(p.z, b.z));
            self.low.set(i, if i < inside { least } else { a });
            self.high.set(i, if i < inside { most } else { b });
        }
    }

    #[inline(always)]
    fn extent(&self) -> Extent {
        let Self { low, high } = self;
        Extent {
            low: Vec3::new(low.x.smallest(), low.y.smallest(), low.z.smallest()),
            high: Vec3::new(high.x.largest(), high.y.largest(), high.z.largest()),
        }
    }
}

/// Makes the boxes of the regions, of positions.
struct Look<'a> {
    regions: &'a mut Regions,
    at: &'a Soa,
    /// Place of the first particle in `at`.
    first: usize,
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Regions { layout, each, extents, .. } = self.regions;
        let blocks = layout.blocks_across();
        extents.clear();
        for first in (0..layout.rows).step_by(*each) {
            let mut all = Wide::nothing();
            for row in first..layout.rows.min(first + *each) {
                let at = Blocks3::new(self.at, self.first + layout.slot(row, 0), blocks);
                for block in 0..blocks {
                    all.take(&at.at(block), layout.inside(row, block * LANES));
                }
            }
            extents.push(all.extent());
        }
    }
}

/// Makes the boxes of how far the particles of the regions have moved.
struct Measure<'a> {
    regions: &'a mut Regions,
    x: &'a Soa,
    d: &'a Soa,
    shift: Vec3,
    since: Since<'a>,
}

impl Kernel for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { regions, x, d, shift, since: Since { from, last, first: start } } = self;
        let Regions { layout, each, extents, steps } = regions;
        let blocks = layout.blocks_across();
        extents.clear();
        steps.clear();
        for first in (0..layout.rows).step_by(*each) {
            let (mut all, mut step) = (Wide::nothing(), Wide::nothing());
            for row in first..layout.rows.min(first + *each) {
                let slot = layout.slot(row, 0);
                let (x, d) = (Blocks3::new(x, slot, blocks), Blocks3::new(d, slot, blocks));
                let from = Blocks3::new(from, start + slot, blocks);
                for block in 0..blocks {
                    let inside = layout.inside(row, block * LANES);
                    let before = Block3::load(last, start + slot + block * LANES);
                    let (x, d, from) = (x.at(block), d.at(block), from.at(block));
                    let [mut now, mut moved, mut stepped] = [Block3::ZERO; 3];
                    for i in 0..LANES {
                        let p = x.at(i) + d.at(i) + shift;
                        now.set(i, p);
                        moved.set(i, p - from.at(i));
                        stepped.set(i, p - before.at(i));
                    }
                    now.store(last, start + slot + block * LANES);
                    all.take(&moved, inside);
                    step.take(&stepped, inside);
                }
            }
            extents.push(all.extent());
            steps.push(step.extent());
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
