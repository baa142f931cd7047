//! Area-weighted normals of a grid of points.

use bevy::math::Vec3;

/// The cross products of a row of cells, with an empty cell before and after.
#[derive(Default)]
pub(super) struct CellRows {
    above: Vec<Vec3>,
    below: Vec<Vec3>,
}

impl CellRows {
    pub fn new(columns: usize) -> Self {
        Self { above: vec![Vec3::ZERO; columns + 1], below: vec![Vec3::ZERO; columns + 1] }
    }

    /// Calls `write` with the normal of every point of a grid, row by row.
    ///
    /// A point's normal is the sum over the cells around it of their vector areas, which half the
    /// cross product of a cell's diagonals is, whichever way it is split. Where they cancel it is
    /// +y.
    pub fn write_normals(
        &mut self,
        points: &[Vec3],
        columns: usize,
        mut write: impl FnMut(usize, Vec3),
    ) {
        let rows = points.len() / columns;
        self.below.fill(Vec3::ZERO);
        for row in 0..rows {
            core::mem::swap(&mut self.above, &mut self.below);
            if row + 1 < rows {
                let (upper, lower) = points[row * columns..(row + 2) * columns].split_at(columns);
                for column in 1..columns {
                    let diagonal = lower[column] - upper[column - 1];
                    let antidiagonal = lower[column - 1] - upper[column];
                    self.below[column] = antidiagonal.cross(diagonal);
                }
            } else {
                self.below.fill(Vec3::ZERO);
            }
            for column in 0..columns {
                let sum = (self.above[column] + self.above[column + 1])
                    + (self.below[column] + self.below[column + 1]);
                write(row * columns + column, unit(sum));
            }
        }
    }
}

/// The direction of a vector whose squared length may be too small for a float.
#[inline]
pub(super) fn unit(sum: Vec3) -> Vec3 {
    let square = sum.length_squared();
    if square > 1e-30 && square < 1e30 {
        return sum / square.sqrt();
    }
    let largest = sum.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (sum / largest).normalize() } else { Vec3::Y }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(points: &[Vec3], columns: usize) -> Vec<Vec3> {
        let mut out = vec![Vec3::NAN; points.len()];
        CellRows::new(columns).write_normals(points, columns, |at, normal| out[at] = normal);
        out
    }

    fn grid(rows: usize, columns: usize, place: impl Fn(f32, f32) -> Vec3) -> Vec<Vec3> {
        (0..rows * columns).map(|i| place((i % columns) as f32, (i / columns) as f32)).collect()
    }

    #[test]
    fn flat_sheets_face_up() {
        for normal in normals(&grid(3, 4, |x, z| Vec3::new(x, 0.0, 2.0 * z)), 4) {
            assert_eq!(normal, Vec3::Y);
        }
    }

    #[test]
    fn a_cylinder_has_radial_normals() {
        let at = |angle: f32| Vec3::new(angle.sin(), angle.cos(), 0.0);
        let points = grid(5, 41, |u, v| at((u - 20.0) * 0.05) + Vec3::Z * v);
        for (i, normal) in normals(&points, 41).into_iter().enumerate() {
            let inner = !(i % 41).is_multiple_of(40);
            let radial = at(((i % 41) as f32 - 20.0) * 0.05);
            // The border has cells on one side only, half a step off.
            assert!(normal.angle_between(radial) < if inner { 1e-3 } else { 0.026 });
        }
    }

    #[test]
    fn larger_cells_weigh_more() {
        // A ridge with a slope of area 3 on one side and of area 1 on the other, both at 45
        // degrees.
        let points = grid(2, 3, |u, v| match u as i32 {
            0 => Vec3::new(-3.0, -3.0, v),
            1 => Vec3::new(0.0, 0.0, v),
            _ => Vec3::new(1.0, -1.0, v),
        });
        let expected = (Vec3::new(-1.0, 1.0, 0.0) * 3.0 + Vec3::new(1.0, 1.0, 0.0)).normalize();
        assert!(normals(&points, 3)[1].distance(expected) < 1e-6);
    }

    #[test]
    fn tiny_and_collapsed_cells_have_unit_normals() {
        let tiny = normals(&grid(3, 3, |x, z| Vec3::new(x, 0.0, z) * 1e-12), 3);
        assert!(tiny.iter().all(|n| n.distance(Vec3::Y) < 1e-6));
        let collapsed = normals(&[Vec3::ONE; 9], 3);
        assert!(collapsed.iter().all(|n| *n == Vec3::Y));
    }
}
