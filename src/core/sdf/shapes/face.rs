//! The nearest place of a triangle, without branches.

use super::{larger, smaller};
use crate::sdf::{LANES, PointBlock};

/// A triangle with what the distance to it needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    corner: [f32; 3],
    ab: Side,
    ac: Side,
    bc: Side,
    /// Unit length; zero where the triangle has no area.
    pub normal: [f32; 3],
}

/// Square of a distance, and the way.
type Found = (f32, [f32; 3]);

/// A side, and the direction in the triangle's plane that leads inside from it.
#[derive(Clone, Copy, Debug)]
struct Side {
    way: [f32; 3],
    /// One over the square of its length; zero where it has none.
    inverse_squared: f32,
    inward: [f32; 3],
}

impl Side {
    fn new(way: [f32; 3], normal: [f32; 3]) -> Self {
        let squared = dot(way, way);
        let inverse = 1.0 / squared;
        let inverse_squared = if inverse.is_finite() { inverse } else { 0.0 };
        Self { way, inverse_squared, inward: cross(normal, way) }
    }

    /// From the nearest place of the side to what is `from` its start, and the square of that.
    #[inline(always)]
    fn away(&self, from: [f32; 3]) -> Found {
        let along = dot(from, self.way) * self.inverse_squared;
        let along = smaller(larger(along, 0.0), 1.0);
        let away = [0, 1, 2].map(|i| from[i] - along * self.way[i]);
        (dot(away, away), away)
    }
}

impl Face {
    /// A triangle between three corners \[m\].
    pub fn new([a, b, c]: [[f32; 3]; 3]) -> Self {
        let (ab, ac, bc) = (minus(b, a), minus(c, a), minus(c, b));
        let across = cross(ab, ac);
        let squared = dot(across, across);
        let normal = if squared >= f32::MIN_POSITIVE {
            across.map(|x| x / squared.sqrt())
        } else {
            [0.0; 3]
        };
        let ac = Side::new(ac, normal);
        Self {
            corner: a,
            ab: Side::new(ab, normal),
            // Inside is on the other side of it, as it goes the other way around.
            ac: Side { inward: ac.inward.map(|x| -x), ..ac },
            bc: Side::new(bc, normal),
            normal,
        }
    }

    /// Square of the distance \[m2\], and the way from the nearest place to the point \[m\].
    #[inline(always)]
    pub fn away(&self, point: [f32; 3]) -> Found {
        let from_a = minus(point, self.corner);
        let from_b = minus(from_a, self.ab.way);
        let beside_a = nearer(self.ab.away(from_a), self.ac.away(from_a));
        let (least, away) = nearer(beside_a, self.bc.away(from_b));
        // Without an area it is beside nothing.
        let is_over = (dot(from_a, self.ab.inward) > 0.0)
            & (dot(from_a, self.ac.inward) > 0.0)
            & (dot(from_b, self.bc.inward) > 0.0);
        let height = dot(from_a, self.normal);
        let above = (height * height, self.normal.map(|x| height * x));
        pick(is_over, above, (least, away))
    }
}

/// The nearest triangles of a block of points, as far as they are known.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestFaces {
    /// Squares of the distances \[m2\].
    pub squared: [f32; LANES],
    /// The ways from the nearest places to the points \[m\].
    pub away: PointBlock,
    /// The triangles' numbers.
    pub face: [i32; LANES],
}

impl NearestFaces {
    /// Nothing is known.
    pub fn unknown() -> Self {
        let (squared, away) = ([f32::INFINITY; LANES], PointBlock::default());
        Self { squared, away, face: [0; LANES] }
    }

    /// Takes a triangle where it is nearer, or as near and of a lower number.
    #[inline(always)]
    pub fn take(&mut self, face: &Face, number: i32, points: &PointBlock) {
        let face = *face;
        let (mut squared, mut way) = ([0.0; LANES], PointBlock::default());
        for (lane, squared) in squared.iter_mut().enumerate() {
            let (of_lane, [x, y, z]) = face.away([points.x[lane], points.y[lane], points.z[lane]]);
            *squared = of_lane;
            (way.x[lane], way.y[lane], way.z[lane]) = (x, y, z);
        }
        for (lane, squared) in squared.into_iter().enumerate() {
            let (least, known) = (self.squared[lane], self.face[lane]);
            let is_nearer = squared < least;
            let ties = (squared == least) & (number < known);
            let takes = is_nearer | ties;
            let old = [self.away.x[lane], self.away.y[lane], self.away.z[lane]];
            self.squared[lane] = if takes { squared } else { least };
            self.face[lane] = if takes { number } else { known };
            self.away.x[lane] = if takes { way.x[lane] } else { old[0] };
            self.away.y[lane] = if takes { way.y[lane] } else { old[1] };
            self.away.z[lane] = if takes { way.z[lane] } else { old[2] };
        }
    }
}

/// The first of two that is no further.
#[inline(always)]
fn nearer(a: Found, b: Found) -> Found {
    pick(b.0 < a.0, b, a)
}

#[inline(always)]
fn pick(which: bool, a: Found, b: Found) -> Found {
    let pick = |a: f32, b: f32| if which { a } else { b };
    (pick(a.0, b.0), [pick(a.1[0], b.1[0]), pick(a.1[1], b.1[1]), pick(a.1[2], b.1[2])])
}

#[inline(always)]
fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
