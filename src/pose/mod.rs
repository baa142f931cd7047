//! Where pins and colliders are at a tick's start and at its end.
//!
//! The pose of an entity moved in the fixed schedule is taken as it is. An entity moved once a frame (after
//! the fixed loop, as by an animation) would stand still through a frame's first tick and jump in the
//! next: its motion since the last frame is spread over the ticks of this one.

pub(crate) mod bindposes;
pub(crate) mod skeleton;

use bevy::prelude::*;

use crate::error::ClothErrorKind;
use crate::error::problems::ScaleProblem;
use crate::solver::Pose;

/// A pose from tick to tick: where something is at a tick's start and at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PoseTrack {
    /// At the last tick's start.
    start: Pose,
    /// At its end.
    end: Pose,
    /// At the start of the frame, before its ticks.
    noted: Pose,
    /// `end` at the start of the frame.
    from: Pose,
    /// Ticks that the frame was expected to run.
    ticks: u32,
    /// Ticks that it has run.
    done: u32,
}

impl PoseTrack {
    /// Something newly seen: it has not moved.
    pub fn new(now: Pose) -> Self {
        Self { start: now, end: now, noted: now, from: now, ticks: 0, done: 0 }
    }

    /// Notes the pose before the `ticks` ticks of a frame. A frame without ticks leaves the way to
    /// the next.
    pub fn begin_frame(&mut self, now: Pose, ticks: u32) {
        if ticks > 0 {
            *self = Self { noted: now, from: self.end, ticks, done: 0, ..*self };
        }
    }

    /// Spreads nothing over this frame's ticks: the next one takes the whole way.
    pub fn at_once(&mut self) {
        self.ticks = 0;
    }

    /// Whether it could be that of anything.
    pub fn is_sound(&self) -> bool {
        let Self { start, end, noted, from, ticks: _, done } = self;
        [start, end, noted, from].into_iter().all(Pose::is_valid) && *done <= u32::MAX / 2
    }

    /// The pose at the last tick's start.
    pub fn start(&self) -> Pose {
        self.start
    }

    /// The pose at the last tick's end.
    pub fn end(&self) -> Pose {
        self.end
    }

    /// Whether it moves in the tick.
    pub fn moves(&self) -> bool {
        self.start != self.end
    }

    /// Lets it have come from elsewhere in this tick.
    pub fn come_from(&mut self, start: Pose) {
        self.start = start;
    }

    /// Scales where it has been, about a place. Where it is to be is told in the tick.
    pub fn scale(&mut self, about: Vec3, ratio: f32) {
        for pose in [&mut self.start, &mut self.end, &mut self.from] {
            pose.translation = about + (pose.translation - about) * ratio;
            pose.scale *= ratio;
        }
    }

    /// Goes on by a tick.
    pub fn advance(&mut self, now: Pose) {
        self.start = self.end;
        self.done += 1;
        self.end = if self.done < self.ticks && now == self.noted {
            self.from.interpolate(&self.noted, self.done as f32 / self.ticks as f32)
        } else {
            now
        };
    }
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

    fn at(x: f32) -> Pose {
        Pose { translation: Vec3::X * x, rotation: Quat::IDENTITY, scale: 1.0 }
    }

    fn ways(pose: &mut PoseTrack, now: &[f32]) -> Vec<(f32, f32)> {
        let way = |x: &f32| {
            pose.advance(at(*x));
            (pose.start().translation.x, pose.end().translation.x)
        };
        now.iter().map(way).collect()
    }

    #[test]
    fn new_things_have_not_moved() {
        let mut pose = PoseTrack::new(at(3.0));
        assert_eq!(ways(&mut pose, &[3.0, 3.0]), [(3.0, 3.0), (3.0, 3.0)]);
    }

    #[test]
    fn a_move_once_a_frame_is_spread_over_its_ticks() {
        let mut pose = PoseTrack::new(at(0.0));
        pose.begin_frame(at(4.0), 4);
        let expected = [(0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 4.0)];
        assert_eq!(ways(&mut pose, &[4.0; 4]), expected);
        pose.begin_frame(at(4.0), 1);
        assert_eq!(ways(&mut pose, &[4.0]), [(4.0, 4.0)]);
    }

    #[test]
    fn frames_without_ticks_keep_the_way_for_later() {
        let mut pose = PoseTrack::new(at(0.0));
        pose.begin_frame(at(1.0), 0);
        pose.begin_frame(at(2.0), 0);
        pose.begin_frame(at(4.0), 2);
        assert_eq!(ways(&mut pose, &[4.0; 2]), [(0.0, 2.0), (2.0, 4.0)]);
    }

    #[test]
    fn moves_in_the_fixed_schedule_are_taken_as_they_are() {
        let mut pose = PoseTrack::new(at(0.0));
        pose.begin_frame(at(0.0), 3);
        assert_eq!(ways(&mut pose, &[1.0, 1.5, 7.0]), [(0.0, 1.0), (1.0, 1.5), (1.5, 7.0)]);
    }

    #[test]
    fn more_ticks_than_expected_do_not_overshoot() {
        let mut pose = PoseTrack::new(at(0.0));
        pose.begin_frame(at(2.0), 2);
        assert_eq!(ways(&mut pose, &[2.0; 3]), [(0.0, 1.0), (1.0, 2.0), (2.0, 2.0)]);
    }

    #[test]
    fn rotation_takes_the_shorter_arc() {
        let quarter = Quat::from_rotation_y(1.0);
        let to = Pose { translation: Vec3::ZERO, rotation: -quarter, scale: 1.0 };
        let half = at(0.0).interpolate(&to, 0.5).rotation;
        assert!(half.angle_between(Quat::from_rotation_y(0.5)) < 1e-3);
    }

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
