//! The patches of a sheet: squares of its particles, row by row.

use bevy_math::Vec3;

use crate::solver::cloth_contact::patch::{Cones, PARTICLES, Patch, narrow_cosine};
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
/// The bits of what a patch lies in a narrow cone with.
const NEXT: u32 = 1;
const BELOW: u32 = 2;
const ACROSS: u32 = 4;

/// The patches of a sheet.
#[derive(Clone, Debug)]
pub(super) struct SheetPatches {
    layout: Layout,
    across: usize,
    cones: Cones,
    /// By patch, whether it lies in a narrow cone with the next one, with the one below, and with these two and the one across: a bit
    /// each.
    flat: Vec<u32>,
}

impl SheetPatches {
    pub fn new(layout: Layout) -> Self {
        let across = layout.blocks_across() * IN_BLOCK;
        let count = (layout.rows.div_ceil(SIDE) * across).next_multiple_of(LANES);
        // The neighbours of the last block are beside the sheet.
        let cones = Cones::zeros((count + across + 1).next_multiple_of(LANES) + LANES);
        Self { layout, across, cones, flat: vec![0; count] }
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
    pub fn look(&mut self, isa: Isa, at: &Soa, x: &mut Soa, all: &mut Vec<Patch>) {
        let Self { layout, across, cones, flat } = self;
        isa.run(LookAtPatches { layout, at, all, cones });
        isa.run(FindFlat { across: *across, cones, flat });
        self.put(at, x);
    }

    /// Whether two patches are side by side, or corner to corner, and all patches around their seam lie in one narrow cone.
    pub fn are_flat_neighbours(&self, [a, b]: [u32; 2]) -> bool {
        let place = |patch: u32| [patch as usize / self.across, patch as usize % self.across];
        let ([row_a, column_a], [row_b, column_b]) = (place(a), place(b));
        let first = row_a.min(row_b) * self.across + column_a.min(column_b);
        let with = match [row_a.abs_diff(row_b), column_a.abs_diff(column_b)] {
            [0, 1] => NEXT,
            [1, 0] => BELOW,
            [1, 1] => ACROSS,
            _ => 0,
        };
        self.flat[first] & with != 0
    }

    /// Writes where particles are patch by patch.
    fn put(&self, at: &Soa, x: &mut Soa) {
        let Self { layout, across, .. } = *self;
        for (to, from) in [(&mut x.x, &at.x), (&mut x.y, &at.y), (&mut x.z, &at.z)] {
            for row in 0..layout.rows {
                let from = &from[layout.slot(row, 0)..][..layout.columns];
                let (whole, rest) = from.as_chunks::<SIDE>();
                let places = to.as_chunks_mut::<SIDE>().0;
                let places = &mut places[row / SIDE * across * SIDE + row % SIDE..];
                let mut places = places.iter_mut().step_by(SIDE);
                // What is whole comes first: the other way around, a place too many would be taken.
                for (from, to) in whole.iter().zip(places.by_ref()) {
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
    cones: &'a mut Cones,
}

impl Kernel for LookAtPatches<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { layout, at, all, cones } = self;
        for first_row in (0..layout.rows).step_by(SIDE) {
            for column in (0..layout.columns).step_by(LANES) {
                let rows = layout.rows.min(first_row + SIDE) - first_row;
                let seen = Seen::new(layout, at, first_row, rows, column);
                for patch in seen.patches() {
                    cones.set(all.len(), &patch);
                    all.push(patch);
                }
            }
        }
    }
}

/// Finds which neighbours of each patch lie in a narrow cone with it.
struct FindFlat<'a> {
    across: usize,
    cones: &'a Cones,
    flat: &'a mut [u32],
}

impl Kernel for FindFlat<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { across, cones, flat } = self;
        for (block, flat) in flat.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let first = block * LANES;
            let own = cones.load(first);
            let (next, below) = (cones.load(first + 1), cones.load(first + across));
            let opposite = cones.load(first + across + 1);
            let is_next = Cones::are_flat([&own, &next]);
            let is_below = Cones::are_flat([&own, &below]);
            let is_across = Cones::are_flat([&own, &next, &below, &opposite]);
            for (i, flat) in flat.iter_mut().enumerate() {
                let bit = |is_flat: f32, bit: u32| if is_flat > 0.0 { bit } else { 0 };
                *flat = bit(is_next.0[i], NEXT)
                    | bit(is_below.0[i], BELOW)
                    | bit(is_across.0[i], ACROSS);
            }
        }
    }
}

