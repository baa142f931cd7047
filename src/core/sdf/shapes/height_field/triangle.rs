//! A triangle over half a cell: its sides from one corner run along x and along z.

/// A triangle by its corner above the cell's right angle; all places as seen from the point that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    pub corner: [f32; 3],
    /// Along x, and up, to the neighbour in x.
    along_x: [f32; 2],
    /// Along z, and up, to the neighbour in z.
    along_z: [f32; 2],
    /// How much it rises along x and along z.
    rise: [f32; 2],
    /// Square of the length of the normal `(-rise, 1, -rise)`.
    normal_squared: f32,
}

/// A place of a triangle, as seen from the point.
#[derive(Clone, Copy)]
pub struct Foot {
    pub squared: f32,
    /// From the point to the place.
    pub way: [f32; 3],
    /// Whether the way is along the triangle's normal, or too short to have a direction of its own.
    pub is_face: bool,
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
    /// The place that is this far up.
    pub fn foot(&self, up: f32) -> Foot {
        let [x, z] = self.way;
        let squared = x * x + up * up + z * z;
        Foot { squared, way: [x, up, z], is_face: squared < SHORT * self.side_squared }
    }
}

impl Corner {
    #[inline(always)]
    pub fn new(corner: [f32; 3], along_x: [f32; 2], along_z: [f32; 2]) -> Self {
        let rise = [along_x[1] / along_x[0], along_z[1] / along_z[0]];
        let normal_squared = 1.0 + rise[0] * rise[0] + rise[1] * rise[1];
        Self { corner, along_x, along_z, rise, normal_squared }
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
        [(x - self.corner[0]) / self.along_x[0], (z - self.corner[2]) / self.along_z[0]]
    }

    /// The place nearest to the point, if it is nearer than the root of `least`.
    #[inline(always)]
    pub fn nearest(&self, least: f32) -> Option<Foot> {
        let above = self.above();
        // The foot of the perpendicular, straight down by so much of the normal.
        let share = above / self.normal_squared;
        let squared = above * share;
        // Not so either where it is no number, which only what overflows gives.
        let is_nearer = squared < least;
        if !is_nearer {
            return None;
        }
        let way = [share * self.rise[0], -share, share * self.rise[1]];
        let [u, v] = self.parts(way[0], way[2]);
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
            return Some(Foot { squared, way, is_face: true });
        }
        // The nearest place is on a side that the foot is beyond, or may be: seen from far, a triangle is small
        // beside the rounding of where it is.
        let [far_x, far_z] = self.parts(0.0, 0.0);
        let room = 1e-6 * (far_x.abs() + far_z.abs());
        let mut nearest: Option<Foot> = None;
        let mut least = least;
        let mut try_side = |is_beyond: bool, [from, to]: [[f32; 3]; 2]| {
            if is_beyond {
                let foot = nearest_on_side(from, to);
                if foot.squared < least {
                    least = foot.squared;
                    nearest = Some(foot);
                }
            }
        };
        let [along_x, along_z, across] = self.sides();
        try_side(v < room, along_x);
        try_side(u < room, along_z);
        try_side(u + v > 1.0 - room, across);
        nearest
    }

    /// Whether the triangle is above or below a place.
    #[inline(always)]
    pub fn is_over(&self, x: f32, z: f32) -> bool {
        let [u, v] = self.parts(x, z);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0
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
fn nearest_on_side(from: [f32; 3], to: [f32; 3]) -> Foot {
    let side = [0, 1, 2].map(|i| to[i] - from[i]);
    let side_squared = side[0] * side[0] + side[1] * side[1] + side[2] * side[2];
    let along = from[0] * side[0] + from[1] * side[1] + from[2] * side[2];
    let part = (-along / side_squared).clamp(0.0, 1.0);
    let way = [0, 1, 2].map(|i| from[i] + part * side[i]);
    let squared = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    Foot { squared, way, is_face: squared < SHORT * side_squared }
}
