//! The surface of a cloth that hangs from given points.

use bevy_math::{DVec2, DVec3, Vec3};

use super::catenary::Catenary;
use super::flatten::flatten;
use super::points::{HangError, HangingPoint, check_each, check_pairs};
use super::triangulate::{Triangulation, crossing, triangulate};
use crate::solver::Topology;

/// Heights that differ by less than this part of the curves' lengths are the same.
const ROUNDING: f64 = 1e-5;
/// Triangles are split until their sides are shorter than this part of the cloth's usual spring.
const FINENESS: f64 = 0.5;
/// Largest angle of a pleat, where a cloth hangs down around a single point.
const PLEAT: f64 = 0.5;

/// Where all particles of a cloth are that hangs from two or more points, gravity pulling along `down` (of
/// any length): positions in world space \[m\], by particle.
///
/// Points may be further apart than the cloth at rest by `max_strain` of the distance between them; it is
/// taut then. A piece of cloth that nothing joins to a hanging point stays where `start`, one position a
/// particle, has it.
///
/// # Errors
/// [`HangError`]: fewer than two points, two at the same place, two further apart than the cloth reaches.
///
/// # Panics
/// Where `start` is not one position a particle.
pub fn hang(
    topology: &Topology,
    start: &[Vec3],
    points: &[HangingPoint],
    max_strain: f32,
    down: Vec3,
) -> Result<Vec<Vec3>, HangError> {
    assert_eq!(start.len(), topology.particle_count(), "one start position a particle");
    let up = -down.as_dvec3().try_normalize().ok_or(HangError::NoGravity)?;
    check_each(topology, points)?;
    let cloth = flatten(topology);
    check_pairs(topology, &cloth, points, f64::from(max_strain))?;
    let mut places: Vec<Vec3> = start.to_vec();
    let spacing = usual_spring(topology);
    let mut pieces: Vec<usize> = points.iter().map(|p| cloth.piece[p.particle as usize]).collect();
    pieces.sort_unstable();
    pieces.dedup();
    for piece in pieces {
        let of_piece = |particle: usize| cloth.piece[particle] == piece;
        let corners: Vec<Corner> = points
            .iter()
            .filter(|point| of_piece(point.particle as usize))
            .map(|point| Corner {
                at: cloth.at[point.particle as usize],
                place: point.place.as_dvec3(),
            })
            .collect();
        let surface = Surface::new(corners, up, spacing);
        let members: Vec<usize> = (0..start.len()).filter(|&i| of_piece(i)).collect();
        surface.place(&cloth.at, members, &mut places);
    }
    // To the bit.
    for point in points {
        places[point.particle as usize] = point.place;
    }
    Ok(places)
}

/// The mean length of the springs at rest \[m\].
fn usual_spring(topology: &Topology) -> f64 {
    let (mut count, mut total) = (0_usize, 0.0);
    for (_, _, rest) in topology.structural_springs() {
        count += 1;
        total += f64::from(rest);
    }
    total / count.max(1) as f64
}

/// A point of the cloth, spread out flat, and where it is in space \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    at: DVec2,
    place: DVec3,
}

/// The surface that hangs from some corners.
struct Surface {
    corners: Vec<Corner>,
    mesh: Triangulation,
    /// Unit vector against gravity.
    up: DVec3,
    /// Usual length of a spring \[m\].
    spacing: f64,
}

impl Surface {
    fn new(corners: Vec<Corner>, up: DVec3, spacing: f64) -> Self {
        let at: Vec<DVec2> = corners.iter().map(|corner| corner.at).collect();
        let mesh = triangulate(&at, |kept, other| {
            let [kept, other] = [kept, other].map(|line| line.map(|i| corners[i]));
            is_higher(kept, other, up)
        });
        Self { corners, mesh, up, spacing }
    }

    /// Finds the places of particles.
    fn place(&self, at: &[DVec2], particles: Vec<usize>, places: &mut [Vec3]) {
        let mut left = particles;
        for &triangle in &self.mesh.triangles {
            let triangle = triangle.map(|i| self.corners[i]);
            let (inside, outside) = left.into_iter().partition(|&i| contains(triangle, at[i]));
            left = outside;
            self.fill(triangle, inside, at, places);
        }
        let far_side = self.lesser_side(at, &left);
        for particle in left {
            places[particle] = self.drape(at[particle], far_side).as_vec3();
        }
    }

