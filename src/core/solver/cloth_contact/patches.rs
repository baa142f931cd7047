//! Patches of a sheet, and which of them may meet another or themselves.
//!
//! A patch whose normals lie within a narrow cone cannot meet itself, nor a neighbour that lies within the same cone (Volino and
//! Magnenat-Thalmann 1994, *Efficient Self-Collision Detection on Smoothly Discretized Surface Animations using Geometrical Shape
//! Regularity*). Others may where their boxes come near each other. A sheet that hangs or lies smoothly has none that may.

use bevy_math::Vec3;

use crate::solver::cloth_contact::regions::{Extent, Wide};
use crate::solver::cloth_contact::sweep::Sweep;
use crate::solver::simd::block::{Block3, larger, smaller};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Rows and columns of a patch. Larger ones are bent more often, smaller ones have more to look at.
pub(super) const SIDE: usize = 4;
/// Particles of a patch.
pub(super) const PARTICLES: usize = SIDE * SIDE;
/// Patches in a block.
const IN_BLOCK: usize = LANES / SIDE;
/// Pairs of patches that there is room for from the start, for each patch.
const ROOM: usize = 8;
/// Cosine of half the angle of a narrow cone. Seen from its axis, two particles that are not neighbours are at least 1.57 spacings
/// apart, and do not touch before the cloth has moved by the margin.
const NARROW: f32 = 0.785;

/// A part of a sheet.
#[derive(Clone, Copy, Debug)]
struct Patch {
    /// The box around its particles \[m\].
    extent: Extent,
    /// Axis of the cone that its normals lie in, of length one.
    axis: Vec3,
    /// Least cosine of the angle between this axis and that of a narrow cone which holds the cone; infinite where none does, as the
    /// patch is bent.
    least_cosine: f32,
}

impl Patch {
    /// A part in this box, whose normals lie in a cone of which half the angle has this cosine.
    #[inline(always)]
    fn new(extent: Extent, axis: Vec3, cosine: f32) -> Self {
        // The cosine of the difference of both angles.
        let sines = larger((1.0 - NARROW * NARROW) * (1.0 - cosine * cosine), 0.0).sqrt();
        let least_cosine = if cosine < NARROW { f32::INFINITY } else { NARROW * cosine + sines };
        Self { extent, axis, least_cosine }
    }

    fn is_bent(&self) -> bool {
        self.least_cosine == f32::INFINITY
    }

    /// Whether its cone lies in a narrow one around a vector of this length.
    fn is_along(&self, along: Vec3, length: f32) -> bool {
        self.axis.dot(along) >= self.least_cosine * length
    }
}

/// The patches of a sheet, row by row.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    layout: Layout,
    across: usize,
    all: Vec<Patch>,
    sweep: Sweep,
    /// The patches that may meet each other, or themselves.
    meetings: Vec<[u32; 2]>,
}

impl Patches {
    pub fn new(layout: Layout) -> Self {
        let across = layout.blocks_across() * IN_BLOCK;
        let count = layout.rows.div_ceil(SIDE) * across;
        Self {
            layout,
            across,
            all: Vec::with_capacity(count),
            sweep: Sweep::with_room(count, ROOM * count),
            meetings: Vec::with_capacity(ROOM * count),
        }
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

    /// Looks at particles that are at these places.
    pub fn look(&mut self, isa: Isa, at: &Soa) {
        isa.run(LookAtPatches { patches: self, at });
    }

    /// The patches that may meet each other, or themselves.
    pub fn meetings(&self) -> &[[u32; 2]] {
        &self.meetings
    }

    /// Finds the patches that may meet before the cloth has moved by the margin, where two particles may touch that are `reach` apart
    /// now.
    pub fn find_meetings(&mut self, isa: Isa, reach: f32) {
        let Self { all, sweep, meetings, across, .. } = self;
        meetings.clear();
        let is_bent = |patch: &u32| all[*patch as usize].is_bent();
        meetings.extend((0..all.len() as u32).filter(is_bent).map(|patch| [patch; 2]));
        let extent = |patch: u32| &all[patch as usize].extent;
        let near = sweep.near(isa, all.len(), extent, reach);
        let may_meet =
            |&&[a, b]: &&[u32; 2]| !are_flat_neighbours(all, *across, a as usize, b as usize);
        meetings.extend(near.iter().filter(may_meet));
    }
}

/// Whether two patches are side by side, or corner to corner, and all patches around their seam lie in one narrow cone.
fn are_flat_neighbours(all: &[Patch], across: usize, a: usize, b: usize) -> bool {
    let ([row_a, column_a], [row_b, column_b]) =
        ([a / across, a % across], [b / across, b % across]);
    if row_a.abs_diff(row_b) > 1 || column_a.abs_diff(column_b) > 1 {
        return false;
    }
    let around = [a, b, row_a * across + column_b, row_b * across + column_a];
    let sum = around.iter().map(|&patch| all[patch].axis).sum::<Vec3>();
    let length = sum.length();
    length > 0.0 && around.iter().all(|&patch| all[patch].is_along(sum, length))
}

/// Looks at the patches of a sheet whose particles are at these places.
struct LookAtPatches<'a> {
    patches: &'a mut Patches,
    at: &'a Soa,
}

impl Kernel for LookAtPatches<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { patches, at } = self;
        let layout = patches.layout;
        patches.all.clear();
        for first_row in (0..layout.rows).step_by(SIDE) {
            for column in (0..layout.columns).step_by(LANES) {
                let rows = layout.rows.min(first_row + SIDE) - first_row;
                let seen = Seen::new(&layout, at, first_row, rows, column);
                for lane in (0..LANES).step_by(SIDE) {
                    patches.all.push(seen.patch(lane));
                }
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

    /// The patch from a lane on.
    #[inline(always)]
    fn patch(&self, first: usize) -> Patch {
        let (mut low, mut high, mut axis) = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
        for i in first..first + SIDE {
            let (p, q) = (self.wide.low.at(i), self.wide.high.at(i));
            low = Vec3::new(smaller(p.x, low.x), smaller(p.y, low.y), smaller(p.z, low.z));
            high = Vec3::new(larger(q.x, high.x), larger(q.y, high.y), larger(q.z, high.z));
            axis += self.sum.at(i);
        }
        let axis = axis * (1.0 / larger(axis.dot(axis), f32::MIN_POSITIVE).sqrt());
        let mut cosine = 1.0;
        for normals in &self.normals {
            for i in first..first + SIDE {
                let n = normals.at(i);
                // Beside the sheet there is none.
                let along = if n.dot(n) == 0.0 { 1.0 } else { n.dot(axis) };
                cosine = smaller(along, cosine);
            }
        }
        Patch::new(Extent { low, high }, axis, cosine)
    }
}
