//! Where something is from tick to tick.

use bevy::prelude::*;

use crate::pose::course::{Course, OnTheWay};
use crate::pose::frames::FrameTicks;
use crate::pose::is_near;
use crate::pose::root::Placed;
use crate::solver::{Pose, RigidMotion};

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
    course: Course,
}

impl PoseTrack {
    /// Something newly seen: it has not moved.
    pub fn new(Placed { pose: now, root }: Placed) -> Self {
        let course = Course::new(root);
        Self { start: now, end: now, seen: now, noted: now, before: now, course }
    }

    /// Notes the pose before the ticks of a frame.
    pub fn begin_frame(&mut self, Placed { pose: now, root }: Placed, ticks: FrameTicks) {
        self.course.begin_frame(root, ticks);
        // It may have been nowhere.
        self.before = if self.seen.is_valid() { self.seen } else { now };
        (self.noted, self.seen) = (now, now);
    }

    /// Lets the next tick take the whole way: the last frame has put it elsewhere.
    pub fn at_once(&mut self) {
        self.course.at_once();
    }

    /// Whether it could be that of anything.
    pub fn is_sound(&self) -> bool {
        let Self { start, end, seen, noted, before, course } = self;
        let all = [start, end, seen, noted, before];
        all.into_iter().all(Pose::is_valid) && course.is_sound()
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

    /// Scales where it has been in ticks, about a place, and where it was seen, about another. Where it is to be is told in the tick.
    pub fn scale(&mut self, [about, about_seen]: [Vec3; 2], ratio: f32) {
        let ticks = [&mut self.start, &mut self.end].map(|pose| (pose, about));
        let frames = [&mut self.seen, &mut self.before].map(|pose| (pose, about_seen));
        for (pose, about) in ticks.into_iter().chain(frames) {
            pose.translation = about + (pose.translation - about) * ratio;
            pose.scale *= ratio;
        }
    }

    /// Goes on by a tick.
    pub fn advance(&mut self, Placed { pose: now, root }: Placed) {
        self.start = self.end;
        self.seen = now;
        let Self { noted, before, course, .. } = self;
        let stands = |moved: Option<&RigidMotion>| match moved {
            None => now == *noted,
            Some(_) => is_near(&now, &moved_by(moved, noted)),
        };
        let stood = |shown: Option<&RigidMotion>| is_near(&moved_by(shown, before), noted);
        self.end = match course.advance(root, stands, stood) {
            None => now,
            Some(OnTheWay { part, motion }) => {
                let [shown, moved] = [motion.map(|it| it.shown), motion.map(|it| it.moved)];
                let there = on_the_way(&moved_by(shown.as_ref(), before), noted, part);
                moved_by(moved.as_ref(), &there)
            }
        };
    }
}

/// Where a motion takes a pose, if there is one.
fn moved_by(motion: Option<&RigidMotion>, pose: &Pose) -> Pose {
    motion.map_or(*pose, |motion| motion.apply_to_pose(pose))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::frames::FrameClock;
    use crate::pose::root::Root;
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
            let root = Root { entity: Entity::PLACEHOLDER, pose: Some(at(x)) };
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

    /// Something on a root that stands still: a tick has moved it, a frame does, and it stops. It goes back at no time.
    #[test]
    fn what_frames_move_after_ticks_goes_there_at_once() {
        let root = Root { entity: Entity::PLACEHOLDER, pose: Some(at(0.0)) };
        let on_root = |x: f32| Placed { pose: at(x), root };
        let mut clock = FrameClock::default();
        let (tick, left) = (Duration::from_millis(16), Duration::from_millis(5));
        let mut frame = || clock.begin_frame(2 * tick, tick, left);
        let mut pose = PoseTrack::new(on_root(0.0));
        (0..4).for_each(|_| {
            frame();
        });
        pose.begin_frame(on_root(0.0), frame());
        pose.advance(on_root(0.5));
        pose.advance(on_root(1.0));
        pose.begin_frame(on_root(2.0), frame());
        for _ in 0..2 {
            pose.advance(on_root(2.0));
            assert_eq!(pose.end(), at(2.0));
        }
        // From then on it is on its way.
        pose.begin_frame(on_root(3.0), frame());
        pose.advance(on_root(3.0));
        assert!((2.0..2.5).contains(&pose.end().translation.x), "{:?}", pose.end());
    }

    #[test]
    fn what_is_scaled_is_not_on_its_way_back() {
        let scaled = |scale: f32| Placed::alone(Entity::PLACEHOLDER, Pose { scale, ..at(1.0) });
        let mut clock = FrameClock::default();
        let (tick, left) = (Duration::from_millis(16), Duration::from_millis(5));
        let mut frame = || clock.begin_frame(tick, tick, left);
        let mut pose = PoseTrack::new(scaled(1.0));
        for _ in 0..4 {
            pose.begin_frame(scaled(1.0), frame());
            pose.advance(scaled(1.0));
        }
        pose.scale([Vec3::X; 2], 2.0);
        pose.begin_frame(scaled(2.0), frame());
        pose.advance(scaled(2.0));
        assert_eq!((pose.start(), pose.end()), (scaled(2.0).pose, scaled(2.0).pose));
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
}
