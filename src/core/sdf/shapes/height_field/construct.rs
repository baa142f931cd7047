//! From heights to a height field.

use super::pyramid::{Node, Pyramid, Range};
use super::{HeightField, HeightFieldCell};
use bevy_math::Vec2;

/// Most heights along an axis: more could not be told apart by their places in `f32`.
const MOST: usize = 65_537;
/// Smallest and largest side of the rectangle \[m\], and largest height: squares of all are well within `f32`.
const SIDES: core::ops::RangeInclusive<f32> = 1e-6..=1e7;

/// A few roundings of a number, in parts of it.
pub(super) const ROUNDING: f32 = 4e-7;

/// Why heights make no [`HeightField`].
#[derive(thiserror::Error, Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// Too few or too many for a grid.
    #[error(
        "a height field cannot have {columns} by {rows} heights: give it from 2 to 65537 each way, and larger ground as several fields"
    )]
    Counts {
        /// Number of heights along x.
        columns: usize,
        /// Number of heights along z.
        rows: usize,
    },
    /// Not as many as the grid has places.
    #[error("a height field was given {found} heights: give it columns times rows, {expected}")]
    HeightCount {
        /// How many it needs.
        expected: usize,
        /// How many there were.
        found: usize,
    },
    /// A side of no length, or of no number.
    #[error("a height field cannot measure {x} by {z} m: give it sides from 1e-6 to 1e7 m")]
    Size {
        /// Along x \[m\].
        x: f32,
        /// Along z \[m\].
        z: f32,
    },
    /// No number, or too large.
    #[error(
        "the height of a height field at column {column} of row {row} is {height} m: give it one within 1e7 m, and take triangles away where there is no ground"
    )]
    Height {
        /// Which one along x, from zero.
        column: usize,
        /// Which one along z, from zero.
        row: usize,
        /// What it is \[m\].
        height: f32,
    },
    /// The ground would reach below its floor.
    #[error(
        "the floor of a height field cannot be at {floor} m: put it below the lowest height, {lowest} m, and within 1e8 m"
    )]
    Floor {
        /// Where it was to be \[m\].
        floor: f32,
        /// Least height of the ground \[m\].
        lowest: f32,
    },
    /// There is nothing to be near to.
    #[error("no triangle of a height field is left: take fewer away, or leave the field out")]
    NothingLeft,
}

impl HeightField {
    /// Ground with `columns` heights along x and `rows` along z, over a rectangle of this `size` along x and z
    /// \[m\] around the origin. Heights are row by row: those of least z first, and in a row those of least x.
    ///
    /// Takes a few operations a height, and as much memory again.
    ///
    /// # Errors
    ///
    /// If there are not as many heights as that, fewer than two or more than 65537 along an axis, if one is no
    /// number or beyond 1e7 m, or if the rectangle has no size.
    pub fn new(
        columns: usize,
        rows: usize,
        heights: impl Into<Box<[f32]>>,
        size: Vec2,
    ) -> Result<Self, HeightFieldError> {
        let heights = heights.into();
        let counts = 2..=MOST;
        if !(counts.contains(&columns) && counts.contains(&rows)) {
            return Err(HeightFieldError::Counts { columns, rows });
        }
        let (expected, found) = (columns * rows, heights.len());
        if found != expected {
            return Err(HeightFieldError::HeightCount { expected, found });
        }
        if !(SIDES.contains(&size.x) && SIDES.contains(&size.y)) {
            return Err(HeightFieldError::Size { x: size.x, z: size.y });
        }
        let is_sound = |height: &f32| height.abs() <= *SIDES.end();
        if let Some(index) = heights.iter().position(|height| !is_sound(height)) {
            let (column, row) = (index % columns, index / columns);
            return Err(HeightFieldError::Height { column, row, height: heights[index] });
        }
        let mut field = Self {
            columns,
            rows,
            size: size.to_array(),
            count: [columns, rows].map(|count| count as f32 - 1.0),
            step: [columns, rows].map(|count| 1.0 / (count as f32 - 1.0)),
            cells: Box::default(),
            has_holes: false,
            pyramid: pyramid(columns, rows, &heights, &[]),
            heights,
            floor: 0.0,
            core_depth: 0.0,
            room: 0.0,
        };
        let [cell_x, cell_z] = [0, 1].map(|axis| field.size[axis] * field.step[axis]);
        let rise = field.pyramid.highest() - field.pyramid.lowest();
        field.room = ROUNDING * (cell_x + cell_z + rise);
        field.floor = field.pyramid.lowest() - size.max_element();
        field.core_depth = field.measure_core();
        Ok(field)
    }