    /// Splits a triangle until it is smaller than a cell, by the line from a corner to the middle of
    /// its longest side.
    fn fill(&self, triangle: [Corner; 3], inside: Vec<usize>, at: &[DVec2], out: &mut [Vec3]) {
        let mut waiting = vec![(triangle, inside)];
        while let Some((triangle, inside)) = waiting.pop() {
            if inside.is_empty() {
                continue;
            }
            let [a, b, c] = longest_first(triangle);
            if a.at.distance(b.at) <= FINENESS * self.spacing {
                for particle in inside {
                    out[particle] = between([a, b, c], at[particle]).as_vec3();
                }
                continue;
            }
            // A part of a catenary is the catenary between its ends: both halves have the one curve.
            let middle = Corner {
                at: 0.5 * (a.at + b.at),
                place: line(a, b, self.up).at(0.5 * a.at.distance(b.at)),
            };
            let toward_a = |&i: &usize| {
                let along = middle.at - c.at;
                let turn = along.perp_dot(a.at - c.at);
                along.perp_dot(at[i] - c.at) * turn >= 0.0
            };
            let (near_a, near_b) = inside.into_iter().partition(toward_a);
            waiting.push(([a, middle, c], near_a));
            waiting.push(([middle, b, c], near_b));
        }
    }

    /// Where the cloth folds over a line between points, the side that less of it hangs down on: 1 on
    /// the left, -1 on the right, 0 where it does not fold.
    fn lesser_side(&self, at: &[DVec2], particles: &[usize]) -> f64 {
        let Some(&[first, _]) = self.mesh.border.first() else { return 0.0 };
        let Some(&[_, last]) = self.mesh.border.last() else { return 0.0 };
        if !self.mesh.triangles.is_empty() {
            return 0.0;
        }
        let (from, to) = (self.corners[first].at, self.corners[last].at);
        let left = particles.iter().filter(|&&i| (to - from).perp_dot(at[i] - from) > 0.0).count();
        if 2 * left < particles.len() { 1.0 } else { -1.0 }
    }

    /// Where a point of the cloth is that hangs down from the nearest curve.
    fn drape(&self, point: DVec2, far_side: f64) -> DVec3 {
        let nearest = |best: (f64, usize, f64), (number, &[a, b]): (usize, &[usize; 2])| {
            let part = nearest_part(self.corners[a].at, self.corners[b].at, point);
            let on_line = self.corners[a].at.lerp(self.corners[b].at, part);
            let distance = on_line.distance(point);
            if distance < best.0 { (distance, number, part) } else { best }
        };
        let border = &self.mesh.border;
        let from = (f64::INFINITY, 0, 0.0);
        let (distance, number, part) = border.iter().enumerate().fold(from, nearest);
        let Some(&[a, b]) = border.get(number) else {
            // A single point: the cloth is pleated all around it.
            let only = self.corners[0];
            let way = point - only.at;
            let angle = libm::atan2(way.y, way.x) + core::f64::consts::PI;
            return only.place
                + self.pleat(way.length(), angle, core::f64::consts::TAU, self.aside());
        };
        let [a, b] = [a, b].map(|i| self.corners[i]);
        let aside = self.across(a, b);
        let line = line(a, b, self.up);
        let place = line.at(part * line.length());
        if part > 0.0 && part < 1.0 {
            // Two sides that hang from one line do not lie in each other.
            let side = (b.at - a.at).perp_dot(point - a.at).signum();
            let apart = if side == far_side { 0.5 * distance.min(self.spacing) } else { 0.0 };
            return place - self.up * distance + aside * apart;
        }
        let corner = if part == 0.0 { a } else { b };
        let (begin, opening) = self.opening(number, part == 1.0);
        let angle = turn_between(begin, point - corner.at).clamp(0.0, opening);
        place + self.pleat(distance, angle, opening, aside)
    }

