//! The two triangles over a cell, without branches: the sides of each run from one corner along x and along z.

use crate::sdf::shapes::{larger, smaller};

/// A cell by its two triangles, that of least x first; all places as seen from the point that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Cell(pub [Corner; 2]);

impl Cell {
    /// A cell from one place to another along x and along z, with the heights at the corners: two of least z, then two of most z,
    /// those of least x first. See [`HeightFieldCell`](super::HeightFieldCell) for how it is divided.
    #[inline(always)]
    pub fn new(x: [f32; 2], z: [f32; 2], heights: [f32; 4], zigzag: bool, point: [f32; 3]) -> Self {
        // Divided the other way, it is a cell of which z goes backwards.
        let pick = |a: f32, b: f32| if zigzag { a } else { b };
        let [a, b, c, d] = heights;
        let z = [pick(z[1], z[0]), pick(z[0], z[1])];
        let [a, b, c, d] = [pick(c, a), pick(d, b), pick(a, c), pick(b, d)];
        // The sides are taken before the point: from far away, their ends are the same.
        let along = [x[1] - x[0], z[1] - z[0]];
        let inverse = [1.0 / along[0], 1.0 / along[1]];
        let corner = [x[0] - point[0], a - point[1], z[0] - point[2]];
        let opposite = [x[1] - point[0], d - point[1], z[1] - point[2]];
        let (back, inverse_back) = ([-along[0], -along[1]], [-inverse[0], -inverse[1]]);
        Self([
            Corner::new(corner, along, [b - a, c - a], inverse),
            Corner::new(opposite, back, [c - d, b - d], inverse_back),
        ])
    }

    /// How far the point is above the triangle that is straight below it, or would be.
    #[inline(always)]
    pub fn above(&self) -> f32 {
        let [left, right] = &self.0;
        let (above_left, above_right) = (left.above(), right.above());
        if self.is_right() { above_right } else { above_left }
    }

    /// Whether the triangle that is straight above or below the point is the one of most x.
    #[inline(always)]
    pub fn is_right(&self) -> bool {
        let [u, v] = self.0[0].parts(0.0, 0.0);
        u + v > 1.0
    }

    /// The place nearest to the point.
    #[inline(always)]
    pub fn nearest(&self) -> Foot {
        let [left, right] = &self.0;
        let ([left_x, left_z, across], [right_x, right_z, _]) = (left.sides(), right.sides());
        let left_beside = nearer(left.side(left_x), left.side(left_z));
        let right_beside = nearer(right.side(right_x), right.side(right_z));
        let left = left.or_over(nearer(left_beside, left.side(across)));
        nearer(left, right.or_over(right_beside))
    }
}

/// A triangle by its corner above the cell's right angle; all places as seen from the point that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub corner: [f32; 3],
    /// Along x, and up, to the neighbour in x.
    along_x: [f32; 2],
    /// Along z, and up, to the neighbour in z.
    along_z: [f32; 2],
    /// Reciprocals of how far the neighbours are along x and along z.
    inverse: [f32; 2],
    /// How much it rises along x and along z.
    rise: [f32; 2],
    /// Square of the length of the normal `(-rise, 1, -rise)`.
    normal_squared: f32,
}

/// A place of the ground, as seen from the point.
#[derive(Clone, Copy)]
pub struct Foot {
    pub squared: f32,
    /// From the point to the place.
    pub way: [f32; 3],
    /// Whether the way is along the triangle's normal, or too short to have a direction of its own.
    pub is_face: bool,
    /// The upward normal there, not of unit length.
    pub upward: [f32; 3],
}

/// A side of a triangle's column, where it is nearest to the point as seen from above.
#[derive(Clone, Copy)]
pub struct Wall {
    /// From the point, along x and z.
    way: [f32; 2],
    /// Square of the side's length.
    side_squared: f32,
    /// How far the point is above the triangle's side there.
    pub above: f32,
    /// Away from the triangle, not of unit length.
    pub outward: [f32; 3],
}

/// Square of the part of a side below which a way is as long as its rounding.
const SHORT: f32 = 1e-10;

impl Wall {
    /// The square of the distance to the place that is this far up, the way, and whether that is too short to have a direction.
    pub fn foot(&self, up: f32) -> (f32, [f32; 3], bool) {
        let [x, z] = self.way;
        let squared = x * x + up * up + z * z;
        (squared, [x, up, z], squared < SHORT * self.side_squared)
    }
}

impl Corner {
    /// The triangle between a corner and its neighbours, which are so far along x and along z, and so far up; with one over how far
    /// along.
    #[inline(always)]
    fn new(corner: [f32; 3], along: [f32; 2], up: [f32; 2], inverse: [f32; 2]) -> Self {
        let (along_x, along_z) = ([along[0], up[0]], [along[1], up[1]]);
        let rise = [up[0] * inverse[0], up[1] * inverse[1]];
        let normal_squared = 1.0 + rise[0] * rise[0] + rise[1] * rise[1];
        Self { corner, along_x, along_z, inverse, rise, normal_squared }
    }

