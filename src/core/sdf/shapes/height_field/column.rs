//! What is straight above and below a point.

use super::HeightField;

/// The column of the ground that a point is in, or nearest to.
#[derive(Clone, Copy)]
pub struct Column {
    pub column: usize,
    pub row: usize,
    /// The point's x and z, or the nearest ones that the rectangle has.
    pub place: [f32; 2],
    /// Whether these are its own.
    pub is_within: bool,
    /// Whether the triangle there is.
    pub is_present: bool,
    /// How far the point is above the triangle, there.
    pub above: f32,
}

impl HeightField {
    /// A place's cell along an axis, not yet a whole number. Off by a few roundings of the number of cells.
    #[inline(always)]
    pub(super) fn cell_coordinate(&self, axis: usize, place: f32) -> f32 {
        (place / self.size[axis] + 0.5) * self.last(axis) as f32
    }

    #[inline(always)]
    pub(super) fn column_at(&self, point: [f32; 3]) -> Column {
        let [x, y, z] = point;
        let [half_x, half_z] = self.size.map(|side| 0.5 * side);
        // Not `clamp`, which keeps NaN: `height_at` is asked at any place.
        let place = [x.max(-half_x).min(half_x), z.max(-half_z).min(half_z)];
        let is_within = place == [x, z];
        // Casting rounds towards zero, and puts what is below zero there.
        let column = (self.cell_coordinate(0, place[0]) as usize).min(self.columns - 2);
        let row = (self.cell_coordinate(1, place[1]) as usize).min(self.rows - 2);

        let triangles = self.triangles(column, row, [place[0], y, place[1]]);
        let [u, v] = triangles[0].parts(0.0, 0.0);
        let side = usize::from(u + v > 1.0);
        let is_present = self.cell_at(column, row).present()[side];
        Column { column, row, place, is_within, is_present, above: triangles[side].above() }
    }
}