/// Boxes and normals of the patches in a block, a column each.
struct Seen {
    wide: Wide,
    /// Normals of the cells of each row, as long as twice their areas; zero beside the sheet.
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
            // The last row has the cells above it, where it is alone in its patches: without any, nothing would tell a fold.
            let slot = match (row + 1 == layout.rows, rows) {
                (false, _) => slot,
                (true, 1) => slot - layout.stride,
                (true, _) => continue,
            };
            let (here, below) = (Block3::load(at, slot), Block3::load(at, slot + layout.stride));
            let right = Block3::load(at, slot + 1);
            let across = Block3::load(at, slot + layout.stride + 1);
            for i in 0..LANES {
                // Of a cell, by its diagonals.
                let (a, b) = (across.at(i) - here.at(i), right.at(i) - below.at(i));
                let normal = if i + 1 < inside { a.cross(b) } else { Vec3::ZERO };
                normals.set(i, normal);
            }
            // And so has the last column those before it.
            if inside <= LANES && (inside - 1).is_multiple_of(SIDE) {
                let last = slot + inside - 1;
                let corner = |slot: usize| at.get(slot);
                let a = corner(last + layout.stride) - corner(last - 1);
                let b = corner(last) - corner(last + layout.stride - 1);
                normals.set(inside - 1, a.cross(b));
            }
            for i in 0..LANES {
                seen.sum.set(i, seen.sum.at(i) + normals.at(i));
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
        // Squares that have the cosines' signs.
        let mut squares = Block::splat(1.0);
        for normals in &self.normals {
            for i in 0..LANES {
                let n = normals.at(i);
                let (along, squared) = (n.dot(axes.at(i)), n.dot(n));
                // Beside the sheet there is none.
                let square = if squared > 0.0 { along * along.abs() / squared } else { 1.0 };
                squares.0[i] = smaller(square, squares.0[i]);
            }
        }
        let squares = of_each_patch(squares, smaller);
        let mut least = Block::ZERO;
        for i in 0..LANES {
            least.0[i] = narrow_cosine(larger(squares.0[i], 0.0).sqrt());
        }
        core::array::from_fn(|patch| {
            let i = patch * SIDE;
            let corner = |along: &[Block; 3]| Vec3::from(along.map(|along| along.0[i]));
            let extent = Extent { low: corner(&low), high: corner(&high) };
            let axis = axes.at(i);
            // The last row or column may be alone in a patch. Without a cell, nothing tells whether it is bent.
            let is_line = axis == Vec3::ZERO && extent.low.x < f32::INFINITY;
            let least_cosine = if is_line { f32::INFINITY } else { least.0[i] };
            Patch { extent, axis, least_cosine }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::cloth_contact::patch::are_flat;

    /// Patches of a sheet with folds along both sides, and the seams between them, one by one.
    #[test]
    fn neighbours_are_flat_where_all_patches_around_their_seam_lie_in_a_narrow_cone() {
        for (rows, columns) in [(21, 37), (64, 64), (4, 16)] {
            let layout = Layout::new(rows, columns);
            let mut at = Soa::zeros(layout.len());
            for row in 0..rows {
                for column in 0..columns {
                    let (u, v) = (column as f32, row as f32);
                    let up = 3.0 * (0.3 * u).sin() * (0.11 * v).cos() + 2.0 * (0.35 * v).sin();
                    at.set(layout.slot(row, column), Vec3::new(u, up, v));
                }
            }
            let mut sheet = SheetPatches::new(layout);
            let mut x = Soa::zeros(sheet.count() * PARTICLES);
            let mut all = Vec::new();
            sheet.look(Isa::detect(), &at, &mut x, &mut all);
            assert_eq!(all.len(), sheet.count());
            let (high, wide) = (rows.div_ceil(SIDE), columns.div_ceil(SIDE));
            let mut found = [0; 2];
            for a in 0..high * wide {
                for b in a + 1..high * wide {
                    let [[row_a, column_a], [row_b, column_b]] =
                        [a, b].map(|patch| [patch / wide, patch % wide]);
                    let number = |row: usize, column: usize| row * sheet.across + column;
                    let is_beside = row_a.abs_diff(row_b) <= 1 && column_a.abs_diff(column_b) <= 1;
                    let around = [
                        [row_a, column_a],
                        [row_a, column_b],
                        [row_b, column_a],
                        [row_b, column_b],
                    ];
                    let around = around.map(|[row, column]| number(row, column));
                    let is_flat = is_beside && are_flat(&all, around.into_iter());
                    for pair in [[0, 3], [3, 0]] {
                        let pair = pair.map(|i| around[i] as u32);
                        assert_eq!(sheet.are_flat_neighbours(pair), is_flat, "{pair:?}");
                    }
                    found[usize::from(is_flat)] += usize::from(is_beside);
                }
            }
            assert!(found.iter().all(|&count| count > 0), "{rows} x {columns}: {found:?}");
        }
    }
}
