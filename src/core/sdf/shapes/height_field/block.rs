//! The nearest places of ground to a block of points, in lanes.
//!
//! Each lane looks at the cell that its point is above or below, which shows how near the nearest place is, and then at the
//! cells within that reach. The points of a block that are far from the ground, beside it or below its floor are left to the
//! search of one point, and so are those of ground with holes.
//!
//! A lane has the bits of that search (`nearest`). Both look at all cells within one and the same reach, and of places that are as near
//! as each other both take that of the cell of the least number.

use super::HeightField;
use super::nearest::finish;
use super::triangle::{Cell, Foot};
use crate::sdf::shapes::{larger, smaller};
use crate::sdf::{LANES, PointBlock, SampleBlock, SignedDistance};

/// Cells beside the first one within a point's reach, along an axis, that are still looked at in lanes.
const MOST_BESIDE: u32 = 3;

/// Cells along x and z, a lane each.
#[derive(Clone, Copy)]
struct Cells {
    column: [u32; LANES],
    row: [u32; LANES],
}

/// The nearest places, as far as they are known.
struct Nearest<'a> {
    field: &'a HeightField,
    points: &'a PointBlock,
    squared: [f32; LANES],
    way: [[f32; LANES]; 3],
    /// First and third component of the normal there, upwards; the second one is one.
    upward: [[f32; LANES]; 2],
    is_face: [bool; LANES],
    /// The cells' numbers.
    found: [u32; LANES],
    /// How far the points are above the ground.
    above: [f32; LANES],
    /// Lanes that are to be searched on their own have a one, others a zero. They are numbers, so that lanes of all are as wide.
    alone: [u32; LANES],
}

/// Distances and normals of a [`HeightField`] at a block of points: what its `sample_block` does, inlined.
#[inline(always)]
pub fn height_field_block(field: &HeightField, points: &PointBlock, out: &mut SampleBlock) {
    let mut alone = [1; LANES];
    if !field.has_holes {
        let nearest = Nearest::search(field, points);
        alone = nearest.alone;
        for i in 0..LANES {
            let (distance, normal) = finish(&nearest.foot(i), nearest.above[i] < 0.0);
            out.set(i, distance, normal);
        }
    }
    for (i, is_alone) in alone.into_iter().enumerate() {
        if is_alone != 0 {
            let sample = field.sample(points.point(i));
            out.set(i, sample.distance, sample.normal.to_array());
        }
    }
}

/// Distances alone \[m\] of a [`HeightField`] at a block of points, inlined.
#[inline(always)]
pub fn height_field_distance_block(
    field: &HeightField,
    points: &PointBlock,
    out: &mut [f32; LANES],
) {
    let mut alone = [1; LANES];
    if !field.has_holes {
        let nearest = Nearest::search(field, points);
        alone = nearest.alone;
        for (i, out) in out.iter_mut().enumerate() {
            let distance = nearest.squared[i].sqrt();
            *out = if nearest.above[i] < 0.0 { -distance } else { distance };
        }
    }
    for (i, is_alone) in alone.into_iter().enumerate() {
        if is_alone != 0 {
            out[i] = field.distance(points.point(i));
        }
    }
}

impl<'a> Nearest<'a> {
    /// Ground without holes.
    #[inline(always)]
    fn search(field: &'a HeightField, points: &'a PointBlock) -> Self {
        let mut nearest = Self {
            field,
            points,
            squared: [f32::INFINITY; LANES],
            way: [[0.0; LANES]; 3],
            upward: [[0.0; LANES]; 2],
            is_face: [true; LANES],
            found: [0; LANES],
            above: [0.0; LANES],
            alone: [0; LANES],
        };
        let own = nearest.columns();
        nearest.look_at(&own, true);
        nearest.look_around(&own);
        nearest
    }

    #[inline(always)]
    fn foot(&self, lane: usize) -> Foot {
        Foot {
            squared: self.squared[lane],
            way: [self.way[0][lane], self.way[1][lane], self.way[2][lane]],
            is_face: self.is_face[lane],
            upward: [self.upward[0][lane], 1.0, self.upward[1][lane]],
        }
    }

