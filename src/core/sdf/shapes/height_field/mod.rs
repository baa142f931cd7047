//! Height field: ground given by its height over a grid.

mod block;
mod column;
mod construct;
mod nearest;
mod pyramid;
mod triangle;

pub use block::{height_field_block, height_field_distance_block};
pub use construct::HeightFieldError;

use super::larger;
use crate::sdf::{KnownShape, LANES, PointBlock, SampleBlock, SdfSample, SignedDistance};
use bevy_math::{Vec2, Vec3, bounding::Aabb3d};
use column::Column;
use core::fmt;
use nearest::Search;
use pyramid::Pyramid;
use triangle::Cell;

/// Ground: heights over a rectangle of the XZ plane around the origin, and everything that is below them.
///
/// The heights are joined by triangles, two a cell, as parry's `HeightField` has it. The solid is what lies
/// below the triangles and above a floor, and ends at the rectangle's border with upright walls. The floor is
/// there so that the ground has a box, beside which other things are not looked at; by default it is as deep
/// below the lowest height as the rectangle is long, so that what has fallen through a hill is pushed
/// up. Where a triangle is taken away there is a shaft to below the floor, with upright walls too.
///
/// The distance is exact everywhere, up to the rounding of `f32`. A point within a few cells of the ground
/// looks at a few triangles; one that is far looks at more, through boxes around squares of two, four, eight
/// cells and so on.
///
/// Below the ground, near the border, the nearest way out is the wall. Fields side by side should
/// overlap by as much as something may sink in, or they push it back and forth in their seam.
pub struct HeightField {
    /// Heights along x, and along z.
    columns: usize,
    rows: usize,
    size: [f32; 2],
    /// Number of cells along x and z, not as whole numbers, which lanes would convert; and a cell's part of the size.
    count: [f32; 2],
    step: [f32; 2],
    /// Row by row.
    heights: Box<[f32]>,
    /// Row by row; none if all are whole and divided the usual way.
    cells: Box<[HeightFieldCell]>,
    /// Whether a triangle is missing somewhere.
    has_holes: bool,
    pyramid: Pyramid,
    floor: f32,
    core_depth: f32,
    /// Rounding of places near the ground, as seen from a point near it \[m\].
    room: f32,
}

/// How a cell of a [`HeightField`] is divided into two triangles, and which of them are there.
///
/// With `x` to the right and `z` downwards, the triangles of a cell are
///
/// ```text
///   usual     zigzag
///   .--.      .--.
///   | /|      |\ |
///   |/ |      | \|
///   '--'      '--'
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HeightFieldCell {
    /// Whether the diagonal joins the corner of least `x` and least `z` with that of most `x` and most `z`; the
    /// other two if not.
    pub zigzag: bool,
    /// Whether the triangle at the side of least `x` is missing.
    pub left_removed: bool,
    /// Whether the triangle at the side of most `x` is missing.
    pub right_removed: bool,
}

impl HeightFieldCell {
    /// Whether each triangle is there, the left one first.
    fn present(self) -> [bool; 2] {
        [!self.left_removed, !self.right_removed]
    }
}

impl HeightField {
    /// Number of heights along x.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of heights along z.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Sides of the rectangle along x and z \[m\].
    pub fn size(&self) -> Vec2 {
        self.size.into()
    }

    /// Height where the solid ends below \[m\].
    pub fn floor(&self) -> f32 {
        self.floor
    }

    /// Heights \[m\], row by row: those of least z first, and in a row those of least x.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// A cell, of which there are one less than heights each way; `None` beyond.
    pub fn cell(&self, column: usize, row: usize) -> Option<HeightFieldCell> {
        (column + 1 < self.columns && row + 1 < self.rows).then(|| self.cell_at(column, row))
    }

    /// Height of the ground at a place \[m\]; `None` beyond the border and in holes.
    pub fn height_at(&self, x: f32, z: f32) -> Option<f32> {
        let at = self.column_at([x, 0.0, z]);
        (at.is_within && self.is_ground(&at)).then_some(-at.above)
    }

