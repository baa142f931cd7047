//! The patches of a sheet: squares of its particles, row by row.

use bevy_math::Vec3;

use crate::solver::cloth_contact::patch::{PARTICLES, Patch, are_flat};
use crate::solver::cloth_contact::regions::{Extent, Wide};
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Rows and columns of a patch. Larger ones are bent more often, smaller ones have more to look at.
const SIDE: usize = 4;
/// Patches in a block.
const IN_BLOCK: usize = LANES / SIDE;

/// The patches of a sheet.
#[derive(Clone, Debug)]
pub(super) struct SheetPatches {
    layout: Layout,
    across: usize,
}

impl SheetPatches {
    pub fn new(layout: Layout) -> Self {
        Self { layout, across: layout.blocks_across() * IN_BLOCK }
    }

    /// Number of patches, with those beside the sheet that fill up blocks.
    pub fn count(&self) -> usize {
        self.layout.rows.div_ceil(SIDE) * self.across
    }

    /// The slot of a particle: of the patch that is `place` over [`PARTICLES`], the one that is the rest. `None` beside the sheet.
    pub fn slot(&self, place: usize) -> Option<usize> {
        let (patch, particle) = (place / PARTICLES, place % PARTICLES);
        let row = patch / self.across * SIDE + particle / SIDE;
        let column = patch % self.across * SIDE + particle % SIDE;
        let is_there = row < self.layout.rows && column < self.layout.columns;
        is_there.then(|| self.layout.slot(row, column))
    }

    /// Looks at particles that are at these places, and writes them patch by patch.
    pub fn look(&self, isa: Isa, at: &Soa, x: &mut Soa, all: &mut Vec<Patch>) {
        isa.run(LookAtPatches { layout: &self.layout, at, all });
        self.put(at, x);
    }

    /// Whether two patches are side by side, or corner to corner, and all patches around their seam lie in one narrow cone.
    pub fn are_flat_neighbours(&self, all: &[Patch], pair: [u32; 2]) -> bool {
        let [a, b] = pair.map(|patch| patch as usize);
        let across = self.across;
        let ([row_a, column_a], [row_b, column_b]) =
            ([a / across, a % across], [b / across, b % across]);
        if row_a.abs_diff(row_b) > 1 || column_a.abs_diff(column_b) > 1 {
            return false;
        }
        let around = [a, b, row_a * across + column_b, row_b * across + column_a];
        are_flat(all, around.into_iter())
    }

    /// Writes where particles are patch by patch.
    fn put(&self, at: &Soa, x: &mut Soa) {
        let Self { layout, across } = *self;
        for (to, from) in [(&mut x.x, &at.x), (&mut x.y, &at.y), (&mut x.z, &at.z)] {
            for row in 0..layout.rows {
                let from = &from[layout.slot(row, 0)..][..layout.columns];
                let (whole, rest) = from.as_chunks::<SIDE>();
                let places = to.as_chunks_mut::<SIDE>().0;
                let places = &mut places[row / SIDE * across * SIDE + row % SIDE..];
                let mut places = places.iter_mut().step_by(SIDE);
                for (to, from) in places.by_ref().zip(whole) {
                    *to = *from;
                }
                if let Some(to) = places.next() {
                    to[..rest.len()].copy_from_slice(rest);
                }
            }
        }
    }
}

/// Looks at the patches of a sheet whose particles are at these places.
struct LookAtPatches<'a> {
    layout: &'a Layout,
    at: &'a Soa,
    all: &'a mut Vec<Patch>,
}

impl Kernel for LookAtPatches<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { layout, at, all } = self;
        for first_row in (0..layout.rows).step_by(SIDE) {
            for column in (0..layout.columns).step_by(LANES) {
                let rows = layout.rows.min(first_row + SIDE) - first_row;
                let seen = Seen::new(layout, at, first_row, rows, column);
                all.extend(seen.patches());
            }
        }
    }
}

/// Boxes and normals of the patches in a block, a column each.
struct Seen {
    wide: Wide,
    /// Normals of the cells of each row, of length one; zero beside the sheet.
    normals: [Block3; SIDE],
    sum: Block3,
}

impl Seen {
    #[inline(always)]
    fn new(layout: &Layout, at: &Soa, first_row: usize, rows: usize, column: usize) -> Self {
        let mut seen =
            Self { wide: Wide::nothing(), normals: [Block3::ZERO; SIDE], sum: Block3::ZERO };
        let inside = layout.inside(first_row, column);
        for (normals, row) in seen.normals.iter_mut().zip(first_row..first_row + rows) {
            let slot = layout.slot(row, column);
            let here = Block3::load(at, slot);
            seen.wide.take(&here, inside);
            if row + 1 == layout.rows {
                continue;
            }
            let (right, below) =
                (Block3::load(at, slot + 1), Block3::load(at, slot + layout.stride));
            let across = Block3::load(at, slot + layout.stride + 1);
            for i in 0..LANES {
                // Of a cell, by its diagonals.
                let (a, b) = (across.at(i) - here.at(i), right.at(i) - below.at(i));
                let normal = a.cross(b);
                let part = 1.0 / larger(normal.dot(normal), f32::MIN_POSITIVE).sqrt();
                let normal = if i + 1 < inside { normal * part } else { Vec3::ZERO };
                normals.set(i, normal);
                seen.sum.set(i, seen.sum.at(i) + normal);
            }
        }
        seen
    }

    /// The patches, each of some lanes.
    #[inline(always)]
    fn patches(&self) -> [Patch; IN_BLOCK] {
        let Wide { low, high } = &self.wide;
        let low = [low.x, low.y, low.z].map(|along| of_each_patch(along, smaller));
        let high = [high.x, high.y, high.z].map(|along| of_each_patch(along, larger));
        let [x, y, z] =
            [self.sum.x, self.sum.y, self.sum.z].map(|along| of_each_patch(along, |a, b| a + b));
        let mut axes = Block3 { x, y, z };
        for i in 0..LANES {
            let axis = axes.at(i);
            axes.set(i, axis * (1.0 / larger(axis.dot(axis), f32::MIN_POSITIVE).sqrt()));
        }
        let mut cosines = Block::splat(1.0);
        for normals in &self.normals {
            for i in 0..LANES {
                let n = normals.at(i);
                // Beside the sheet there is none.
                let along = if n.dot(n) == 0.0 { 1.0 } else { n.dot(axes.at(i)) };
                cosines.0[i] = smaller(along, cosines.0[i]);
            }
        }
        let cosines = of_each_patch(cosines, smaller);
        core::array::from_fn(|patch| {
            let i = patch * SIDE;
            let corner = |along: &[Block; 3]| Vec3::from(along.map(|along| along.0[i]));
            let extent = Extent { low: corner(&low), high: corner(&high) };
            Patch::new(extent, axes.at(i), cosines.0[i])
        })
    }
}

/// In all lanes of a patch what comes out for them together.
#[inline(always)]
fn of_each_patch(mut lanes: Block, with: impl Fn(f32, f32) -> f32) -> Block {
    for apart in [1, 2] {
        let before = lanes;
        for i in 0..LANES {
            lanes.0[i] = with(before.0[i], before.0[i ^ apart]);
        }
    }
    lanes
}
