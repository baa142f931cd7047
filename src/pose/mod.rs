//! Where pins and colliders are at a tick's start and at its end.
//!
//! The pose of an entity moved in the fixed schedule is taken as it is. An entity moved once a frame (after
//! the fixed loop, as by an animation) would stand still through a frame's first tick and jump in the
//! next: it is taken where it was at each tick's time, a frame late ([`frames`]). So is what an animation moves on a character
//! that is moved in the fixed schedule ([`root`]).

pub(crate) mod bindposes;
pub(crate) mod course;
pub(crate) mod frames;
pub(crate) mod moves;
pub(crate) mod root;
pub(crate) mod skeleton;
pub(crate) mod track;

use bevy::prelude::*;

use crate::error::ClothErrorKind;
use crate::error::problems::ScaleProblem;
pub(crate) use crate::solver::Pose;
use crate::solver::RigidMotion;

/// How far two poses are from each other: a turn by a radian counts as a metre.
fn distance_of(one: &Pose, other: &Pose) -> f32 {
    let same = if one.rotation.dot(other.rotation) < 0.0 { -1.0 } else { 1.0 };
    let turn = 2.0 * (one.rotation - other.rotation * same).length();
    one.translation.distance(other.translation) + turn + (one.scale - other.scale).abs()
}

/// Whether two poses are the same but for rounding.
fn is_near(one: &Pose, other: &Pose) -> bool {
    one == other || distance_of(one, other) < 1e-5 + 1e-6 * other.translation.length()
}

/// Why a transform is no [`Pose`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PoseError {
    /// The entity or one of its ancestors is not there or has no `Transform`.
    Missing,
    /// It cannot be used.
    Scale(ScaleProblem),
}

/// The pose of an entity now.
pub(crate) fn pose_now(transforms: &TransformHelper, entity: Entity) -> Result<Pose, PoseError> {
    let global = transforms.compute_global_transform(entity).map_err(|_| PoseError::Missing)?;
    pose_of(&global)
}

/// The scale that an entity's pose has in place of the one in its transform: what the entity stands for is scaled already.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(crate) struct OwnScale(pub f32);

/// The pose of an entity now, with a scale of its own where it has one.
pub(crate) fn pose_now_scaled(
    transforms: &TransformHelper,
    entity: Entity,
    own: Option<&OwnScale>,
) -> Result<Pose, PoseError> {
    let Some(own) = own else {
        return pose_now(transforms, entity);
    };
    let global = transforms.compute_global_transform(entity).map_err(|_| PoseError::Missing)?;
    let (_, rotation, translation) = global.to_scale_rotation_translation();
    if global.affine().is_finite() {
        Ok(Pose { translation, rotation: rotation.normalize(), scale: own.0 })
    } else {
        Err(PoseError::Scale(ScaleProblem::NotFinite))
    }
}

/// The pose of a transform whose scale is uniform and positive.
pub(crate) fn pose_of(global: &GlobalTransform) -> Result<Pose, PoseError> {
    let (scale, rotation, translation) = global.to_scale_rotation_translation();
    let (largest, least) = (scale.max_element(), scale.min_element());
    // A rotated child of an unevenly scaled parent is sheared: its axes have even lengths at most
    // by chance, but they do not stand square.
    let axes = global.affine().matrix3;
    let skew = axes.x_axis.dot(axes.y_axis).abs()
        + axes.y_axis.dot(axes.z_axis).abs()
        + axes.z_axis.dot(axes.x_axis).abs();
    let problem = if !global.affine().is_finite() {
        ScaleProblem::NotFinite
    } else if least <= 0.0 {
        ScaleProblem::NotPositive(scale)
    } else if largest - least > 1e-4 * largest {
        ScaleProblem::Uneven(scale)
    } else if skew > 1e-3 * largest * largest {
        ScaleProblem::Sheared(scale)
    } else if !(largest.is_finite() && rotation.is_finite()) {
        ScaleProblem::OutOfRange(largest)
    } else {
        return Ok(Pose { translation, rotation: rotation.normalize(), scale: scale.x });
    };
    Err(PoseError::Scale(problem))
}

/// Whether what went from one pose to another came along with a jump, rather than going its own way.
pub(crate) fn comes_along(jump: &RigidMotion, from: &Pose, to: &Pose) -> bool {
    from != to && distance_of(&jump.apply_to_pose(from), to) < 0.5 * distance_of(from, to)
}

/// A point of the pose's own frame, in the world.
#[inline]
pub(crate) fn to_world(pose: &Pose, point: Vec3) -> Vec3 {
    pose.translation + pose.rotation * (point * pose.scale)
}

/// A point of the world, in the pose's own frame.
#[inline]
pub(crate) fn to_local(pose: &Pose, point: Vec3) -> Vec3 {
    pose.rotation.inverse() * (point - pose.translation) / pose.scale
}

impl From<PoseError> for ClothErrorKind {
    fn from(error: PoseError) -> Self {
        match error {
            PoseError::Missing => Self::NoTransform,
            PoseError::Scale(scale) => Self::Scale(scale),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uneven_and_sheared_scales_are_refused() {
        let pose = |t: Transform| pose_of(&GlobalTransform::from(t));
        assert!(pose(Transform::from_scale(Vec3::splat(2.0))).is_ok());
        assert!(pose(Transform::from_scale(Vec3::new(1.0, 2.0, 1.0))).is_err());
        assert!(pose(Transform::from_scale(Vec3::splat(-1.0))).is_err());
        assert!(pose(Transform::from_scale(Vec3::ZERO)).is_err());
        assert!(pose(Transform::from_xyz(f32::NAN, 0.0, 0.0)).is_err());
        let parent = GlobalTransform::from(Transform::from_scale(Vec3::new(1.0, 1.2, 1.0)));
        let child = Transform::from_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_4));
        assert!(pose_of(&(parent * child)).is_err());
    }
}
