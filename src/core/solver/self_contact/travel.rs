//! How far particles have moved relative to each other.

use bevy_math::Vec3;

use crate::solver::simd::block::{Block3, Blocks3, larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Merge, cut_between_rows};
use crate::solver::simd::soa::Soa;

/// Finds the box of all displacements from where pairs were found. No two particles have moved relative to each other by more than
/// its diagonal, whatever moves the cloth as a whole.
pub(super) struct Travel<'a> {
    pub band: Band,
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub from: &'a Soa,
}

/// A box of displacements \[m\].
pub(super) struct Extent {
    low: Vec3,
    high: Vec3,
}

impl Extent {
    /// Length of its diagonal \[m\].
    pub fn length(&self) -> f32 {
        (self.high - self.low).length()
    }
}

impl Merge for Extent {
    fn merge(self, below: Self) -> Self {
        Self { low: self.low.min(below.low), high: self.high.max(below.high) }
    }
}

impl Kernel for Travel<'_> {
    type Output = Extent;

    #[inline(always)]
    fn run(self) -> Extent {
        let Band { layout, rows, .. } = self.band;
        let blocks = layout.blocks_across();
        let mut low = Block3::splat(Vec3::INFINITY);
        let mut high = Block3::splat(Vec3::NEG_INFINITY);
        for row in rows {
            let slot = layout.slot(row, 0);
            let x = Blocks3::new(self.x, slot, blocks);
            let d = Blocks3::new(self.d, slot, blocks);
            let from = Blocks3::new(self.from, slot, blocks);
            for block in 0..blocks {
                let inside = layout.inside(row, block * LANES);
                let (x, d, from) = (x.at(block), d.at(block), from.at(block));
                for i in 0..LANES {
                    let moved = x.at(i) + d.at(i) - from.at(i);
                    let (a, b) = (low.at(i), high.at(i));
                    let least =
                        Vec3::new(smaller(moved.x, a.x), smaller(moved.y, a.y), smaller(moved.z, a.z));
                    let most =
                        Vec3::new(larger(moved.x, b.x), larger(moved.y, b.y), larger(moved.z, b.z));
                    low.set(i, if i < inside { least } else { a });
                    high.set(i, if i < inside { most } else { b });
                }
            }
        }
        Extent {
            low: Vec3::new(low.x.smallest(), low.y.smallest(), low.z.smallest()),
            high: Vec3::new(high.x.largest(), high.y.largest(), high.z.largest()),
        }
    }
}

cut_between_rows!(Travel);
