//! Area-weighted normals of a grid of points.

use bevy_math::Vec3;

/// Vectors side by side, coordinate by coordinate: loops over them become vector instructions.
#[derive(Debug)]
struct Row([Vec<f32>; 3]);

/// Works out the normals of rows and columns of points, a row of cells at a time, in room of its own.
#[derive(Debug)]
pub struct GridNormals {
    /// Points of two rows.
    upper: Row,
    lower: Row,
    /// Twice the vector areas of the cells above and below a row of points, with an empty cell before
    /// and after.
    above: Row,
    below: Row,
    normals: Row,
}

impl Row {
    fn new(len: usize) -> Self {
        Self(core::array::from_fn(|_| vec![0.0; len]))
    }

    fn take(&mut self, points: &[Vec3]) {
        let [x, y, z] = &mut self.0;
        for (((x, y), z), p) in x.iter_mut().zip(y).zip(z).zip(points) {
            (*x, *y, *z) = (p.x, p.y, p.z);
        }
    }

    fn clear(&mut self) {
        self.0.iter_mut().for_each(|axis| axis.fill(0.0));
    }

    fn get(&self, at: usize) -> Vec3 {
        Vec3::new(self.0[0][at], self.0[1][at], self.0[2][at])
    }
}

impl GridNormals {
    /// For rows of so many points; of none where there is no grid to write.
    pub fn new(columns: usize) -> Self {
        let [upper, lower, normals] = core::array::from_fn(|_| Row::new(columns));
        let [above, below] = core::array::from_fn(|_| Row::new(columns + 1));
        Self { upper, lower, above, below, normals }
    }

    /// Writes the normal of every point, given row by row. `places` are where in `out`, in the order of the
    /// points without them.
    ///
    /// A point's normal is the sum over the cells around it of their vector areas, which half the
    /// cross product of a cell's diagonals is, whichever way it is split. Where they cancel it is
    /// +y.
    ///
    /// # Panics
    /// If its rows have no points, there are fewer points than in one, or more than places or than in `out`; or if
    /// a place is beyond that.
    pub fn write(&mut self, points: &[Vec3], places: Option<&[u32]>, out: &mut [[f32; 3]]) {
        let columns = self.normals.0[0].len();
        let rows = points.len() / columns;
        self.below.clear();
        self.lower.take(&points[..columns]);
        for row in 0..rows {
            core::mem::swap(&mut self.above, &mut self.below);
            core::mem::swap(&mut self.upper, &mut self.lower);
            if row + 1 < rows {
                self.lower.take(&points[(row + 1) * columns..(row + 2) * columns]);
                self.cross_cells(columns);
            } else {
                self.below.clear();
            }
            self.add_cells(columns);
            let points = row * columns..(row + 1) * columns;
            match places {
                Some(places) => self.scatter(&places[points], out),
                None => self.copy(&mut out[points]),
            }
        }
    }

    fn copy(&self, out: &mut [[f32; 3]]) {
        for (column, out) in out.iter_mut().enumerate() {
            *out = self.normals.get(column).to_array();
        }
    }

    fn scatter(&self, places: &[u32], out: &mut [[f32; 3]]) {
        for (column, &place) in places.iter().enumerate() {
            out[place as usize] = self.normals.get(column).to_array();
        }
    }

    /// Vector areas of the cells between two rows of points.
    fn cross_cells(&mut self, columns: usize) {
        let (first, last) = (0..columns - 1, 1..columns);
        let [ax, ay, az] = self.upper.0.each_ref().map(|axis| &axis[first.clone()]);
        let [bx, by, bz] = self.upper.0.each_ref().map(|axis| &axis[last.clone()]);
        let [cx, cy, cz] = self.lower.0.each_ref().map(|axis| &axis[first.clone()]);
        let [dx, dy, dz] = self.lower.0.each_ref().map(|axis| &axis[last.clone()]);
        let [x, y, z] = self.below.0.each_mut().map(|axis| &mut axis[last.clone()]);
        // One length for all, so that nothing is checked in the loop.
        let n = columns - 1;
        let corner = |[x, y, z]: [&[f32]; 3], i: usize| Vec3::new(x[i], y[i], z[i]);
        for i in 0..n {
            let diagonal = corner([dx, dy, dz], i) - corner([ax, ay, az], i);
            let antidiagonal = corner([cx, cy, cz], i) - corner([bx, by, bz], i);
            let area = antidiagonal.cross(diagonal);
            (x[i], y[i], z[i]) = (area.x, area.y, area.z);
        }
    }

    /// Normals of the row of points between the two rows of cells.
    fn add_cells(&mut self, columns: usize) {
        let (left, right) = (0..columns, 1..columns + 1);
        let [ax, ay, az] = self.above.0.each_ref().map(|axis| &axis[left.clone()]);
        let [bx, by, bz] = self.above.0.each_ref().map(|axis| &axis[right.clone()]);
        let [cx, cy, cz] = self.below.0.each_ref().map(|axis| &axis[left.clone()]);
        let [dx, dy, dz] = self.below.0.each_ref().map(|axis| &axis[right.clone()]);
        let [x, y, z] = self.normals.0.each_mut().map(|axis| &mut axis[..columns]);
        let cell = |[x, y, z]: [&[f32]; 3], i: usize| Vec3::new(x[i], y[i], z[i]);
        let mut usual = true;
        for i in 0..columns {
            let sum = (cell([ax, ay, az], i) + cell([bx, by, bz], i))
                + (cell([cx, cy, cz], i) + cell([dx, dy, dz], i));
            let square = sum.length_squared();
            usual &= (square > LEAST) & (square < MOST);
            let normal = sum / square.sqrt();
            (x[i], y[i], z[i]) = (normal.x, normal.y, normal.z);
        }
        if usual {
            return;
        }
        for i in 0..columns {
            let sum = (self.above.get(i) + self.above.get(i + 1))
                + (self.below.get(i) + self.below.get(i + 1));
            let normal = unit(sum);
            for (axis, value) in self.normals.0.iter_mut().zip(normal.to_array()) {
                axis[i] = value;
            }
        }
    }
}

/// Squared lengths between these have a square root and an inverse.
const LEAST: f32 = 1e-30;
const MOST: f32 = 1e30;

/// The direction of a vector whose squared length may be too small for a float.
#[inline]
pub(super) fn unit(sum: Vec3) -> Vec3 {
    let square = sum.length_squared();
    if square > LEAST && square < MOST {
        return sum / square.sqrt();
    }
    let largest = sum.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (sum / largest).normalize() } else { Vec3::Y }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(points: &[Vec3], columns: usize) -> Vec<Vec3> {
        let mut out = vec![[f32::NAN; 3]; points.len()];
        GridNormals::new(columns).write(points, None, &mut out);
        // The other way round, from the last to the first.
        let places: Vec<_> = (0..points.len() as u32).rev().collect();
        let mut other = out.clone();
        GridNormals::new(columns).write(points, Some(&places), &mut other);
        other.reverse();
        assert_eq!(out, other);
        out.into_iter().map(Vec3::from_array).collect()
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