    /// The cells above or below the points. Points that are beside the rectangle or not above the floor are searched alone.
    #[inline(always)]
    fn columns(&mut self) -> Cells {
        let mut own = Cells { column: [0; LANES], row: [0; LANES] };
        let [half_x, half_z] = self.field.size.map(|side| 0.5 * side);
        let (field, points) = (self.field, self.points);
        let mut alone = [0; LANES];
        for (i, alone) in alone.iter_mut().enumerate() {
            let (x, y, z) = (points.x[i], points.y[i], points.z[i]);
            own.column[i] = field.cell_number(0, x, 0.0);
            own.row[i] = field.cell_number(1, z, 0.0);
            let is_within = (x >= -half_x) & (x <= half_x) & (z >= -half_z) & (z <= half_z);
            *alone = u32::from(!(is_within & (y > field.floor)));
        }
        self.alone = alone;
        own
    }

    /// Takes the nearest places of cells, one a lane, where they are nearer than what is known, or as near and of a cell of a
    /// lower number. Where `is_own`, cells are those below or above the points, and tell how far these are above the ground.
    #[inline(always)]
    fn look_at(&mut self, cells: &Cells, is_own: bool) {
        let field = self.field;
        let mut heights = [[0.0; LANES]; 4];
        let mut zigzag = [false; LANES];
        for i in 0..LANES {
            let (column, row) = (cells.column[i] as usize, cells.row[i] as usize);
            let of_cell = field.corner_heights(column, row);
            for (heights, height) in heights.iter_mut().zip(of_cell) {
                heights[i] = height;
            }
        }
        if !field.cells.is_empty() {
            for (i, zigzag) in zigzag.iter_mut().enumerate() {
                let (column, row) = (cells.column[i] as usize, cells.row[i] as usize);
                *zigzag = field.cell_at(column, row).zigzag;
            }
        }
        let [mut squared, mut above] = [[0.0; LANES]; 2];
        let mut way = [[0.0; LANES]; 3];
        let mut upward = [[0.0; LANES]; 2];
        let mut is_face = [false; LANES];
        for i in 0..LANES {
            let (column, row) = (cells.column[i] as i32, cells.row[i] as i32);
            let x = [field.place_of(0, column as f32), field.place_of(0, (column + 1) as f32)];
            let z = [field.place_of(1, row as f32), field.place_of(1, (row + 1) as f32)];
            let heights = [heights[0][i], heights[1][i], heights[2][i], heights[3][i]];
            let point = [self.points.x[i], self.points.y[i], self.points.z[i]];
            let cell = Cell::new(x, z, heights, zigzag[i], point);
            let foot = cell.nearest();
            above[i] = cell.above();
            squared[i] = foot.squared;
            (way[0][i], way[1][i], way[2][i]) = (foot.way[0], foot.way[1], foot.way[2]);
            (upward[0][i], upward[1][i]) = (foot.upward[0], foot.upward[2]);
            is_face[i] = foot.is_face;
        }
        let columns = field.columns as u32 - 1;
        for i in 0..LANES {
            let (least, known) = (self.squared[i], self.found[i]);
            let number = cells.row[i].wrapping_mul(columns).wrapping_add(cells.column[i]);
            let takes = (squared[i] < least) | ((squared[i] == least) & (number < known));
            let pick = |new: f32, old: f32| if takes { new } else { old };
            self.squared[i] = pick(squared[i], least);
            self.found[i] = if takes { number } else { known };
            self.is_face[i] = (takes & is_face[i]) | (!takes & self.is_face[i]);
            for (old, new) in self.way.iter_mut().zip(&way) {
                old[i] = pick(new[i], old[i]);
            }
            for (old, new) in self.upward.iter_mut().zip(&upward) {
                old[i] = pick(new[i], old[i]);
            }
        }
        if is_own {
            self.above = above;
        }
    }

