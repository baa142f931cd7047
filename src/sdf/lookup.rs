//! Looking a field up: the cell, its trilinear interpolant, and what is known beyond the grid.

use super::{
    DistanceField, LANES, PointBlock, SampleBlock, SdfSample, shapes::length_and_direction,
};
use bevy::math::Vec3;

/// `2^23`: a float this large has no fraction left, so adding it rounds, without a call to `floor`.
const ROUNDER: f32 = 8_388_608.0;

/// A coordinate in cells from the first node: which cell, and where in it.
#[derive(Clone, Copy)]
struct Place {
    cell: u32,
    fraction: f32,
}

/// Finds the cell along one axis; `last` is the number of the last cell, a whole float.
///
/// Outside the grid it is the border's place; NaN is taken for the first node.
#[inline(always)]
fn place(coordinate: f32, last: f32) -> Place {
    let end = last + 1.0;
    let inside = if coordinate > 0.0 { coordinate } else { 0.0 };
    let inside = if inside < end { inside } else { end };
    // Rounding to nearest half a cell lower is rounding down. On a node either neighbour may result,
    // with a fraction of 0 or 1: the interpolant is the same there.
    let lowered = inside - 0.5;
    let rounded = (if lowered > 0.0 { lowered } else { 0.0 }) + ROUNDER;
    let cell = rounded - ROUNDER;
    let cell = if cell < last { cell } else { last };
    Place { cell: (cell + ROUNDER).to_bits() - ROUNDER.to_bits(), fraction: inside - cell }
}

/// The eight nodes of a cell, named by their steps along x, y, z.
#[derive(Clone, Copy)]
struct Corners {
    v000: f32,
    v100: f32,
    v010: f32,
    v110: f32,
    v001: f32,
    v101: f32,
    v011: f32,
    v111: f32,
}

/// Distance, and the gradient times the cell size.
///
/// The gradient is the interpolant's own, from the differences that the interpolation needs anyway.
#[inline(always)]
fn interpolate(c: Corners, fx: f32, fy: f32, fz: f32) -> (f32, [f32; 3]) {
    let dx00 = c.v100 - c.v000;
    let dx10 = c.v110 - c.v010;
    let dx01 = c.v101 - c.v001;
    let dx11 = c.v111 - c.v011;
    let c00 = c.v000 + fx * dx00;
    let c10 = c.v010 + fx * dx10;
    let c01 = c.v001 + fx * dx01;
    let c11 = c.v011 + fx * dx11;
    let dx0 = dx00 + fy * (dx10 - dx00);
    let dx1 = dx01 + fy * (dx11 - dx01);
    let dy0 = c10 - c00;
    let dy1 = c11 - c01;
    let c0 = c00 + fy * dy0;
    let c1 = c01 + fy * dy1;
    let dz = c1 - c0;
    (c0 + fz * dz, [dx0 + fz * (dx1 - dx0), dy0 + fz * (dy1 - dy0), dz])
}

/// The field's numbers in the form that the lookup uses.
struct Grid<'a> {
    origin: [f32; 3],
    inverse_cell: f32,
    last: [f32; 3],
    row: usize,
    slice: usize,
    values: &'a [f32],
}

impl<'a> Grid<'a> {
    #[inline(always)]
    fn new(field: &'a DistanceField) -> Self {
        let [nx, ny, nz] = field.dims.to_array();
        Self {
            origin: field.origin.to_array(),
            inverse_cell: 1.0 / field.cell_size,
            last: [(nx - 2) as f32, (ny - 2) as f32, (nz - 2) as f32],
            row: nx as usize,
            slice: nx as usize * ny as usize,
            values: &field.values,
        }
    }

    #[inline(always)]
    fn place(&self, axis: usize, coordinate: f32) -> Place {
        place((coordinate - self.origin[axis]) * self.inverse_cell, self.last[axis])
    }

    #[inline(always)]
    fn corners(&self, x: u32, y: u32, z: u32) -> Corners {
        let first = x as usize + y as usize * self.row + z as usize * self.slice;
        // One check for the cell instead of eight.
        let cell = &self.values[first..first + self.slice + self.row + 2];
        Corners {
            v000: cell[0],
            v100: cell[1],
            v010: cell[self.row],
            v110: cell[self.row + 1],
            v001: cell[self.slice],
            v101: cell[self.slice + 1],
            v011: cell[self.slice + self.row],
            v111: cell[self.slice + self.row + 1],
        }
    }
}

/// Direction of the interpolant's gradient; up where it is too flat to tell from rounding.
#[inline(always)]
fn direction(gradient: [f32; 3], cell_size: f32) -> [f32; 3] {
    const FLAT: f32 = 1.0e-6;
    let [x, y, z] = gradient;
    let squared = x * x + y * y + z * z;
    let flat = FLAT * cell_size;
    let known = squared >= flat * flat;
    let inverse = 1.0 / squared.sqrt();
    let pick = |component: f32, other: f32| if known { component * inverse } else { other };
    [pick(x, 0.0), pick(y, 1.0), pick(z, 0.0)]
}

/// Whether a point is outside the grid's box, or NaN.
#[inline(always)]
fn is_outside(field: &DistanceField, end: Vec3, x: f32, y: f32, z: f32) -> bool {
    let start = field.origin;
    let inside = (x >= start.x)
        & (x <= end.x)
        & (y >= start.y)
        & (y <= end.y)
        & (z >= start.z)
        & (z <= end.z);
    !inside
}

/// The grid's far corner.
#[inline(always)]
fn grid_end(field: &DistanceField) -> Vec3 {
    field.origin + field.cell_size * (field.dims - 1).as_vec3()
}

