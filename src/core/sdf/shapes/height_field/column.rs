//! What is straight above and below a point.

use super::HeightField;
use crate::sdf::lookup;
use crate::sdf::shapes::{larger, smaller};

/// The column of the ground that a point is in, or nearest to.
#[derive(Clone, Copy)]
pub struct Column {
    pub column: u32,
    pub row: u32,
    /// The point's x and z, or the nearest ones that the rectangle has.
    pub place: [f32; 2],
    /// Whether these are its own.
    pub is_within: bool,
    /// Whether the triangle there is the one of most x.
    pub is_right: bool,
    /// How far the point is above the triangle, there.
    pub above: f32,
}

/// A coordinate, or the one of the rectangle that is nearest to it. NaN becomes one of the rectangle too.
#[inline(always)]
fn held(at: f32, half: f32) -> f32 {
    smaller(half, larger(-half, at))
}

impl HeightField {
    /// The cell that a place is in along an axis, or the one at the end that it is beyond; `room` moves the place by part of a cell.
    /// Off by a few roundings of the number of cells; the first one for what is no number.
    #[inline(always)]
    pub(super) fn cell_number(&self, axis: usize, place: f32, room: f32) -> u32 {
        let count = self.count[axis];
        lookup::place((place / self.size[axis] + 0.5) * count + room, count - 1.0).cell
    }

    #[inline(always)]
    pub(super) fn column_at(&self, point: [f32; 3]) -> Column {
        let [x, y, z] = point;
        let [half_x, half_z] = self.size.map(|side| 0.5 * side);
        let place = [held(x, half_x), held(z, half_z)];
        let is_within = (place[0] == x) & (place[1] == z);
        let column = self.cell_number(0, place[0], 0.0);
        let row = self.cell_number(1, place[1], 0.0);

        let seen = self.seen(column as usize, row as usize, [place[0], y, place[1]]);
        let (is_right, above) = (seen.is_right(), seen.above());
        Column { column, row, place, is_within, is_right, above }
    }
}