    /// The cells that hold what may be nearer than what is known: the first ones along x and z, and how many come after these. Lanes for
    /// which that is not all, or which have too many, are to be searched alone, and have none.
    #[inline(always)]
    fn within_reach(&mut self) -> (Cells, Cells) {
        let (field, points) = (self.field, self.points);
        let (squared, above, mut alone) = (self.squared, self.above, self.alone);
        let [mut first, mut after] = [Cells { column: [0; LANES], row: [0; LANES] }; 2];
        for i in 0..LANES {
            let (x, y, z) = (points.x[i], points.y[i], points.z[i]);
            let reach = field.reach(squared[i]);
            let [low_x, high_x] = field.cells_within(0, x, reach);
            let [low_z, high_z] = field.cells_within(1, z, reach);
            let [across, along] = [high_x - low_x, high_z - low_z];
            // From inside, the border is a way out too.
            let beside = smaller(0.5 * field.size[0] - x.abs(), 0.5 * field.size[1] - z.abs());
            let to_border = smaller(beside, y - field.floor);
            let is_near_border = (above[i] < 0.0) & (to_border <= reach);
            let is_many = (across > MOST_BESIDE) | (along > MOST_BESIDE);
            let is_unknown = squared[i] == f32::INFINITY;
            alone[i] |= u32::from(is_near_border | is_many | is_unknown);
            (first.column[i], first.row[i]) = (low_x, low_z);
            (after.column[i], after.row[i]) = (across, along);
        }
        for (i, alone) in alone.iter().enumerate() {
            let together = 1 - alone;
            after.column[i] *= together;
            after.row[i] *= together;
        }
        self.alone = alone;
        (first, after)
    }

    /// Everything that may be nearer than what is known of the own cells.
    #[inline(always)]
    fn look_around(&mut self, own: &Cells) {
        let field = self.field;
        let (first, after) = self.within_reach();
        let most = |counts: &[u32; LANES]| counts.iter().fold(0, |most, &count| most.max(count));
        for down in 0..=most(&after.row) {
            for right in 0..=most(&after.column) {
                let mut cells = *own;
                let mut any = [0; LANES];
                let squared = self.squared;
                for i in 0..LANES {
                    let is_wanted = (right <= after.column[i]) & (down <= after.row[i]);
                    let (own_column, own_row) = (own.column[i], own.row[i]);
                    let column = turn(own_column, first.column[i], after.column[i], right);
                    let row = turn(own_row, first.row[i], after.row[i], down);
                    cells.column[i] = if is_wanted { column } else { own_column };
                    cells.row[i] = if is_wanted { row } else { own_row };
                    let gap_x = field.gap_along(0, column, self.points.x[i]);
                    let gap_z = field.gap_along(1, row, self.points.z[i]);
                    let reach = field.reach(squared[i]);
                    let is_near = gap_x * gap_x + gap_z * gap_z <= reach * reach;
                    any[i] = u32::from(is_wanted & is_near);
                }
                let is_any = any.into_iter().fold(0, |all, any| all | any) != 0;
                if is_any && (down, right) != (0, 0) {
                    self.look_at(&cells, false);
                }
            }
        }
    }
}

/// The cell that is some steps from the own one along an axis. After the last comes the first, so that a neighbour on either side is
/// one step away.
#[inline(always)]
fn turn(own: u32, first: u32, after: u32, steps: u32) -> u32 {
    let cell = own + steps;
    if cell > first + after { cell.wrapping_sub(after + 1) } else { cell }
}

impl HeightField {
    /// How far a place is from a cell, along x or along z (`axis` zero and one).
    #[inline(always)]
    fn gap_along(&self, axis: usize, cell: u32, at: f32) -> f32 {
        let low = self.place_of(axis, cell as i32 as f32);
        let high = self.place_of(axis, (cell as i32 + 1) as f32);
        larger(larger(low - at, at - high), 0.0)
    }
}
