//! The nearest place of the ground's surface.
//!
//! From outside, that is the nearest place of the solid; from inside, the nearest place of what is not solid.
//! Either is made of upright columns, over triangles or triangles taken away, and the nearest place of many
//! columns is that of the nearest one. In ground without holes all that counts of a column is its triangle, and of
//! the border the place that is nearest seen from above.
//!
//! What a block of points finds in lanes (`block`) has the same bits: it is chosen in the same way.

use super::column::Column;
use super::construct::ROUNDING;
use super::triangle::{Corner, Foot};
use super::{HeightField, larger};
use crate::sdf::SdfSample;
use crate::sdf::shapes::{Kernel, length_and_direction, smaller, to_sample};

/// What has been found up to now.
pub struct Search<'a> {
    field: &'a HeightField,
    point: [f32; 3],
    is_inside: bool,
    nearest: Foot,
    /// Number of the cell where that is. Of places as near as each other it is that of the cell of the least number, so that the order in
    /// which they are looked at does not matter.
    found: usize,
    /// Distance beyond which nothing is nearer, with room for rounding; and the square of it.
    reach: f32,
    reach_squared: f32,
}

/// Distance and normal at a point inside the ground or outside, of which the nearest place is known.
#[inline(always)]
pub fn finish(foot: &Foot, is_inside: bool) -> Kernel {
    let side = if is_inside { -1.0 } else { 1.0 };
    let [x, y, z] = foot.way;
    let (_, upward) = length_and_direction(foot.upward, [0.0, 1.0, 0.0]);
    let (_, away) = length_and_direction([-side * x, -side * y, -side * z], upward);
    let pick = |a: f32, b: f32| if foot.is_face { a } else { b };
    let normal = [pick(upward[0], away[0]), pick(upward[1], away[1]), pick(upward[2], away[2])];
    (side * foot.squared.sqrt(), normal)
}

impl<'a> Search<'a> {
    /// The distance and the normal at a point of finite coordinates.
    pub fn run(field: &'a HeightField, point: [f32; 3]) -> SdfSample {
        let at = field.column_at(point);
        let is_over_floor = point[1] > field.floor;
        let is_over_ground = at.is_within && field.is_ground(&at);
        let mut search = Self {
            field,
            point,
            is_inside: is_over_ground && at.above < 0.0 && is_over_floor,
            nearest: Foot {
                squared: f32::INFINITY,
                way: [f32::INFINITY; 3],
                is_face: true,
                upward: [0.0, 1.0, 0.0],
            },
            found: 0,
            reach: f32::INFINITY,
            reach_squared: f32::INFINITY,
        };
        if search.is_inside {
            search.look_at_border_from_inside();
        } else if !(field.has_holes || at.is_within && is_over_floor) {
            search.look_at_border_from_outside(&at);
        }
        // The cell below is mostly the nearest one, or shows how near the nearest one is.
        let known = [at.column as usize, at.row as usize];
        search.look_at_cell(known);
        search.look_around(known);
        to_sample(finish(&search.nearest, search.is_inside))
    }

    fn take(&mut self, foot: Foot, cell: usize) {
        let (squared, least) = (foot.squared, self.nearest.squared);
        if squared < least || squared == least && cell < self.found {
            (self.nearest, self.found) = (foot, cell);
            self.reach = self.field.reach(squared);
            self.reach_squared = self.reach * self.reach;
        }
    }

    /// Takes a place of a wall or of the floor.
    fn take_way(&mut self, way: [f32; 3], upward: [f32; 3], cell: usize) {
        let squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        self.take(Foot { squared, way, is_face: false, upward }, cell);
    }

    fn look_at_border_from_inside(&mut self) {
        let [x, y, z] = self.point;
        let [half_x, half_z] = self.field.size.map(|side| 0.5 * side);
        let (side_x, side_z) = (1_f32.copysign(x), 1_f32.copysign(z));
        self.take_way([half_x.copysign(x) - x, 0.0, 0.0], [side_x, 0.0, 0.0], 0);
        self.take_way([0.0, 0.0, half_z.copysign(z) - z], [0.0, 0.0, side_z], 0);
        self.take_way([0.0, self.field.floor - y, 0.0], [0.0, -1.0, 0.0], 0);
    }

    fn look_at_border_from_outside(&mut self, at: &Column) {
        // Higher up, it is the upper end of a wall, which is a side of a triangle.
        if at.above > 0.0 {
            return;
        }
        let [x, y, z] = self.point;
        let (way_x, way_z) = (at.place[0] - x, at.place[1] - z);
        let outward = if at.is_within { [0.0, -1.0, 0.0] } else { [-way_x, 0.0, -way_z] };
        self.take_way([way_x, larger(self.field.floor - y, 0.0), way_z], outward, 0);
    }