/// Extends the border's `distance` and `normal` to a point outside; see [`DistanceField`]'s `sample`.
#[cold]
#[inline(never)]
fn extend(field: &DistanceField, point: Vec3, distance: f32, normal: [f32; 3]) -> SdfSample {
    // What rounding adds to a far distance is taken off again, so that it stays a lower bound.
    const ROUNDED_DOWN: f32 = 1.0 - 1.0 / (1 << 20) as f32;
    if point.is_nan() {
        return SdfSample { distance: f32::INFINITY, normal: Vec3::Y };
    }
    let beyond = point - point.max(field.origin).min(grid_end(field));
    let from_grid = (beyond.length_squared() + distance * distance).sqrt();
    let from_surface_box = (point - point.max(field.surface_min).min(field.surface_max)).length();
    let bound = if from_grid > from_surface_box { from_grid } else { from_surface_box };

    // Away from the surface point that the border's sample tells of.
    let away = beyond + distance * Vec3::from_array(normal);
    let (_, away) = length_and_direction(away.to_array(), [0.0, 1.0, 0.0]);
    SdfSample { distance: ROUNDED_DOWN * bound, normal: Vec3::from_array(away) }
}

/// Distance and normal at one point.
#[inline(always)]
pub(super) fn sample(field: &DistanceField, point: Vec3) -> SdfSample {
    let grid = Grid::new(field);
    let (x, y, z) = (grid.place(0, point.x), grid.place(1, point.y), grid.place(2, point.z));
    let corners = grid.corners(x.cell, y.cell, z.cell);
    let (distance, gradient) = interpolate(corners, x.fraction, y.fraction, z.fraction);
    let normal = direction(gradient, field.cell_size);
    if is_outside(field, grid_end(field), point.x, point.y, point.z) {
        return extend(field, point, distance, normal);
    }
    SdfSample { distance, normal: Vec3::from_array(normal) }
}

/// Distance at one point.
#[inline(always)]
pub(super) fn distance(field: &DistanceField, point: Vec3) -> f32 {
    sample(field, point).distance
}

/// Cells and corners of a block of points.
struct Gathered {
    corners: [[f32; LANES]; 8],
    fraction: [[f32; LANES]; 3],
    any_outside: bool,
}

#[inline(always)]
fn gather(field: &DistanceField, points: &PointBlock) -> Gathered {
    let grid = Grid::new(field);
    let end = grid_end(field);
    let mut cell = [[0_u32; LANES]; 3];
    let mut gathered =
        Gathered { corners: [[0.0; LANES]; 8], fraction: [[0.0; LANES]; 3], any_outside: false };
    for (axis, coordinates) in [&points.x, &points.y, &points.z].into_iter().enumerate() {
        for (i, &coordinate) in coordinates.iter().enumerate() {
            let place = grid.place(axis, coordinate);
            cell[axis][i] = place.cell;
            gathered.fraction[axis][i] = place.fraction;
        }
    }
    let mut outside = 0_u32;
    for i in 0..LANES {
        outside |= u32::from(is_outside(field, end, points.x[i], points.y[i], points.z[i]));
    }
    gathered.any_outside = outside != 0;
    let [x, y, z] = cell;
    for (i, ((x, y), z)) in x.into_iter().zip(y).zip(z).enumerate() {
        let corners = grid.corners(x, y, z);
        gathered.corners[0][i] = corners.v000;
        gathered.corners[1][i] = corners.v100;
        gathered.corners[2][i] = corners.v010;
        gathered.corners[3][i] = corners.v110;
        gathered.corners[4][i] = corners.v001;
        gathered.corners[5][i] = corners.v101;
        gathered.corners[6][i] = corners.v011;
        gathered.corners[7][i] = corners.v111;
    }
    gathered
}

impl Gathered {
    #[inline(always)]
    fn interpolate(&self, i: usize) -> (f32, [f32; 3]) {
        let c = &self.corners;
        let corners = Corners {
            v000: c[0][i],
            v100: c[1][i],
            v010: c[2][i],
            v110: c[3][i],
            v001: c[4][i],
            v101: c[5][i],
            v011: c[6][i],
            v111: c[7][i],
        };
        interpolate(corners, self.fraction[0][i], self.fraction[1][i], self.fraction[2][i])
    }
}

/// Distances and normals of a [`DistanceField`] at a block of points: what its `sample_block` does, inlined.
#[inline(always)]
pub fn field_block(field: &DistanceField, points: &PointBlock, out: &mut SampleBlock) {
    let gathered = gather(field, points);
    let cell_size = field.cell_size;
    for i in 0..LANES {
        let (distance, gradient) = gathered.interpolate(i);
        out.set(i, distance, direction(gradient, cell_size));
    }
    if gathered.any_outside {
        extend_lanes(field, points, out);
    }
}

/// Distances alone \[m\] of a [`DistanceField`] at a block of points, inlined.
#[inline(always)]
pub fn field_distance_block(field: &DistanceField, points: &PointBlock, out: &mut [f32; LANES]) {
    let gathered = gather(field, points);
    if gathered.any_outside {
        let mut samples = SampleBlock::default();
        field_block(field, points, &mut samples);
        *out = samples.distance;
        return;
    }
    for (i, distance) in out.iter_mut().enumerate() {
        *distance = gathered.interpolate(i).0;
    }
}

/// Extends the lanes that are outside the grid.
#[cold]
#[inline(never)]
fn extend_lanes(field: &DistanceField, points: &PointBlock, out: &mut SampleBlock) {
    let end = grid_end(field);
    for i in 0..LANES {
        let point = points.point(i);
        if is_outside(field, end, point.x, point.y, point.z) {
            let normal = [out.nx[i], out.ny[i], out.nz[i]];
            let sample = extend(field, point, out.distance[i], normal);
            out.set(i, sample.distance, sample.normal.to_array());
        }
    }
}