    /// The upward normal, not of unit length.
    pub fn normal(&self) -> [f32; 3] {
        [-self.rise[0], 1.0, -self.rise[1]]
    }

    /// How much the triangle rises in its steepest direction.
    pub fn steepness(&self) -> f32 {
        (self.rise[0] * self.rise[0] + self.rise[1] * self.rise[1]).sqrt()
    }

    /// How far the point is above the triangle's plane, straight down.
    #[inline(always)]
    pub fn above(&self) -> f32 {
        self.rise[0] * self.corner[0] + self.rise[1] * self.corner[2] - self.corner[1]
    }

    /// How far a place is along the sides, from the corner: both from zero, and at most one together, over the
    /// triangle.
    #[inline(always)]
    pub fn parts(&self, x: f32, z: f32) -> [f32; 2] {
        [(x - self.corner[0]) * self.inverse[0], (z - self.corner[2]) * self.inverse[1]]
    }

    /// The place nearest to the point.
    pub fn nearest(&self) -> Foot {
        let [along_x, along_z, across] = self.sides();
        let beside = nearer(self.side(along_x), self.side(along_z));
        self.or_over(nearer(beside, self.side(across)))
    }

    /// The nearest place of a side.
    #[inline(always)]
    fn side(&self, side: [[f32; 3]; 2]) -> Foot {
        nearest_on_side(side, self.normal())
    }

    /// The foot of the perpendicular where that is within the triangle, and what is nearest at its sides elsewhere.
    #[inline(always)]
    fn or_over(&self, beside: Foot) -> Foot {
        let above = self.above();
        // Straight down by so much of the normal.
        let share = above / self.normal_squared;
        let way = [share * self.rise[0], -share, share * self.rise[1]];
        let is_within = self.is_over(way[0], way[2]);
        let squared = above * share;
        pick(is_within, Foot { squared, way, is_face: true, upward: self.normal() }, beside)
    }

    /// Whether the triangle is above or below a place.
    #[inline(always)]
    pub fn is_over(&self, x: f32, z: f32) -> bool {
        let [u, v] = self.parts(x, z);
        (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    }

    /// The upright sides of the column that the triangle is the end of.
    pub fn walls(&self) -> [Wall; 3] {
        // A third of the way along both sides is within.
        let middle_x = self.corner[0] + self.along_x[0] / 3.0;
        let middle_z = self.corner[2] + self.along_z[0] / 3.0;
        self.sides().map(|[from, to]| {
            let [x, y, z] = [0, 1, 2].map(|i| to[i] - from[i]);
            let side_squared = x * x + z * z;
            let part = (-(from[0] * x + from[2] * z) / side_squared).clamp(0.0, 1.0);
            let is_out = z * (from[0] - middle_x) - x * (from[2] - middle_z) > 0.0;
            Wall {
                way: [from[0] + part * x, from[2] + part * z],
                side_squared,
                above: -(from[1] + part * y),
                outward: if is_out { [z, 0.0, -x] } else { [-z, 0.0, x] },
            }
        })
    }

    /// The sides along x, along z, and the diagonal.
    #[inline(always)]
    fn sides(&self) -> [[[f32; 3]; 2]; 3] {
        let [x, y, z] = self.corner;
        let in_x = [x + self.along_x[0], y + self.along_x[1], z];
        let in_z = [x, y + self.along_z[1], z + self.along_z[0]];
        [[self.corner, in_x], [self.corner, in_z], [in_x, in_z]]
    }
}

/// The place between two that is nearest to the point, which is the origin.
#[inline(always)]
fn nearest_on_side([from, to]: [[f32; 3]; 2], upward: [f32; 3]) -> Foot {
    let side = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let side_squared = side[0] * side[0] + side[1] * side[1] + side[2] * side[2];
    let along = from[0] * side[0] + from[1] * side[1] + from[2] * side[2];
    let part = smaller(larger(-along / side_squared, 0.0), 1.0);
    let way = [from[0] + part * side[0], from[1] + part * side[1], from[2] + part * side[2]];
    let squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    Foot { squared, way, is_face: squared < SHORT * side_squared, upward }
}

/// The first of two that is no further.
#[inline(always)]
fn nearer(a: Foot, b: Foot) -> Foot {
    pick(b.squared < a.squared, b, a)
}

#[inline(always)]
fn pick(which: bool, a: Foot, b: Foot) -> Foot {
    let pick = |a: f32, b: f32| if which { a } else { b };
    let each = |a: [f32; 3], b: [f32; 3]| [pick(a[0], b[0]), pick(a[1], b[1]), pick(a[2], b[2])];
    Foot {
        squared: pick(a.squared, b.squared),
        way: each(a.way, b.way),
        is_face: (which & a.is_face) | (!which & b.is_face),
        upward: each(a.upward, b.upward),
    }
}