    fn look_at_cell(&mut self, [column, row]: [usize; 2]) {
        let number = row * self.field.last(0) + column;
        let seen = self.field.seen(column, row, self.point);
        if !self.field.has_holes {
            self.take(seen.nearest(), number);
            return;
        }
        let present = self.field.cell_at(column, row).present();
        for (triangle, is_present) in seen.0.iter().zip(present) {
            if is_present {
                self.take(triangle.nearest(), number);
            }
            // A triangle is taken away where there is a hole. Without any, the border has been looked at.
            if is_present != self.is_inside {
                self.look_at_walls(triangle, number);
            }
        }
    }

    /// The upright sides of a triangle's column, and its end at the floor.
    fn look_at_walls(&mut self, triangle: &Corner, number: usize) {
        let to_floor = larger(self.field.floor - self.point[1], 0.0);
        for wall in triangle.walls() {
            let [x, _, z] = wall.outward;
            // Seen from inside, the column is a hole, and ends nowhere.
            let (up, upward) =
                if self.is_inside { (0.0, [-x, 0.0, -z]) } else { (to_floor, wall.outward) };
            if self.is_inside || wall.above <= 0.0 {
                let (squared, way, is_face) = wall.foot(up);
                self.take(Foot { squared, way, is_face, upward }, number);
            }
        }
        if self.point[1] <= self.field.floor && triangle.is_over(0.0, 0.0) {
            self.take_way([0.0, to_floor, 0.0], [0.0, -1.0, 0.0], number);
        }
    }

    /// Everything that may be nearer than what is known, but for one cell.
    fn look_around(&mut self, known: [usize; 2]) {
        let within = |axis: usize| self.field.cells_within(axis, self.point[2 * axis], self.reach);
        let [columns, rows] = [0, 1].map(|axis| within(axis).map(|cell| cell as usize));
        // Begins with squares so large that two each way hold all of that.
        let mut level = 0;
        let span = |[low, high]: [usize; 2], level: usize| (high >> level) - (low >> level);
        while span(columns, level) > 1 || span(rows, level) > 1 {
            level += 1;
        }
        for row in rows[0] >> level..=rows[1] >> level {
            for column in columns[0] >> level..=columns[1] >> level {
                self.look_into(level, [column, row], known);
            }
        }
    }

    /// A square of cells, unless what is known is nearer. Goes as deep as there are levels, 16 at most.
    fn look_into(&mut self, level: usize, square: [usize; 2], known: [usize; 2]) {
        if self.squared_gap(level, square) > self.reach_squared {
            return;
        }
        let Some(below) = level.checked_sub(1) else {
            if square != known {
                self.look_at_cell(square);
            }
            return;
        };
        let counts = self.field.pyramid.counts(below);
        // The quarter towards the point first, the opposite one last.
        let first = [0, 1].map(|axis| {
            let middle = ((2 * square[axis] + 1) << below).min(self.field.last(axis));
            usize::from(self.point[2 * axis] > self.field.place(axis, middle))
        });
        for flip in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let quarter = [0, 1].map(|axis| 2 * square[axis] + (first[axis] ^ flip[axis]));
            if quarter[0] < counts[0] && quarter[1] < counts[1] {
                self.look_into(below, quarter, known);
            }
        }
    }

    /// Square of the distance to a box around what a square of cells has to look at.
    #[inline(always)]
    fn squared_gap(&self, level: usize, [column, row]: [usize; 2]) -> f32 {
        let field = self.field;
        let [x, y, z] = self.point;
        let across = |axis: usize, index: usize, at: f32| {
            let low = field.place(axis, index << level);
            let high = field.place(axis, ((index + 1) << level).min(field.last(axis)));
            larger(larger(low - at, at - high), 0.0)
        };
        let (gap_x, gap_z) = (across(0, column, x), across(1, row, z));
        let node = field.node(level, column, row);
        let low = if field.has_holes && !self.is_inside {
            // Walls go down to the floor.
            smaller(node.range.low, field.floor)
        } else {
            node.range.low
        };
        let is_open = self.is_inside && node.has_hole;
        let gap_y = if is_open { 0.0 } else { larger(larger(low - y, y - node.range.high), 0.0) };
        gap_x * gap_x + gap_y * gap_y + gap_z * gap_z
    }
}

impl HeightField {
    /// Distance beyond which nothing is as near as the root of `squared`, with room for rounding: some of the distance, and some of the
    /// places of corners.
    #[inline(always)]
    pub(super) fn reach(&self, squared: f32) -> f32 {
        1.000_001 * squared.sqrt() + self.room
    }

    /// First and last cell along an axis that are within a reach.
    #[inline(always)]
    pub(super) fn cells_within(&self, axis: usize, at: f32, reach: f32) -> [u32; 2] {
        // A few roundings of the cell's number.
        let room = ROUNDING * self.count[axis];
        let low = self.cell_number(axis, at - reach, -room);
        let high = self.cell_number(axis, at + reach, room);
        [low, if high > low { high } else { low }]
    }
}
