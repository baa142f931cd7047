//! One capsule for a surface: least squares by the method of Levenberg (1944) and Marquardt (1963).

use bevy_math::Vec3;

use super::SurfacePoint;
use super::columns::{Columns, Equations};
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
        let points = Columns::new(&points);
        let fits =
            cloud.axes.iter().map(|axis| refined(guess(&points, cloud.mean, *axis), &points));
        let (capsule, error) = fits.min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Self { capsule, error, area: points.area })
    }

    /// The error of a capsule that is guessed.
    pub fn rough(points: &[SurfacePoint]) -> Option<f32> {
        let points = thinned(points);
        let cloud = Cloud::of(&points)?;
        let points = Columns::new(&points);
        let errors =
            cloud.axes.iter().map(|axis| points.error(&guess(&points, cloud.mean, *axis), COVER));
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
fn guess(points: &Columns, middle: Vec3, axis: Vec3) -> CapsuleBetween {
    let radius = points.mean_square_from_line(middle, axis).sqrt();
    let (low, high) = points.ends(middle, axis, radius);
    CapsuleBetween { from: middle + axis * low, to: middle + axis * high, radius }
}

/// A capsule no longer than the surface: what is beyond it no point could tell.
fn trimmed(capsule: CapsuleBetween, points: &Columns) -> CapsuleBetween {
    let (axis, length) = (capsule.to - capsule.from).normalize_and_length();
    if length <= 0.0 {
        return capsule;
    }
    let (low, high) = points.ends(capsule.from, axis, capsule.radius);
    let (from, to) = (low.clamp(0.0, length), high.clamp(0.0, length));
    CapsuleBetween { from: capsule.from + axis * from, to: capsule.from + axis * to, ..capsule }
}

/// The capsule of least error near another, and its error.
fn refined(from: CapsuleBetween, points: &Columns) -> (CapsuleBetween, f32) {
    let mut best = (from, points.error(&from, COVER));
    let mut damping = 1e-2;
    for _ in 0..STEPS {
        let Some(next) = step(&best.0, points, damping) else { break };
        let next = trimmed(next, points);
        let found = points.error(&next, COVER);
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
fn step(capsule: &CapsuleBetween, points: &Columns, damping: f64) -> Option<CapsuleBetween> {
    let Equations { mut normal, right } = points.equations(capsule, COVER);
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
