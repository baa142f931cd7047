//! One capsule for a surface: least squares by the method of Levenberg (1944) and Marquardt (1963).

use bevy_math::Vec3;

use super::SurfacePoint;
use super::linear::{Cloud, solve};
use crate::sdf::shapes::CapsuleBetween;

/// How many times more what is outside of the capsule counts.
const COVER: f32 = 6.0;
/// Most points that a fit looks at: of more, every second, third...
const MOST_POINTS: usize = 192;
/// Steps to the least error at most.
const STEPS: usize = 12;
/// Part of the error that a step has to save to go on.
const CONVERGED: f32 = 1e-3;

/// A capsule and how far it is from a surface.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    pub capsule: CapsuleBetween,
    /// The integral of the squared distance over the surface; what is outside counts [`COVER`] times.
    pub error: f32,
    /// Area of the surface.
    area: f32,
}

impl Fit {
    /// The best capsule of a surface; `None` where it has no points.
    pub fn of(points: &[SurfacePoint]) -> Option<Self> {
        let points = thinned(points);
        let cloud = Cloud::of(&points)?;
        let fits =
            cloud.axes.iter().map(|axis| refined(guess(&points, cloud.mean, *axis), &points));
        let (capsule, error) = fits.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Self { capsule, error, area: points.iter().map(|it| it.area).sum() })
    }

    /// The error of a capsule that is guessed.
    pub fn rough(points: &[SurfacePoint]) -> Option<f32> {
        let points = thinned(points);
        let cloud = Cloud::of(&points)?;
        let errors =
            cloud.axes.iter().map(|axis| error(&guess(&points, cloud.mean, *axis), &points));
        errors.min_by(f32::total_cmp)
    }

    /// The mean squared distance, counted as `error` is.
    pub fn mean_square(&self) -> f32 {
        self.error / self.area
    }
}

/// Some of many points, that stand for all.
fn thinned(points: &[SurfacePoint]) -> Vec<SurfacePoint> {
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    let chosen = points.iter().step_by(step);
    chosen.map(|it| SurfacePoint { area: it.area * step as f32, ..*it }).collect()
}

/// A capsule along an axis through the middle, as thick as the surface is in the mean, and as long.
fn guess(points: &[SurfacePoint], middle: Vec3, axis: Vec3) -> CapsuleBetween {
    let area: f32 = points.iter().map(|it| it.area).sum();
    let squares = points.iter().map(|it| from_line(middle, axis, it.point).1 * it.area);
    let radius = (squares.sum::<f32>() / area).sqrt();
    let (low, high) = ends(points, middle, axis, radius);
    CapsuleBetween { from: middle + axis * low, to: middle + axis * high, radius }
}

/// How far along a line a point is, and the square of how far from it.
fn from_line(middle: Vec3, axis: Vec3, point: Vec3) -> (f32, f32) {
    let offset = point - middle;
    let along = offset.dot(axis);
    (along, (offset.length_squared() - along * along).max(0.0))
}

/// Where on a line a capsule of this radius begins and ends, if its caps end where the surface does.
fn ends(points: &[SurfacePoint], middle: Vec3, axis: Vec3, radius: f32) -> (f32, f32) {
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for it in points {
        let (along, across) = from_line(middle, axis, it.point);
        let cap = (radius * radius - across).max(0.0).sqrt();
        (low, high) = (low.min(along + cap), high.max(along - cap));
    }
    if low > high { (0.5 * (low + high), 0.5 * (low + high)) } else { (low, high) }
}

/// A capsule no longer than the surface: what is beyond it no point could tell.
fn trimmed(capsule: CapsuleBetween, points: &[SurfacePoint]) -> CapsuleBetween {
    let (axis, length) = (capsule.to - capsule.from).normalize_and_length();
    if length <= 0.0 {
        return capsule;
    }
    let (low, high) = ends(points, capsule.from, axis, capsule.radius);
    let (from, to) = (low.clamp(0.0, length), high.clamp(0.0, length));
    CapsuleBetween { from: capsule.from + axis * from, to: capsule.from + axis * to, ..capsule }
}

/// How far a point is outside of a capsule, how far along its axis \[1\], and which way is out.
fn apart(capsule: &CapsuleBetween, point: Vec3) -> (f32, f32, Vec3) {
    let axis = capsule.to - capsule.from;
    let length = axis.length_squared();
    let offset = point - capsule.from;
    let part = if length > 0.0 { (offset.dot(axis) / length).clamp(0.0, 1.0) } else { 0.5 };
    let out = offset - axis * part;
    let distance = out.length();
    (distance - capsule.radius, part, if distance > 0.0 { out / distance } else { Vec3::ZERO })
}

/// How far a point is outside of a capsule.
pub fn distance(capsule: &CapsuleBetween, point: Vec3) -> f32 {
    apart(capsule, point).0
}

fn weight(it: &SurfacePoint, distance: f32) -> f32 {
    if distance > 0.0 { COVER * it.area } else { it.area }
}

fn error(capsule: &CapsuleBetween, points: &[SurfacePoint]) -> f32 {
    let squared = |it: &SurfacePoint| {
        let distance = distance(capsule, it.point);
        weight(it, distance) * distance * distance
    };
    points.iter().map(squared).sum()
}

/// The capsule of least error near another, and its error.
fn refined(from: CapsuleBetween, points: &[SurfacePoint]) -> (CapsuleBetween, f32) {
    let mut best = (from, error(&from, points));
    let mut damping = 1e-2;
    for _ in 0..STEPS {
        let Some(next) = step(&best.0, points, damping) else { break };
        let next = trimmed(next, points);
        let found = error(&next, points);
        if found < best.1 {
            let is_near = found > (1.0 - CONVERGED) * best.1;
            best = (next, found);
            damping *= 0.2;
            if is_near {
                break;
            }
        } else {
            damping *= 8.0;
        }
    }
    best
}

/// A damped step of Gauss and Newton towards less error.
fn step(capsule: &CapsuleBetween, points: &[SurfacePoint], damping: f64) -> Option<CapsuleBetween> {
    let mut normal = [[0.0; 7]; 7];
    let mut right = [0.0; 7];
    for it in points {
        let (distance, part, out) = apart(capsule, it.point);
        let [ends, radius] = [[(1.0 - part) * out, part * out], [Vec3::ONE; 2]];
        let slope = [ends[0].x, ends[0].y, ends[0].z, ends[1].x, ends[1].y, ends[1].z, radius[0].x];
        let weight = weight(it, distance);
        for (i, a) in slope.into_iter().enumerate() {
            right[i] += f64::from(weight * a * distance);
            for (sum, b) in normal[i][..=i].iter_mut().zip(slope) {
                *sum += f64::from(weight * a * b);
            }
        }
    }
    // What no point tells anything of stays as it is.
    let largest = (0..7).map(|i| normal[i][i]).fold(0.0, f64::max);
    for (i, row) in normal.iter_mut().enumerate() {
        row[i] += damping * row[i] + 1e-4 * largest;
    }
    let [ax, ay, az, bx, by, bz, r] = solve(normal, right)?.map(|it| it as f32);
    let radius = capsule.radius + r;
    (radius > 0.0).then(|| CapsuleBetween {
        from: capsule.from + Vec3::new(ax, ay, az),
        to: capsule.to + Vec3::new(bx, by, bz),
        radius,
    })
}
