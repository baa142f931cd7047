//! Slices of distance fields: lines of equal distance in a plane.

use bevy::color::palettes::css;
use bevy::prelude::*;

use crate::collider::SdfCollider;
use crate::gizmos::ClothGizmos;
use crate::pose::{pose_of, to_world};
use crate::sdf::{DistanceField, SignedDistance};
use crate::solver::Pose;

/// Cells a side of a slice.
const CELLS: usize = 64;

/// Most lines of equal distance, to each side of the surface.
const MOST_LINES: i32 = 64;

/// Lets [`ClothGizmosPlugin`](crate::ClothGizmosPlugin) draw a slice through the
/// [`SdfCollider`] beside it: lines of equal distance in a square, white on the surface, blue outside, red
/// inside. So one sees what a mesh was baked to.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{SdfSlice, prelude::*};
/// # fn spawn(mut commands: Commands) {
/// // Upright through the middle, 1.5 m to each side, a line for each 5 cm.
/// let slice = SdfSlice { half_size: 1.5, spacing: 0.05, ..default() };
/// commands.spawn((SdfCollider::from(Sphere::new(0.5)), slice));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct SdfSlice {
    /// Its middle, in the collider's frame \[m\].
    pub middle: Vec3,
    /// Its normal, in the collider's frame.
    pub normal: Dir3,
    /// Half of its side \[m\]. Higher shows more, coarser.
    pub half_size: f32,
    /// Distance from line to line \[m\], above 0. Higher draws fewer.
    pub spacing: f32,
}

impl Default for SdfSlice {
    fn default() -> Self {
        Self { middle: Vec3::ZERO, normal: Dir3::Z, half_size: 1.0, spacing: 0.1 }
    }
}

/// All slices, where their colliders are drawn.
pub(super) fn draw_slices(
    slices: Query<(&SdfSlice, &SdfCollider, &GlobalTransform)>,
    fields: Option<Res<Assets<DistanceField>>>,
    mut gizmos: Gizmos<ClothGizmos>,
) {
    for (slice, collider, place) in &slices {
        // What cannot be used is told of as a collider.
        let (Some(shape), Ok(pose)) = (collider.shape.get(fields.as_deref()), pose_of(place))
        else {
            continue;
        };
        draw_slice(slice, shape, &pose, &mut gizmos);
    }
}

fn draw_slice(
    slice: &SdfSlice,
    shape: &dyn SignedDistance,
    pose: &Pose,
    gizmos: &mut Gizmos<ClothGizmos>,
) {
    let &SdfSlice { middle, normal, half_size, spacing } = slice;
    if !(spacing > 0.0 && half_size > 0.0 && half_size.is_finite() && middle.is_finite()) {
        return;
    }
    let (right, up) = normal.any_orthonormal_pair();
    let along = |i: usize| half_size * (2.0 * i as f32 / CELLS as f32 - 1.0);
    let node = |i: usize, j: usize| middle + along(i) * right + along(j) * up;
    let row = |j: usize| -> Vec<f32> {
        (0..=CELLS).map(|i| shape.distance(node(i, j)) / spacing).collect()
    };
    let mut below = row(0);
    for j in 0..CELLS {
        let above = row(j + 1);
        for i in 0..CELLS {
            // Around two triangles, in which a level is one line.
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| node(i, j));
            let levels = [below[i], below[i + 1], above[i + 1], above[i]];
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let at = [a, b, c].map(|k| (corners[k], levels[k]));
                for_each_line(at, |level, from, to| {
                    gizmos.line(to_world(pose, from), to_world(pose, to), color(level));
                });
            }
        }
        below = above;
    }
}

/// The lines of whole levels in a triangle of which the corners' levels are known.
fn for_each_line(corners: [(Vec3, f32); 3], mut act: impl FnMut(i32, Vec3, Vec3)) {
    let levels = corners.map(|(_, level)| level);
    let low = levels.into_iter().fold(f32::INFINITY, f32::min).max(-MOST_LINES as f32);
    let high = levels.into_iter().fold(f32::NEG_INFINITY, f32::max).min(MOST_LINES as f32);
    if !levels.into_iter().all(f32::is_finite) {
        return;
    }
    for level in low.ceil() as i32..=high.floor() as i32 {
        let mut ends = [None, None];
        for (k, (from, a)) in corners.into_iter().enumerate() {
            let (to, b) = corners[(k + 1) % 3];
            let (a, b) = (a - level as f32, b - level as f32);
            // A corner that is on the level counts as above it.
            if (a < 0.0) != (b < 0.0) {
                let crossing = from.lerp(to, a / (a - b));
                let free = usize::from(ends[0].is_some());
                ends[free] = Some(crossing);
            }
        }
        if let [Some(from), Some(to)] = ends {
            act(level, from, to);
        }
    }
}

/// White on the surface; fainter further away.
fn color(level: i32) -> LinearRgba {
    let part = 1.0 / (1.0 + 0.15 * level.unsigned_abs() as f32);
    let color = match level {
        0 => css::WHITE,
        1.. => css::DODGER_BLUE,
        _ => css::RED,
    };
    LinearRgba::from(color) * part
}