    /// Puts the floor at a height \[m\].
    ///
    /// # Errors
    ///
    /// If that is not below the lowest place of the ground, or beyond 1e8 m.
    pub fn with_floor(mut self, floor: f32) -> Result<Self, HeightFieldError> {
        let lowest = self.pyramid.lowest();
        if !(-1e8..lowest).contains(&floor) {
            return Err(HeightFieldError::Floor { floor, lowest });
        }
        self.floor = floor;
        self.core_depth = self.measure_core();
        Ok(self)
    }

    /// Divides each cell as `cell` says, which is given its place along x and along z, from zero. Cells are
    /// otherwise divided the usual way, with both triangles there.
    ///
    /// # Errors
    ///
    /// If no triangle is left.
    pub fn with_cells(
        mut self,
        mut cell: impl FnMut(usize, usize) -> HeightFieldCell,
    ) -> Result<Self, HeightFieldError> {
        let (columns, rows) = (self.columns - 1, self.rows - 1);
        let cells: Vec<HeightFieldCell> =
            (0..columns * rows).map(|index| cell(index % columns, index / columns)).collect();
        if cells.iter().all(|cell| cell.present() == [false; 2]) {
            return Err(HeightFieldError::NothingLeft);
        }
        self.has_holes = cells.iter().any(|cell| cell.present() != [true; 2]);
        self.cells = cells.into();
        self.pyramid = pyramid(self.columns, self.rows, &self.heights, &self.cells);
        self.core_depth = self.measure_core();
        Ok(self)
    }

    /// A square of cells; one cell in level zero.
    #[inline(always)]
    pub(super) fn node(&self, level: usize, column: usize, row: usize) -> Node {
        if level > 0 {
            return self.pyramid.node(level, column, row);
        }
        cell_node(self.corner_heights(column, row), self.cell_at(column, row))
    }

    /// See [`core_depth`](crate::sdf::SignedDistance::core_depth).
    fn measure_core(&self) -> f32 {
        if self.has_holes {
            return 0.0;
        }
        let mut steepest = 1_f32;
        for row in 0..self.rows - 1 {
            for column in 0..self.columns - 1 {
                for triangle in self.seen(column, row, [0.0; 3]).0 {
                    steepest = steepest.max(triangle.steepness());
                }
            }
        }
        let side = (self.size[0] * self.step[0]).min(self.size[1] * self.step[1]);
        (side / steepest).min(0.5 * (self.pyramid.lowest() - self.floor))
    }
}

fn cell_node(heights: [f32; 4], cell: HeightFieldCell) -> Node {
    let present = cell.present();
    let range = if present == [false; 2] { Range::EMPTY } else { Range::of(heights) };
    Node { range, has_hole: present != [true; 2] }
}

fn pyramid(columns: usize, rows: usize, heights: &[f32], cells: &[HeightFieldCell]) -> Pyramid {
    let has_holes = cells.iter().any(|cell| cell.present() != [true; 2]);
    Pyramid::new(columns - 1, rows - 1, has_holes, |column, row| {
        let index = row * columns + column;
        let below = index + columns;
        let four = [heights[index], heights[index + 1], heights[below], heights[below + 1]];
        let cell = cells.get(row * (columns - 1) + column).copied().unwrap_or_default();
        cell_node(four, cell)
    })
}
