//! The points of a surface in columns: what a fit goes through again and again, some lanes at a time, so that it is compiled to vectors.

use bevy_math::Vec3;

use super::SurfacePoint;
use crate::sdf::shapes::{CapsuleBetween, larger, smaller};

/// Points side by side.
const LANES: usize = 8;

/// A number for each of a few points side by side.
type Lanes = [f32; LANES];

/// A few points side by side, and the part of the surface that each stands for.
struct Group {
    x: Lanes,
    y: Lanes,
    z: Lanes,
    area: Lanes,
}

/// Points of a surface. The last group is filled up with a point of theirs that stands for nothing.
pub struct Columns {
    groups: Vec<Group>,
    /// Area of the surface.
    pub area: f32,
}

/// The equations by which Gauss and Newton would move a capsule, and what its error is: `normal * step = right`, for both ends and the
/// radius. Of the matrix, what is below the diagonal and on it.
pub struct Equations {
    pub normal: [[f64; 7]; 7],
    pub right: [f64; 7],
}

/// How points lie to a capsule.
struct Apart {
    /// How far they are outside.
    distance: Lanes,
    /// How far along the axis, from 0 to 1.
    part: Lanes,
    /// Which way is out.
    out: [Lanes; 3],
}

impl Columns {
    pub fn new(points: &[SurfacePoint]) -> Self {
        let group = |some: &[SurfacePoint]| {
            let of = |value: fn(&SurfacePoint) -> f32, filler: f32| {
                let mut lanes = [filler; LANES];
                for (lane, it) in lanes.iter_mut().zip(some) {
                    *lane = value(it);
                }
                lanes
            };
            let Vec3 { x, y, z } = some[0].point;
            Group {
                x: of(|it| it.point.x, x),
                y: of(|it| it.point.y, y),
                z: of(|it| it.point.z, z),
                area: of(|it| it.area, 0.0),
            }
        };
        Self {
            groups: points.chunks(LANES).map(group).collect(),
            area: points.iter().map(|it| it.area).sum(),
        }
    }

    /// The mean square of how far they are from a line.
    pub fn mean_square_from_line(&self, middle: Vec3, axis: Vec3) -> f32 {
        let mut sums = [0.0; LANES];
        for group in &self.groups {
            let (_, across) = group.along_and_across(middle, axis);
            for i in 0..LANES {
                sums[i] += across[i] * group.area[i];
            }
        }
        sum(&sums) as f32 / self.area
    }

    /// The ends of a capsule of this radius on a line, if its caps end where the surface does.
    pub fn ends(&self, middle: Vec3, axis: Vec3, radius: f32) -> (f32, f32) {
        let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        for group in &self.groups {
            let (along, across) = group.along_and_across(middle, axis);
            for i in 0..LANES {
                let cap = larger(radius * radius - across[i], 0.0).sqrt();
                low[i] = smaller(along[i] + cap, low[i]);
                high[i] = larger(along[i] - cap, high[i]);
            }
        }
        let low = low.into_iter().fold(f32::INFINITY, smaller);
        let high = high.into_iter().fold(f32::NEG_INFINITY, larger);
        if low > high { (0.5 * (low + high), 0.5 * (low + high)) } else { (low, high) }
    }

    /// The integral of the squared distance from a capsule over the surface; what is outside counts `cover` times.
    pub fn error(&self, capsule: &CapsuleBetween, cover: f32) -> f32 {
        let capsule = Axis::of(capsule);
        let mut sums = [0.0; LANES];
        for group in &self.groups {
            let distance = group.apart(&capsule).distance;
            for i in 0..LANES {
                sums[i] += weight(group.area[i], distance[i], cover) * (distance[i] * distance[i]);
            }
        }
        sum(&sums) as f32
    }

