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
/// Steps to the least error at most, and how many of them are taken from each axis.
const STEPS: usize = 12;
const FIRST_STEPS: usize = 3;
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
        let guesses = cloud.axes.iter().map(|axis| guess(&points, cloud.mean, *axis));
        // A few steps tell which axis is best; it alone is worth the others.
        let begun = guesses.map(|guess| Descent::new(guess, &points).after(FIRST_STEPS, &points));
        let best = begun.min_by(|a, b| a.error.total_cmp(&b.error))?;
        let Descent { capsule, error, .. } = best.after(STEPS - FIRST_STEPS, &points);
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

/// On the way to the capsule of least error near another.
struct Descent {
    capsule: CapsuleBetween,
    error: f32,
    damping: f64,
    /// No step saves enough to be worth another.
    is_over: bool,
}

impl Descent {
    fn new(from: CapsuleBetween, points: &Columns) -> Self {
        let error = points.error(&from, COVER);
        Self { capsule: from, error, damping: 1e-2, is_over: false }
    }

    /// So many steps further, unless it is over before.
    fn after(mut self, steps: usize, points: &Columns) -> Self {
        for _ in 0..steps {
            if self.is_over {
                break;
            }
            self.step(points);
        }
        self
    }

    fn step(&mut self, points: &Columns) {
        let Some(next) = step(&self.capsule, points, self.damping) else {
            self.is_over = true;
            return;
        };
        let next = trimmed(next, points);
        let error = points.error(&next, COVER);
        if error < self.error {
            self.is_over = error > (1.0 - CONVERGED) * self.error;
            (self.capsule, self.error) = (next, error);
            self.damping *= 0.2;
        } else {
            self.damping *= 8.0;
        }
    }
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
