//! The regions of a cloth, and the boxes of their particles: of where they are, and of how far they have moved.

use core::ops::Range;

use bevy_math::Vec3;

use crate::solver::simd::block::{Block3, larger, smaller};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// Regions of a cloth at most, along either of its sides.
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
    pub fn with(self, other: &Self) -> Self {
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

/// The regions of a cloth: parts of a sheet that are about as wide as high, or pages of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Regions {
    layout: Layout,
    /// Rows of a region, and blocks of a row.
    rows: usize,
    blocks: usize,
    /// Boxes of what was measured last, region by region.
    pub extents: Vec<Extent>,
    /// Boxes of how far particles had moved then since they were measured before; empty where that was not measured.
    pub steps: Vec<Extent>,
}

impl Regions {
    pub fn new(topology: &Topology) -> Self {
        let layout = topology.layout();
        let (rows, across) = (layout.rows.div_ceil(MOST), layout.blocks_across());
        // The blocks of a page are of no shape.
        let blocks = if topology.as_lattice().is_some() { across.div_ceil(MOST) } else { across };
        let count = layout.rows.div_ceil(rows) * across.div_ceil(blocks);
        let [extents, steps] = [Vec::with_capacity(count), Vec::with_capacity(count)];
        Self { layout, rows, blocks, extents, steps }
    }

    /// The rows and blocks of each region.
    #[inline(always)]
    fn parts(&self) -> impl Iterator<Item = [Range<usize>; 2]> + use<> {
        let Self { layout, rows, blocks, .. } = *self;
        let across = layout.blocks_across();
        (0..layout.rows).step_by(rows).flat_map(move |row| {
            (0..across).step_by(blocks).map(move |block| {
                [row..layout.rows.min(row + rows), block..across.min(block + blocks)]
            })
        })
    }

    /// The slots of a region's particles.
    pub fn slots(&self, region: usize) -> impl Iterator<Item = usize> + '_ {
        let layout = self.layout;
        let [rows, blocks] = self.parts().nth(region).unwrap_or_default();
        rows.flat_map(move |row| {
            let first = blocks.start * LANES;
            let columns = layout.inside(row, first).min((blocks.end - blocks.start) * LANES);
            let slot = layout.slot(row, first);
            slot..slot + columns
        })
    }

    /// Measures where particles are. Those of a cloth follow each other, from some place on.
    pub fn look(&mut self, isa: Isa, at: &Soa, first: usize) {
        isa.run(Look { regions: self, at, first });
    }

    /// Measures how far particles at `x + d`, and a shift further, have moved since they were at `from`, and since they were at `last`,
    /// from some place on. Then writes where they are to `last`. Without one, [`steps`](Self::steps) is left empty.
    pub fn measure(&mut self, isa: Isa, (x, d, shift): (&Soa, &Soa, Vec3), since: Since<'_>) {
        isa.run(Measure { regions: self, x, d, shift, since });
    }
}

/// Where particles were, those of a cloth from some place on.
pub(super) struct Since<'a> {
    pub from: &'a Soa,
    pub last: Option<&'a mut Soa>,
    pub first: usize,
}

/// A box of vectors in each lane.
pub(super) struct Wide {
    pub low: Block3,
    pub high: Block3,
}

impl Wide {
    #[inline(always)]
    pub fn nothing() -> Self {
        Self { low: Block3::splat(Vec3::INFINITY), high: Block3::splat(Vec3::NEG_INFINITY) }
    }

    /// Takes in the lanes that are inside a cloth.
    #[inline(always)]
    pub fn take(&mut self, p: &Block3, inside: usize) {
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
        let parts = self.regions.parts();
        let Regions { layout, extents, .. } = self.regions;
        extents.clear();
        for [rows, blocks] in parts {
            let mut all = Wide::nothing();
            for row in rows {
                let first = self.first + layout.slot(row, 0);
                for block in blocks.clone() {
                    let at = Block3::load(self.at, first + block * LANES);
                    all.take(&at, layout.inside(row, block * LANES));
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
        let Self { regions, x, d, shift, since: Since { from, mut last, first: start } } = self;
        let parts = regions.parts();
        let Regions { layout, extents, steps, .. } = regions;
        extents.clear();
        steps.clear();
        for [rows, blocks] in parts {
            let (mut all, mut step) = (Wide::nothing(), Wide::nothing());
            for row in rows {
                for block in blocks.clone() {
                    let slot = layout.slot(row, 0) + block * LANES;
                    let inside = layout.inside(row, block * LANES);
                    let (x, d) = (Block3::load(x, slot), Block3::load(d, slot));
                    let from = Block3::load(from, start + slot);
                    let [mut now, mut moved] = [Block3::ZERO; 2];
                    for i in 0..LANES {
                        let p = x.at(i) + d.at(i) + shift;
                        now.set(i, p);
                        moved.set(i, p - from.at(i));
                    }
                    all.take(&moved, inside);
                    if let Some(last) = &mut last {
                        let before = Block3::load(&**last, start + slot);
                        let mut stepped = Block3::ZERO;
                        for i in 0..LANES {
                            stepped.set(i, now.at(i) - before.at(i));
                        }
                        now.store(&mut **last, start + slot);
                        step.take(&stepped, inside);
                    }
                }
            }
            extents.push(all.extent());
            if last.is_some() {
                steps.push(step.extent());
            }
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_math::Vec2;

    use super::*;
    use crate::solver::settings::MassLumping;
    use crate::solver::topology::graph::Graph;
    use crate::solver::topology::lattice::Lattice;

    #[test]
    fn each_particle_is_in_one_region_whose_box_holds_it_alone() {
        for (rows, columns) in [(2, 2), (9, 17), (64, 64), (5, 200)] {
            let sheet = Lattice::sheet(Vec2::ONE, rows, columns, MassLumping::Lumped).unwrap();
            let cells = (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| r * columns + c));
            let cells =
                cells.map(|a| [a, a + columns, a + columns + 1].map(|corner| corner as u32));
            let triangles: Vec<_> =
                cells.flat_map(|[a, b, c]| [[a, b, c], [a, c, a + 1]]).collect();
            let mesh = Graph::new(sheet.rest_positions(), &triangles, MassLumping::Lumped).unwrap();
            for topology in [Topology::from(Arc::new(sheet)), Topology::from(Arc::new(mesh))] {
                let mut regions = Regions::new(&topology);
                let mut at = Soa::zeros(topology.layout().len());
                for (particle, &rest) in topology.rest_positions().iter().enumerate() {
                    at.set(topology.slot(particle), rest);
                }
                regions.look(Isa::detect(), &at, 0);
                let mut slots = Vec::new();
                for (region, extent) in regions.extents.iter().enumerate() {
                    let mut own = Extent::NOTHING;
                    for slot in regions.slots(region) {
                        own = own.with(&Extent { low: at.get(slot), high: at.get(slot) });
                        slots.push(slot);
                    }
                    assert_eq!([own.low, own.high], [extent.low, extent.high], "region {region}");
                }
                slots.sort_unstable();
                let mut all: Vec<_> = topology.layout().slots().collect();
                all.sort_unstable();
                assert_eq!(slots, all, "{rows} x {columns}");
                assert!(regions.extents.len() <= MOST * MOST);
            }
        }
    }
}
