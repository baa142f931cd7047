//! The nearest place of a triangle, without branches.

use super::{larger, smaller};
use crate::sdf::{LANES, PointBlock};
use bevy_math::Vec3;

/// A triangle with what the distance to it needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    corner: Vec3,
    ab: Side,
    ac: Side,
    bc: Side,
    /// Unit length; zero where the triangle has no area.
    pub normal: Vec3,
}

/// Square of a distance, and the way.
type Found = (f32, Vec3);

/// A side, and the direction in the triangle's plane that leads inside from it.
#[derive(Clone, Copy, Debug)]
struct Side {
    way: Vec3,
    /// One over the square of its length; zero where it has none.
    inverse_squared: f32,
    inward: Vec3,
}

impl Side {
    fn new(way: Vec3, normal: Vec3) -> Self {
        let inverse = 1.0 / way.dot(way);
        let inverse_squared = if inverse.is_finite() { inverse } else { 0.0 };
        Self { way, inverse_squared, inward: normal.cross(way) }
    }

    /// From the nearest place of the side to what is `from` its start, and the square of that.
    #[inline(always)]
    fn away(&self, from: Vec3) -> Found {
        let along = from.dot(self.way) * self.inverse_squared;
        let along = smaller(larger(along, 0.0), 1.0);
        let away = from - self.way * along;
        (away.dot(away), away)
    }
}

impl Face {
    /// A triangle between three corners \[m\].
    pub fn new([a, b, c]: [Vec3; 3]) -> Self {
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let across = ab.cross(ac);
        let squared = across.dot(across);
        let normal =
            if squared >= f32::MIN_POSITIVE { across / squared.sqrt() } else { Vec3::ZERO };
        let ac = Side::new(ac, normal);
        Self {
            corner: a,
            ab: Side::new(ab, normal),
            // Inside is on the other side of it, as it goes the other way around.
            ac: Side { inward: -ac.inward, ..ac },
            bc: Side::new(bc, normal),
            normal,
        }
    }

    /// Square of the distance \[m2\], and the way from the nearest place to the point \[m\].
    #[inline(always)]
    pub fn away(&self, point: Vec3) -> Found {
        let from_a = point - self.corner;
        let from_b = from_a - self.ab.way;
        let beside_a = nearer(self.ab.away(from_a), self.ac.away(from_a));
        let beside = nearer(beside_a, self.bc.away(from_b));
        // Without an area it is beside nothing.
        let is_over = (from_a.dot(self.ab.inward) > 0.0)
            & (from_a.dot(self.ac.inward) > 0.0)
            & (from_b.dot(self.bc.inward) > 0.0);
        let height = from_a.dot(self.normal);
        pick(is_over, (height * height, self.normal * height), beside)
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
    /// None is known yet, but that one is nearer than a squared distance \[m2\]; infinite where that is not known either.
    pub fn within(squared: &[f32; LANES]) -> Self {
        Self { squared: *squared, away: PointBlock::default(), face: [0; LANES] }
    }

    /// Takes a triangle where it is nearer, or as near and of a lower number.
    #[inline(always)]
    pub fn take(&mut self, face: &Face, number: i32, points: &PointBlock) {
        let face = *face;
        let (mut squared, mut way) = ([0.0; LANES], PointBlock::default());
        for (lane, squared) in squared.iter_mut().enumerate() {
            let (of_lane, away) = face.away(points.point(lane));
            *squared = of_lane;
            way.set(lane, away);
        }
        for lane in 0..LANES {
            // All is loaded before it is chosen between: what is chosen first would be gathered.
            let (squared, way) = (squared[lane], way.point(lane));
            let (least, away, known) = (self.squared[lane], self.away.point(lane), self.face[lane]);
            let is_nearer = squared < least;
            let ties = (squared == least) & (number < known);
            let takes = is_nearer | ties;
            let (least, away) = pick(takes, (squared, way), (least, away));
            self.squared[lane] = least;
            self.away.set(lane, away);
            self.face[lane] = if takes { number } else { known };
        }
    }
}

/// The first of two that is no further.
#[inline(always)]
fn nearer(a: Found, b: Found) -> Found {
    pick(b.0 < a.0, b, a)
}

/// One of two, number by number: arrays of them would be gathered from memory.
#[inline(always)]
fn pick(which: bool, a: Found, b: Found) -> Found {
    let pick = |a: f32, b: f32| if which { a } else { b };
    (pick(a.0, b.0), Vec3::new(pick(a.1.x, b.1.x), pick(a.1.y, b.1.y), pick(a.1.z, b.1.z)))
}
