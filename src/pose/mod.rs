//! Where pins and colliders are at a tick's start and at its end.
//!
//! The pose of an entity moved in the fixed schedule is taken as it is. An entity moved once a frame (after
//! the fixed loop, as by an animation) would stand still through a frame's first tick and jump in the
//! next: it is taken where it was at each tick's time, a frame late ([`frames`]). So is what an animation moves on a character
//! that is moved in the fixed schedule ([`root`]).

pub(crate) mod bindposes;
pub(crate) mod frames;
pub(crate) mod root;
pub(crate) mod skeleton;

use bevy::prelude::*;

use crate::error::ClothErrorKind;
use crate::error::problems::ScaleProblem;
use crate::pose::frames::FrameTicks;
use crate::pose::root::{Root, RootTrack};
pub(crate) use crate::solver::Pose;
use crate::solver::RigidMotion;

/// A pose from tick to tick: where something is at a tick's start and at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PoseTrack {
    /// At the last tick's start.
    start: Pose,
    /// At its end.
    end: Pose,
    /// Where it was seen last.
    seen: Pose,
    /// At the start of the frame, before its ticks.
    noted: Pose,
    /// Where it was before that: what is between them, the last frame has done.
    before: Pose,
    /// Where the frame's ticks lie between the two.
    ticks: FrameTicks,
    /// Ticks that the frame has run.
    done: u32,
    /// The last tick moved it, beside its root.
    by_ticks: bool,
    /// The topmost of its ancestors, or itself.
    root: RootTrack,
}

impl PoseTrack {
    /// Something newly seen: it has not moved.
    pub fn new(Placed { pose: now, root }: Placed) -> Self {
        let ticks = FrameTicks::default();
        let (start, end, seen, noted, before) = (now, now, now, now, now);
        let root = RootTrack::new(root);
        Self { start, end, seen, noted, before, ticks, done: 0, by_ticks: false, root }
    }

    /// Notes the pose before the ticks of a frame.
    pub fn begin_frame(&mut self, Placed { pose: now, root }: Placed, ticks: FrameTicks) {
        let carried = self.root.begin_frame(root);
        self.before = carried.map_or(self.seen, |motion| motion.apply_to_pose(&self.seen));
        (self.noted, self.seen) = (now, now);
        (self.ticks, self.done) = (ticks, 0);
    }

    /// Lets the next tick take the whole way: the last frame has put it elsewhere.
    pub fn at_once(&mut self) {
        self.before = self.noted;
    }

    /// Whether it could be that of anything.
    pub fn is_sound(&self) -> bool {
        let Self { start, end, seen, noted, before, ticks, done, by_ticks: _, root } = self;
        let all = [start, end, seen, noted, before];
        let are_valid = all.into_iter().all(Pose::is_valid) && root.is_sound();
        are_valid && ticks.is_sound() && *done <= u32::MAX / 2
    }

    /// The pose at the last tick's start.
    pub fn start(&self) -> Pose {
        self.start
    }

    /// The pose at the last tick's end.
    pub fn end(&self) -> Pose {
        self.end
    }

    /// The pose when it was last looked at, before a frame's ticks or in one.
    pub fn seen(&self) -> Pose {
        self.seen
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
        for pose in [&mut self.start, &mut self.end, &mut self.before] {
            pose.translation = about + (pose.translation - about) * ratio;
            pose.scale *= ratio;
        }
    }

    /// Goes on by a tick.
    pub fn advance(&mut self, Placed { pose: now, root }: Placed) {
        self.start = self.end;
        self.seen = now;
        self.done += 1;
        let moved = self.root.advance(root);
        let with_root = |pose: &Pose| moved.map_or(*pose, |motion| motion.apply_to_pose(pose));
        let by_ticks = match moved {
            None => now != self.noted,
            Some(_) => !is_near(&now, &with_root(&self.noted)),
        };
        // What ticks move is shown elsewhere between them, and may by chance be shown where it is put back.
        let by_frame = !by_ticks && !self.by_ticks && !is_near(&self.before, &self.noted);
        let part = self.ticks.part(self.done).filter(|_| by_frame);
        let on_the_way = |part| with_root(&on_the_way(&self.before, &self.noted, part));
        self.end = part.map_or(now, on_the_way);
        self.by_ticks = by_ticks;
    }
}

/// An entity's pose, and its root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub pose: Pose,
    pub root: Root,
}

impl Placed {
    /// An entity without ancestors.
    pub fn alone(entity: Entity, pose: Pose) -> Self {
        Self { pose, root: Root { entity, pose } }
    }

    /// An entity, and its topmost ancestor, if it has any.
    pub fn below(
        entity: Entity,
        pose: Pose,
        root: Option<Entity>,
        transforms: &TransformHelper,
    ) -> Self {
        let Some(root) = root else { return Self::alone(entity, pose) };
        // One that cannot be used moves nothing.
        let its = pose_now(transforms, root).unwrap_or(Pose::IDENTITY);
        Self { pose, root: Root { entity: root, pose: its } }
    }
}

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