    /// The equations of a capsule. What is outside counts `cover` times.
    pub fn equations(&self, capsule: &CapsuleBetween, cover: f32) -> Equations {
        let capsule = Axis::of(capsule);
        // By ends, squared and together: products of directions, directions, and directions times distances.
        let mut products = [[[0.0; LANES]; 6]; 3];
        let mut directions = [[[0.0; LANES]; 3]; 2];
        let mut pulls = [[[0.0; LANES]; 3]; 2];
        let [mut weights, mut distances] = [[0.0; LANES]; 2];
        for group in &self.groups {
            let Apart { distance, part, out } = group.apart(&capsule);
            let mut weighed = [0.0; LANES];
            for i in 0..LANES {
                weighed[i] = weight(group.area[i], distance[i], cover);
                weights[i] += weighed[i];
                distances[i] += weighed[i] * distance[i];
            }
            for (k, (a, b)) in PAIRS.into_iter().enumerate() {
                for i in 0..LANES {
                    let product = weighed[i] * (out[a][i] * out[b][i]);
                    let (other, one) = (part[i], 1.0 - part[i]);
                    products[0][k][i] += product * (one * one);
                    products[1][k][i] += product * (one * other);
                    products[2][k][i] += product * (other * other);
                }
            }
            for a in 0..3 {
                for i in 0..LANES {
                    let direction = weighed[i] * out[a][i];
                    let (one, other) = (direction * (1.0 - part[i]), direction * part[i]);
                    directions[0][a][i] += one;
                    directions[1][a][i] += other;
                    pulls[0][a][i] += one * distance[i];
                    pulls[1][a][i] += other * distance[i];
                }
            }
        }
        let mut normal = [[0.0; 7]; 7];
        let mut right = [0.0; 7];
        for (k, (a, b)) in PAIRS.into_iter().enumerate() {
            let [one, both, other] = [0, 1, 2].map(|i| sum(&products[i][k]));
            normal[a][b] = one;
            normal[3 + a][3 + b] = other;
            (normal[3 + a][b], normal[3 + b][a]) = (both, both);
        }
        for end in 0..2 {
            for a in 0..3 {
                normal[6][3 * end + a] = sum(&directions[end][a]);
                right[3 * end + a] = sum(&pulls[end][a]);
            }
        }
        (normal[6][6], right[6]) = (sum(&weights), sum(&distances));
        Equations { normal, right }
    }
}

/// Axes by row and column, on the diagonal and below.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)];

/// A capsule as its distance is worked out.
struct Axis {
    from: Vec3,
    axis: Vec3,
    /// One over the square of its length, and the part of the axis that is nearest where it has none.
    per_length: f32,
    anywhere: f32,
    radius: f32,
}

impl Axis {
    fn of(capsule: &CapsuleBetween) -> Self {
        let axis = capsule.to - capsule.from;
        let length = axis.length_squared();
        let (per_length, anywhere) = if length > 0.0 { (1.0 / length, 0.0) } else { (0.0, 0.5) };
        Self { from: capsule.from, axis, per_length, anywhere, radius: capsule.radius }
    }
}

impl Group {
    /// How far along a line points are, and the squares of how far from it.
    #[inline(always)]
    fn along_and_across(&self, middle: Vec3, axis: Vec3) -> (Lanes, Lanes) {
        let [mut along, mut across] = [[0.0; LANES]; 2];
        for i in 0..LANES {
            let (x, y, z) = (self.x[i] - middle.x, self.y[i] - middle.y, self.z[i] - middle.z);
            along[i] = x * axis.x + y * axis.y + z * axis.z;
            across[i] = larger(x * x + y * y + z * z - along[i] * along[i], 0.0);
        }
        (along, across)
    }

    #[inline(always)]
    fn apart(&self, capsule: &Axis) -> Apart {
        let Axis { from, axis, per_length, anywhere, radius } = *capsule;
        let [mut distance, mut part] = [[0.0; LANES]; 2];
        let mut out = [[0.0; LANES]; 3];
        for i in 0..LANES {
            let (x, y, z) = (self.x[i] - from.x, self.y[i] - from.y, self.z[i] - from.z);
            let along = (x * axis.x + y * axis.y + z * axis.z) * per_length + anywhere;
            part[i] = smaller(larger(along, 0.0), 1.0);
            out[0][i] = x - axis.x * part[i];
            out[1][i] = y - axis.y * part[i];
            out[2][i] = z - axis.z * part[i];
        }
        for i in 0..LANES {
            let square = out[0][i] * out[0][i] + out[1][i] * out[1][i] + out[2][i] * out[2][i];
            let length = square.sqrt();
            let per_length = 1.0 / larger(length, f32::MIN_POSITIVE);
            for axis in &mut out {
                axis[i] *= per_length;
            }
            distance[i] = length - radius;
        }
        Apart { distance, part, out }
    }
}

#[inline(always)]
fn weight(area: f32, distance: f32, cover: f32) -> f32 {
    if distance > 0.0 { cover * area } else { area }
}

fn sum(lanes: &Lanes) -> f64 {
    lanes.iter().map(|it| f64::from(*it)).sum()
}
