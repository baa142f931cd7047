//! Capsules that are fitted to the skin of a character.
//!
//! | file | what it does |
//! | --- | --- |
//! | here | one surface as several capsules: fitted, and cut in two for as long as that is worth it |
//! | `body` | shares a skinned surface out to its joints |
//! | `capsule` | one capsule: least squares |
//! | `columns` | the points that it is fitted to, side by side |
//! | `linear` | axes of a cloud of points, and small linear systems |

mod body;
mod capsule;
mod columns;
mod linear;

pub use body::{BodySurface, JointCapsule, fit_body};

use bevy_math::Vec3;

use super::{SignedDistance, shapes::CapsuleBetween};
use capsule::Fit;
use linear::Cloud;

/// A point of a surface, and the part of the surface that it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is \[m\].
    pub point: Vec3,
    /// Its part of the surface \[m^2\], above 0.
    pub area: f32,
}

/// Part of the error that a cut has to save.
const WORTH_A_CUT: f32 = 0.4;
/// Fewest points that are cut in two.
const FEWEST: usize = 16;
/// Part of the points that may be outside of their capsule by more than one and a half times the tolerance.
const LEFT_OUT: f32 = 0.02;

/// Capsules near a surface: one, or up to `most`, if fewer leave a root mean square distance above `tolerance` \[m\].
///
/// Each minimizes the squared distance from the surface to its own. What is outside of it counts several times, as skin that
/// pokes through a cloth is seen, and a cloth that is a little further out is not. In the end it grows until no more than 2 % of its
/// points are outside by more than one and a half times the tolerance.
pub fn fit_capsules(points: &[SurfacePoint], tolerance: f32, most: usize) -> Vec<CapsuleBetween> {
    let mut parts: Vec<_> = Part::fit(points.to_vec()).into_iter().collect();
    while parts.len() < most {
        // That which is worst.
        let errors = parts.iter().enumerate().filter(|(_, part)| part.can_be_cut(tolerance));
        let Some((worst, _)) = errors.max_by(|a, b| a.1.fit.error.total_cmp(&b.1.fit.error)) else {
            break;
        };
        match parts[worst].cut() {
            Some([one, other]) => {
                parts[worst] = one;
                parts.push(other);
            }
            None => parts[worst].is_whole = true,
        }
    }
    parts.into_iter().map(|part| part.covering(tolerance)).collect()
}

/// A part of a surface, and its capsule.
struct Part {
    points: Vec<SurfacePoint>,
    fit: Fit,
    /// A cut is not worth it.
    is_whole: bool,
}

impl Part {
    fn fit(points: Vec<SurfacePoint>) -> Option<Self> {
        let fit = Fit::of(&points)?;
        Some(Self { points, fit, is_whole: false })
    }

    fn can_be_cut(&self, tolerance: f32) -> bool {
        !self.is_whole
            && self.points.len() >= FEWEST
            && self.fit.mean_square() > tolerance * tolerance
    }

    /// The capsule, grown by as much as too many points are too far outside.
    fn covering(&self, tolerance: f32) -> CapsuleBetween {
        let capsule = self.fit.capsule;
        let mut outside: Vec<f32> =
            self.points.iter().map(|it| capsule.distance(it.point)).collect();
        let covered = ((1.0 - LEFT_OUT) * (outside.len() - 1) as f32) as usize;
        let (_, covered, _) = outside.select_nth_unstable_by(covered, f32::total_cmp);
        let missing = (*covered - 1.5 * tolerance).max(0.0);
        CapsuleBetween { radius: capsule.radius + missing, ..capsule }
    }

    /// Both halves, cut across the axis that leaves the least error; `None` where that saves too little.
    fn cut(&self) -> Option<[Self; 2]> {
        let cloud = Cloud::of(&self.points)?;
        let cut_at = |axis: &Vec3| {
            let is_before = |it: &&SurfacePoint| (it.point - cloud.mean).dot(*axis) < 0.0;
            let (before, after): (Vec<_>, Vec<_>) = self.points.iter().partition(is_before);
            let error = Fit::rough(&before)? + Fit::rough(&after)?;
            Some((error, before, after))
        };
        let cuts = cloud.axes.iter().filter_map(cut_at);
        let (_, before, after) = cuts.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (one, other) = (Self::fit(before)?, Self::fit(after)?);
        let is_worth_it = one.fit.error + other.fit.error < (1.0 - WORTH_A_CUT) * self.fit.error;
        is_worth_it.then_some([one, other])
    }
}