    /// The angle outside of the border at the beginning of one of its edges, or at its end: the
    /// direction in which it begins, and how far it goes counterclockwise.
    fn opening(&self, edge: usize, at_end: bool) -> (DVec2, f64) {
        let border = &self.mesh.border;
        let count = border.len();
        let outward = |edge: usize| {
            let [a, b] = border[edge % count].map(|i| self.corners[i].at);
            -(b - a).perp()
        };
        if self.mesh.triangles.is_empty() {
            // Around an end of the line, from one of its sides to the other; a joint has no angle.
            return match (edge, at_end) {
                (0, false) => (-outward(0), core::f64::consts::PI),
                (edge, true) if edge + 1 == count => (outward(edge), core::f64::consts::PI),
                _ => (outward(edge), 0.0),
            };
        }
        let (before, after) = if at_end { (edge, edge + 1) } else { (edge + count - 1, edge) };
        (outward(before), turn_between(outward(before), outward(after)))
    }

    /// Cloth around a point, at a distance from it and an angle out of `opening`: it hangs in pleats,
    /// each flat, to both sides of the vertical. No distance within a pleat is changed.
    fn pleat(&self, distance: f64, angle: f64, opening: f64, aside: DVec3) -> DVec3 {
        let count = (opening / PLEAT).ceil().max(1.0);
        let width = opening / count;
        let within = if width > 0.0 { angle - width * (angle / width).floor() } else { 0.0 };
        let tilt = within.min(width - within).max(0.0);
        distance * (aside * libm::sin(tilt) - self.up * libm::cos(tilt))
    }

    /// A level unit vector across a line between two corners.
    fn across(&self, a: Corner, b: Corner) -> DVec3 {
        (b.place - a.place).cross(self.up).try_normalize().unwrap_or_else(|| self.aside())
    }

    /// Any level unit vector.
    fn aside(&self) -> DVec3 {
        self.up.any_orthonormal_vector()
    }
}

/// The curve between two corners.
fn line(a: Corner, b: Corner, up: DVec3) -> Catenary {
    Catenary::hung_or_stretched(a.place, b.place, a.at.distance(b.at), up)
}

/// Whether, of two curves that cross, the second is higher there; or as high, and shorter.
fn is_higher(kept: [Corner; 2], other: [Corner; 2], up: DVec3) -> bool {
    let [kept_part, other_part] = crossing(kept.map(|c| c.at), other.map(|c| c.at));
    let [kept, other] = [kept, other].map(|[a, b]| line(a, b, up));
    let height = |line: &Catenary, part: f64| line.at(part * line.length()).dot(up);
    let gain = height(&other, other_part) - height(&kept, kept_part);
    let least = ROUNDING * (kept.length() + other.length());
    gain > least || gain > -least && other.length() < kept.length() - least
}

/// Whether a triangle contains a point, its border with it.
fn contains(triangle: [Corner; 3], point: DVec2) -> bool {
    let [a, b, c] = triangle.map(|corner| corner.at);
    let size = (b - a).length_squared().max((c - a).length_squared());
    [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(from, to)| (to - from).perp_dot(point - from) >= -1e-6 * size)
}

/// The ends of the longest side, then the third corner.
fn longest_first([a, b, c]: [Corner; 3]) -> [Corner; 3] {
    let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| a.at.distance_squared(b.at));
    if ab >= bc && ab >= ca {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Where a point of a small triangle is.
fn between([a, b, c]: [Corner; 3], point: DVec2) -> DVec3 {
    let area = (b.at - a.at).perp_dot(c.at - a.at);
    let longest = a.at.distance_squared(b.at);
    if area.abs() <= 1e-9 * longest {
        // Hardly more than its longest side.
        return a.place.lerp(b.place, nearest_part(a.at, b.at, point));
    }
    let of_b = (point - a.at).perp_dot(c.at - a.at) / area;
    let of_c = (b.at - a.at).perp_dot(point - a.at) / area;
    a.place + (b.place - a.place) * of_b + (c.place - a.place) * of_c
}

/// How far along a line, from 0 to 1, a point is nearest to it.
fn nearest_part(from: DVec2, to: DVec2, point: DVec2) -> f64 {
    let along = to - from;
    let square = along.length_squared();
    if square > 0.0 { ((point - from).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// The angle from one direction counterclockwise to another, from 0 to a full turn; one that is hardly
/// less than a full turn is none.
fn turn_between(from: DVec2, to: DVec2) -> f64 {
    let angle = libm::atan2(from.perp_dot(to), from.dot(to));
    if angle < -1e-6 { angle + core::f64::consts::TAU } else { angle.max(0.0) }
}
