//! Patches of a sheet, and which of them may meet another or themselves.
//!
//! A patch whose normals lie within a narrow cone cannot meet itself, nor a neighbour that lies within the same cone (Volino and
//! Magnenat-Thalmann 1994, *Efficient Self-Collision Detection on Smoothly Discretized Surface Animations using Geometrical Shape
//! Regularity*). Others may where their boxes come near each other. A sheet that hangs or lies smoothly has none that may.

use bevy_math::Vec3;

use crate::solver::simd::block::{Block3, larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Rows and columns of a patch. Larger ones are bent more often, smaller ones have more to look at.
const SIDE: usize = 4;
/// Patches in a block.
const IN_BLOCK: usize = LANES / SIDE;
/// Cosine of half the angle of a narrow cone. Seen from its axis, two particles that are not neighbours are at least 1.57 spacings
/// apart, and do not touch before the cloth has moved by the margin.
const NARROW: f32 = 0.785;

/// A part of a sheet.
#[derive(Clone, Copy, Debug)]
struct Patch {
    /// The box around its particles \[m\].
    low: Vec3,
    high: Vec3,
    /// Axis of the cone that its normals lie in, of length one, and the cosine of half the cone's angle.
    axis: Vec3,
    cosine: f32,
}

impl Patch {
    /// Whether its cone lies in a narrow one around an axis.
    fn is_along(&self, axis: Vec3) -> bool {
        let (a, b) = (self.axis.dot(axis), self.cosine);
        let sines = ((1.0 - a * a).max(0.0) * (1.0 - b * b).max(0.0)).sqrt();
        a > 0.0 && b > 0.0 && a * b - sines >= NARROW
    }

    fn is_near(&self, other: &Self, reach: f32) -> bool {
        let gap = (self.low - other.high).max(other.low - self.high);
        gap.x.max(gap.y).max(gap.z) < reach
    }
}

/// The patches of a sheet, row by row.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    layout: Layout,
    across: usize,
    all: Vec<Patch>,
    /// Patches by where their boxes begin along x.
    order: Vec<u32>,
    /// Whether a patch may meet another or itself.
    is_busy: Vec<bool>,
}

impl Patches {
    pub fn new(layout: Layout) -> Self {
        let across = layout.blocks_across() * IN_BLOCK;
        let count = layout.rows.div_ceil(SIDE) * across;
        Self {
            layout,
            across,
            all: Vec::with_capacity(count),
            order: Vec::with_capacity(count),
            is_busy: Vec::with_capacity(count),
        }
    }

    /// The slots of all particles in patches that may meet another or themselves.
    pub fn busy_slots(&self) -> impl Iterator<Item = usize> + '_ {
        let layout = self.layout;
        let busy = self.is_busy.iter().enumerate().filter(|&(_, &busy)| busy);
        busy.flat_map(move |(patch, _)| {
            let (row, column) = (patch / self.across * SIDE, patch % self.across * SIDE);
            let columns = layout.columns.saturating_sub(column).min(SIDE);
            let rows = row..layout.rows.min(row + SIDE);
            rows.flat_map(move |row| {
                let first = layout.slot(row, column);
                first..first + columns
            })
        })
    }

    /// Finds the patches that may meet something before the cloth has moved by the margin, where two particles may touch that are
    /// `reach` apart now.
    pub fn find_busy(&mut self, reach: f32) {
        let Self { all, order, is_busy, across, .. } = self;
        is_busy.clear();
        is_busy.extend(all.iter().map(|patch| patch.cosine < NARROW));
        order.clear();
        order.extend(0..all.len() as u32);
        let low = |patch: u32| all[patch as usize].low.x;
        order.sort_unstable_by(|&a, &b| low(a).total_cmp(&low(b)).then(a.cmp(&b)));
        for (place, &a) in order.iter().enumerate() {
            let (a, end) = (a as usize, all[a as usize].high.x + reach);
            for &b in order[place + 1..].iter().take_while(|&&b| low(b) < end) {
                let b = b as usize;
                if (!is_busy[a] || !is_busy[b])
                    && all[a].is_near(&all[b], reach)
                    && !are_flat_neighbours(all, *across, a, b)
                {
                    (is_busy[a], is_busy[b]) = (true, true);
                }
            }
        }
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
    let axis = sum.normalize_or_zero();
    around.iter().all(|&patch| all[patch].is_along(axis))
}

/// Looks at the patches of a sheet whose particles are at these places.
pub(super) struct LookAtPatches<'a> {
    pub patches: &'a mut Patches,
    pub at: &'a Soa,
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
    low: Block3,
    high: Block3,
    /// Normals of the cells of each row, of length one; zero beside the sheet.
    normals: [Block3; SIDE],
    sum: Block3,
}

impl Seen {
    #[inline(always)]
    fn new(layout: &Layout, at: &Soa, first_row: usize, rows: usize, column: usize) -> Self {
        let mut seen = Self {
            low: Block3::splat(Vec3::INFINITY),
            high: Block3::splat(Vec3::NEG_INFINITY),
            normals: [Block3::ZERO; SIDE],
            sum: Block3::ZERO,
        };
        let inside = layout.inside(first_row, column);
        for (normals, row) in seen.normals.iter_mut().zip(first_row..first_row + rows) {
            let slot = layout.slot(row, column);
            let here = Block3::load(at, slot);
            for i in 0..LANES {
                let (p, a, b) = (here.at(i), seen.low.at(i), seen.high.at(i));
                let least = Vec3::new(smaller(p.x, a.x), smaller(p.y, a.y), smaller(p.z, a.z));
                let most = Vec3::new(larger(p.x, b.x), larger(p.y, b.y), larger(p.z, b.z));
                seen.low.set(i, if i < inside { least } else { a });
                seen.high.set(i, if i < inside { most } else { b });
            }
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
            let (p, q) = (self.low.at(i), self.high.at(i));
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
        Patch { low, high, axis, cosine }
    }
}