    /// Memory that the field takes \[B\].
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>()
            + size_of_val::<[f32]>(&self.heights)
            + size_of_val::<[HeightFieldCell]>(&self.cells)
            + self.pyramid.memory_bytes()
    }

    /// Whether the triangle above or below a point is there.
    #[inline(always)]
    fn is_ground(&self, at: &Column) -> bool {
        !self.has_holes
            || self.cell_at(at.column as usize, at.row as usize).present()[usize::from(at.is_right)]
    }

    #[inline(always)]
    fn cell_at(&self, column: usize, row: usize) -> HeightFieldCell {
        if self.cells.is_empty() {
            return HeightFieldCell::default();
        }
        self.cells[row * (self.columns - 1) + column]
    }

    /// The last height along x or z (`axis` zero and one); also the number of cells.
    #[inline(always)]
    fn last(&self, axis: usize) -> usize {
        [self.columns, self.rows][axis] - 1
    }

    /// Where a column of heights stands along x, and a row along z (`axis` zero and one). The operations are
    /// those of parry, so the vertices are its to the bit.
    #[inline(always)]
    fn place(&self, axis: usize, index: usize) -> f32 {
        self.place_of(axis, index as f32)
    }

    /// [`place`](Self::place) of a whole number.
    #[inline(always)]
    fn place_of(&self, axis: usize, index: f32) -> f32 {
        (-0.5 + self.step[axis] * index) * self.size[axis]
    }

    /// A cell's two triangles as seen from a point.
    #[inline(always)]
    fn seen(&self, column: usize, row: usize, point: [f32; 3]) -> Cell {
        let x = [self.place(0, column), self.place(0, column + 1)];
        let z = [self.place(1, row), self.place(1, row + 1)];
        let zigzag = self.cell_at(column, row).zigzag;
        Cell::new(x, z, self.corner_heights(column, row), zigzag, point)
    }

    /// A cell's heights: two of least z, then two of most z, those of least x first.
    #[inline(always)]
    fn corner_heights(&self, column: usize, row: usize) -> [f32; 4] {
        let first = row * self.columns + column;
        // One check for the cell instead of four.
        let heights = &self.heights[first..][..self.columns + 2];
        [heights[0], heights[1], heights[self.columns], heights[self.columns + 1]]
    }
}

/// Without the heights, which are many.
impl fmt::Debug for HeightField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HeightField")
            .field("columns", &self.columns)
            .field("rows", &self.rows)
            .field("size", &self.size)
            .field("floor", &self.floor)
            .finish_non_exhaustive()
    }
}

impl SignedDistance for HeightField {
    fn sample(&self, point: Vec3) -> SdfSample {
        if !point.is_finite() {
            // Infinitely far or nowhere.
            let distance = larger(larger(point.x.abs(), point.y.abs()), point.z.abs());
            let distance = if point.is_nan() { f32::NAN } else { distance };
            return SdfSample { distance, normal: Vec3::Y };
        }
        Search::run(self, point.to_array())
    }

    fn sample_block(&self, points: &PointBlock, out: &mut SampleBlock) {
        height_field_block(self, points, out);
    }

    fn distance_block(&self, points: &PointBlock, out: &mut [f32; LANES]) {
        height_field_distance_block(self, points, out);
    }

    fn known(&self) -> Option<KnownShape<'_>> {
        Some(KnownShape::HeightField(self))
    }

    fn bounds(&self) -> Option<Aabb3d> {
        let [x, z] = self.size.map(|side| 0.5 * side);
        let top = self.pyramid.highest();
        Some(Aabb3d { min: Vec3::new(-x, self.floor, -z).into(), max: Vec3::new(x, top, z).into() })
    }

    /// As long as a cell, and as much less as the steepest place is steeper than one in one: what is thinner is
    /// a crest. Zero with holes, between which any thin wall may stand.
    fn core_depth(&self) -> f32 {
        self.core_depth
    }
}
