//! Looking a field up: the cell, its trilinear interpolant, and what is known beyond the grid.

use super::{
    DistanceField, LANES, PointBlock, SampleBlock, SdfSample, shapes::length_and_direction,
};
use bevy_math::Vec3;

/// `2^23`: a float this large has no fraction left, so adding it rounds, without a call to `floor`.
const ROUNDER: f32 = 8_388_608.0;

/// A coordinate in cells from the first node: which cell, and where in it.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub cell: u32,
    pub fraction: f32,
}

/// Finds the cell along one axis; `last` is the number of the last cell, a whole float.
///
/// Outside the grid it is the border's place; NaN is taken for the first node.
#[inline(always)]
pub(super) fn place(coordinate: f32, last: f32) -> Place {
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

/// The eight nodes of a cell in pairs along x, as they lie in memory: those at steps (0, 0), (1, 0), (0, 1)
/// and (1, 1) along y and z.
type Corners = [[f32; 2]; 4];

/// Distance, and the gradient times the cell size.
///
/// The gradient is the interpolant's own, from the differences that the interpolation needs anyway.
#[inline(always)]
fn interpolate(c: Corners, fx: f32, fy: f32, fz: f32) -> (f32, [f32; 3]) {
    let [[v000, v100], [v010, v110], [v001, v101], [v011, v111]] = c;
    let dx00 = v100 - v000;
    let dx10 = v110 - v010;
    let dx01 = v101 - v001;
    let dx11 = v111 - v011;
    let c00 = v000 + fx * dx00;
    let c10 = v010 + fx * dx10;
    let c01 = v001 + fx * dx01;
    let c11 = v011 + fx * dx11;
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
    row: u32,
    slice: u32,
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
            row: nx,
            slice: nx * ny,
            values: &field.values,
        }
    }

    #[inline(always)]
    fn place(&self, axis: usize, coordinate: f32) -> Place {
        place((coordinate - self.origin[axis]) * self.inverse_cell, self.last[axis])
    }

    /// The first node of a cell. There are fewer than 2^32 nodes.
    #[inline(always)]
    fn first(&self, x: u32, y: u32, z: u32) -> u32 {
        x + y * self.row + z * self.slice
    }

    #[inline(always)]
    fn corners(&self, first: u32) -> Corners {
        // From 32 bits, so that sums of them are known not to overflow, nor to leave the slice below.
        let (first, row, slice) = (first as usize, self.row as usize, self.slice as usize);
        // One check for the cell instead of eight.
        let cell = &self.values[first..][..slice + row + 2];
        let pair = |at: usize| [cell[at], cell[at + 1]];
        [pair(0), pair(row), pair(slice), pair(slice + row)]
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
#[inline(always)]
fn extend(
    field: &DistanceField,
    end: Vec3,
    point: Vec3,
    distance: f32,
    normal: [f32; 3],
) -> (f32, [f32; 3]) {
    // What rounding adds to a far distance is taken off again, so that it stays a lower bound.
    const ROUNDED_DOWN: f32 = 1.0 - 1.0 / (1 << 20) as f32;
    let beyond = beyond(point, field.origin, end);
    let from_grid = (square(beyond) + distance * distance).sqrt();
    let from_surface_box = square(self::beyond(point, field.surface_min, field.surface_max)).sqrt();
    let bound = if from_grid > from_surface_box { from_grid } else { from_surface_box };

    // Away from the surface point that the border's sample tells of.
    let along = |axis: usize| beyond[axis] + distance * normal[axis];
    let (_, away) = length_and_direction([along(0), along(1), along(2)], [0.0, 1.0, 0.0]);
    // A sum of numbers is none where any of them is not.
    let is_nan = (point.x + point.y + point.z).is_nan();
    let pick = |lost: f32, found: f32| if is_nan { lost } else { found };
    let away = [pick(0.0, away[0]), pick(1.0, away[1]), pick(0.0, away[2])];
    (pick(f32::INFINITY, ROUNDED_DOWN * bound), away)
}

/// The way to a point from the nearest one of a box.
#[inline(always)]
fn beyond(point: Vec3, min: Vec3, max: Vec3) -> [f32; 3] {
    let beyond = |at: f32, min: f32, max: f32| {
        let inside = if at > min { at } else { min };
        at - if inside < max { inside } else { max }
    };
    [beyond(point.x, min.x, max.x), beyond(point.y, min.y, max.y), beyond(point.z, min.z, max.z)]
}

#[inline(always)]
fn square([x, y, z]: [f32; 3]) -> f32 {
    x * x + y * y + z * z
}

/// Distance and normal at one point.
#[inline(always)]
pub(super) fn sample(field: &DistanceField, point: Vec3) -> SdfSample {
    let grid = Grid::new(field);
    let (x, y, z) = (grid.place(0, point.x), grid.place(1, point.y), grid.place(2, point.z));
    let corners = grid.corners(grid.first(x.cell, y.cell, z.cell));
    let (distance, gradient) = interpolate(corners, x.fraction, y.fraction, z.fraction);
    let normal = direction(gradient, field.cell_size);
    let end = grid_end(field);
    let (distance, normal) = if is_outside(field, end, point.x, point.y, point.z) {
        extend(field, end, point, distance, normal)
    } else {
        (distance, normal)
    };
    SdfSample { distance, normal: Vec3::from_array(normal) }
}

/// Distance at one point.
#[inline(always)]
pub(super) fn distance(field: &DistanceField, point: Vec3) -> f32 {
    sample(field, point).distance
}

/// Cells and corners of a block of points.
struct Gathered {
    corners: [[[f32; 2]; LANES]; 4],
    fraction: [[f32; LANES]; 3],
    any_outside: bool,
}

#[inline(always)]
fn gather(field: &DistanceField, points: &PointBlock) -> Gathered {
    let grid = Grid::new(field);
    let end = grid_end(field);
    let mut cell = [[0_u32; LANES]; 3];
    let mut gathered = Gathered {
        corners: [[[0.0; 2]; LANES]; 4],
        fraction: [[0.0; LANES]; 3],
        any_outside: false,
    };
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
    let mut first = [0_u32; LANES];
    for (i, first) in first.iter_mut().enumerate() {
        *first = grid.first(cell[0][i], cell[1][i], cell[2][i]);
    }
    for (i, first) in first.into_iter().enumerate() {
        for (to, pair) in gathered.corners.iter_mut().zip(grid.corners(first)) {
            to[i] = pair;
        }
    }
    gathered
}

impl Gathered {
    #[inline(always)]
    fn interpolate(&self, i: usize) -> (f32, [f32; 3]) {
        let corners = self.corners.each_ref().map(|pairs| pairs[i]);
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

/// Extends the lanes that are outside the grid. All are worked out: a block is often wider than a grid's margin.
#[inline(always)]
fn extend_lanes(field: &DistanceField, points: &PointBlock, out: &mut SampleBlock) {
    let end = grid_end(field);
    for i in 0..LANES {
        let point = Vec3::new(points.x[i], points.y[i], points.z[i]);
        let (distance, normal) = (out.distance[i], [out.nx[i], out.ny[i], out.nz[i]]);
        let (far, away) = extend(field, end, point, distance, normal);
        let outside = is_outside(field, end, point.x, point.y, point.z);
        let pick = |far: f32, near: f32| if outside { far } else { near };
        let normal = [pick(away[0], normal[0]), pick(away[1], normal[1]), pick(away[2], normal[2])];
        out.set(i, pick(far, distance), normal);
    }
}