/// A pose on the way from one to another; the way may have been left a little behind, or be a little ahead.
fn on_the_way(from: &Pose, to: &Pose, part: f32) -> Pose {
    let side = if from.rotation.dot(to.rotation) < 0.0 { -1.0 } else { 1.0 };
    Pose {
        translation: from.translation + (to.translation - from.translation) * part,
        rotation: (from.rotation * (1.0 - part) + to.rotation * (side * part)).normalize(),
        scale: from.scale + (to.scale - from.scale) * part.clamp(0.0, 1.0),
    }
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
    use crate::pose::frames::FrameClock;
    use core::time::Duration;

    fn at(x: f32) -> Pose {
        Pose { translation: Vec3::X * x, rotation: Quat::IDENTITY, scale: 1.0 }
    }

    fn alone(x: f32) -> Placed {
        Placed::alone(Entity::PLACEHOLDER, at(x))
    }

    fn ways(pose: &mut PoseTrack, now: &[f32]) -> Vec<(f32, f32)> {
        let way = |x: &f32| {
            pose.advance(alone(*x));
            (pose.start().translation.x, pose.end().translation.x)
        };
        now.iter().map(way).collect()
    }

    /// A frame that is as long as so many ticks.
    fn ticks(count: u32) -> FrameTicks {
        let tick = Duration::from_millis(16);
        FrameClock::default().begin_frame(tick * count, tick, Duration::ZERO)
    }

    #[test]
    fn new_things_have_not_moved() {
        let mut pose = PoseTrack::new(alone(3.0));
        assert_eq!(ways(&mut pose, &[3.0, 3.0]), [(3.0, 3.0), (3.0, 3.0)]);
    }

    #[test]
    fn a_move_once_a_frame_is_spread_over_its_ticks() {
        let mut pose = PoseTrack::new(alone(0.0));
        pose.begin_frame(alone(4.0), ticks(4));
        let expected = [(0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 4.0)];
        assert_eq!(ways(&mut pose, &[4.0; 4]), expected);
        pose.begin_frame(alone(4.0), ticks(1));
        assert_eq!(ways(&mut pose, &[4.0]), [(4.0, 4.0)]);
    }

    #[test]
    fn frames_without_ticks_are_on_the_way() {
        let mut pose = PoseTrack::new(alone(0.0));
        pose.begin_frame(alone(1.0), ticks(0));
        pose.begin_frame(alone(2.0), ticks(0));
        pose.begin_frame(alone(4.0), ticks(2));
        assert_eq!(ways(&mut pose, &[4.0; 2]), [(0.0, 3.0), (3.0, 4.0)]);
    }

    #[test]
    fn moves_in_the_fixed_schedule_are_taken_as_they_are() {
        let mut pose = PoseTrack::new(alone(0.0));
        pose.begin_frame(alone(0.0), ticks(3));
        assert_eq!(ways(&mut pose, &[1.0, 1.5, 7.0]), [(0.0, 1.0), (1.0, 1.5), (1.5, 7.0)]);
        // It is not what the next frame has done.
        pose.begin_frame(alone(7.0), ticks(2));
        assert_eq!(ways(&mut pose, &[7.0, 7.0]), [(7.0, 7.0); 2]);
    }

    /// An engine that shows its bodies between two ticks puts them back before the next.
    #[test]
    fn what_is_put_back_in_the_tick_is_taken_as_it_is() {
        let mut pose = PoseTrack::new(alone(0.0));
        pose.advance(alone(1.0));
        pose.begin_frame(alone(0.4), ticks(2));
        assert_eq!(ways(&mut pose, &[2.0, 3.0]), [(1.0, 2.0), (2.0, 3.0)]);
        // It stops, and is shown where it is by then.
        pose.begin_frame(alone(2.5), ticks(0));
        pose.begin_frame(alone(3.0), ticks(2));
        assert_eq!(ways(&mut pose, &[3.0, 3.0]), [(3.0, 3.0); 2]);
    }

    /// A joint of a character: frames move it beside the character, which ticks move, and which is shown elsewhere between them.
    #[test]
    fn what_frames_move_on_what_ticks_move_is_on_its_way_there() {
        let joint = |beside: f32, x: f32| {
            let root = Root { entity: Entity::PLACEHOLDER, pose: at(x) };
            Placed { pose: at(x + beside), root }
        };
        let mut pose = PoseTrack::new(joint(0.0, 0.0));
        pose.advance(joint(0.0, 10.0));
        assert_eq!(pose.end(), at(10.0));
        pose.begin_frame(joint(4.0, 9.0), ticks(4));
        let mut ways = [20.0, 30.0, 40.0, 50.0].map(|root| {
            pose.advance(joint(4.0, root));
            pose.end().translation.x
        });
        assert_eq!(ways, [21.0, 32.0, 43.0, 54.0]);
        pose.begin_frame(joint(4.0, 48.0), ticks(2));
        ways[0] = 54.0;
        for (i, root) in [60.0, 60.0].into_iter().enumerate() {
            pose.advance(joint(4.0, root));
            ways[i] = pose.end().translation.x;
        }
        assert_eq!(ways[..2], [64.0, 64.0]);
    }

    #[test]
    fn what_jumps_is_there_at_once() {
        let mut pose = PoseTrack::new(alone(0.0));
        pose.begin_frame(alone(9.0), ticks(3));
        pose.at_once();
        assert_eq!(ways(&mut pose, &[9.0; 2]), [(0.0, 9.0), (9.0, 9.0)]);
    }

    #[test]
    fn more_ticks_than_expected_do_not_overshoot() {
        let mut pose = PoseTrack::new(alone(0.0));
        pose.begin_frame(alone(2.0), ticks(2));
        assert_eq!(ways(&mut pose, &[2.0; 3]), [(0.0, 1.0), (1.0, 2.0), (2.0, 2.0)]);
    }

    #[test]
    fn rotation_takes_the_shorter_arc() {
        let quarter = Quat::from_rotation_y(1.0);
        let to = Pose { translation: Vec3::ZERO, rotation: -quarter, scale: 1.0 };
        let half = on_the_way(&at(0.0), &to, 0.5).rotation;
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
