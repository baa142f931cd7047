//! The nearest place of the ground's surface.
//!
//! From outside, that is the nearest place of the solid; from inside, the nearest place of what is not solid.
//! Either is made of upright columns, over triangles or triangles taken away, and the nearest place of many
//! columns is that of the nearest one. In ground without holes all that counts of a column is its triangle, and of
//! the border the place that is nearest seen from above.

use super::column::Column;
use super::triangle::{Corner, Foot};
use super::{HeightField, larger};
use crate::sdf::SdfSample;
use crate::sdf::shapes::{length_and_direction, smaller};

/// What has been found up to now.
pub struct Search<'a> {
    field: &'a HeightField,
    point: [f32; 3],
    is_inside: bool,
    /// Square of the distance to the nearest place.
    least: f32,
    /// From the point to that place.
    way: [f32; 3],
    /// Direction out of the solid there.
    outward: [f32; 3],
    /// Whether that is the normal, and not the way: over a face, and where the way is too short to tell.
    is_face: bool,
}

impl<'a> Search<'a> {
    /// The distance and the normal at a point of finite coordinates.
    pub fn run(field: &'a HeightField, point: [f32; 3]) -> SdfSample {
        let at = field.column_at(point);
        let is_over_floor = point[1] > field.floor;
        let mut search = Self {
            field,
            point,
            is_inside: at.is_within && at.is_present && at.above < 0.0 && is_over_floor,
            least: f32::INFINITY,
            way: [f32::INFINITY; 3],
            outward: [0.0, 1.0, 0.0],
            is_face: true,
        };
        if search.is_inside {
            search.look_at_border_from_inside();
        } else if !field.has_holes {
            search.look_at_border_from_outside(&at);
        }
        // The cell below is mostly the nearest one, or shows how near the nearest one is.
        let known = [at.column, at.row];
        search.look_at_cell(known);
        search.look_around(known);
        search.sample()
    }

    fn sample(&self) -> SdfSample {
        let [x, y, z] = self.outward;
        let (_, normal) = length_and_direction([x, y, z], [0.0, 1.0, 0.0]);
        let distance = self.least.sqrt();
        let distance = if self.is_inside { -distance } else { distance };
        if self.is_face {
            return SdfSample { distance, normal: normal.into() };
        }
        let out = if self.is_inside { self.way } else { self.way.map(|w| -w) };
        let (_, normal) = length_and_direction(out, normal);
        SdfSample { distance, normal: normal.into() }
    }

    fn take(&mut self, foot: Foot, outward: [f32; 3]) {
        if foot.squared < self.least {
            self.least = foot.squared;
            (self.way, self.is_face, self.outward) = (foot.way, foot.is_face, outward);
        }
    }

    fn take_way(&mut self, way: [f32; 3], outward: [f32; 3]) {
        let squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        self.take(Foot { squared, way, is_face: false }, outward);
    }

    fn look_at_border_from_inside(&mut self) {
        let [x, y, z] = self.point;
        let [half_x, half_z] = self.field.size.map(|side| 0.5 * side);
        let (side_x, side_z) = (1_f32.copysign(x), 1_f32.copysign(z));
        self.take_way([half_x.copysign(x) - x, 0.0, 0.0], [side_x, 0.0, 0.0]);
        self.take_way([0.0, 0.0, half_z.copysign(z) - z], [0.0, 0.0, side_z]);
        self.take_way([0.0, self.field.floor - y, 0.0], [0.0, -1.0, 0.0]);
    }

    fn look_at_border_from_outside(&mut self, at: &Column) {
        // Higher up, it is the upper end of a wall, which is a side of a triangle.
        if at.above > 0.0 {
            return;
        }
        let [x, y, z] = self.point;
        let (way_x, way_z) = (at.place[0] - x, at.place[1] - z);
        let outward = if at.is_within { [0.0, -1.0, 0.0] } else { [-way_x, 0.0, -way_z] };
        self.take_way([way_x, larger(self.field.floor - y, 0.0), way_z], outward);
    }

    fn look_at_cell(&mut self, [column, row]: [usize; 2]) {
        let present = self.field.cell_at(column, row).present();
        let triangles = self.field.triangles(column, row, self.point);
        for (triangle, is_present) in triangles.iter().zip(present) {
            if is_present && let Some(foot) = triangle.nearest(self.least) {
                self.take(foot, triangle.normal());
            }
            // A triangle is taken away where there is a hole. Without any, the border has been looked at.
            if self.field.has_holes && is_present != self.is_inside {
                self.look_at_walls(triangle);
            }
        }
    }

    /// The upright sides of a triangle's column, and its end at the floor.
    fn look_at_walls(&mut self, triangle: &Corner) {
        let to_floor = larger(self.field.floor - self.point[1], 0.0);
        for wall in triangle.walls() {
            // Seen from inside, the column is a hole, and ends nowhere.
            if self.is_inside {
                let [x, _, z] = wall.outward;
                self.take(wall.foot(0.0), [-x, 0.0, -z]);
            } else if wall.above <= 0.0 {
                self.take(wall.foot(to_floor), wall.outward);
            }
        }
        if self.point[1] <= self.field.floor && triangle.is_over(0.0, 0.0) {
            self.take_way([0.0, to_floor, 0.0], [0.0, -1.0, 0.0]);
        }
    }

    /// Everything that may be nearer than what is known, but for one cell.
    fn look_around(&mut self, known: [usize; 2]) {
        let [columns, rows] = [0, 1].map(|axis| self.cells_within_reach(axis));
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
        if self.squared_gap(level, square) >= self.least {
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

    /// First and last cell along an axis that may be as near as what is known.
    fn cells_within_reach(&self, axis: usize) -> [usize; 2] {
        let last = self.field.last(axis) - 1;
        // A few roundings each of the distance and of the cell's number.
        let reach = 1.000_001 * self.least.sqrt();
        let room = 4e-7 * (last + 1) as f32;
        let at = self.point[2 * axis];
        let cell = |place: f32, room: f32| self.field.cell_coordinate(axis, place) + room;
        // Casting puts what is below zero there, and what is infinite at the end.
        let low = (cell(at - reach, -room) as usize).min(last);
        let high = (cell(at + reach, room) as usize).min(last);
        [low, high.max(low)]
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
