//! The joints of a skin from tick to tick.

use bevy::math::{Affine3A, Mat3A};

use crate::pose::course::{Course, OnTheWay};
use crate::pose::frames::FrameTicks;
use crate::pose::root::Root;
use crate::solver::RigidMotion;

/// The matrices that move a skinned mesh, at a tick's end. What moves once a frame is taken where it was at each tick's time, as
/// [`PoseTrack`](crate::pose::track::PoseTrack) does for poses: between two matrices in proportion, so that every vertex goes straight.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SkinTrack {
    /// At the last tick's end.
    end: Vec<Affine3A>,
    /// When they were seen last.
    seen: Vec<Affine3A>,
    /// At the start of the frame, before its ticks.
    noted: Vec<Affine3A>,
    /// Before that: what is between them, the last frame has done.
    before: Vec<Affine3A>,
    course: Course,
}

impl SkinTrack {
    /// Something newly seen: it has not moved.
    pub fn new(now: Vec<Affine3A>, root: Root) -> Self {
        let (seen, noted, before) = (now.clone(), now.clone(), now.clone());
        Self { end: now, seen, noted, before, course: Course::new(root) }
    }

    /// Whether it could be that of so many joints.
    pub fn is_sound(&self, joints: usize) -> bool {
        let Self { end, seen, noted, before, course } = self;
        let sound =
            |all: &Vec<Affine3A>| all.len() == joints && all.iter().all(Affine3A::is_finite);
        [end, seen, noted, before].into_iter().all(sound) && course.is_sound()
    }

    /// The matrices at the last tick's end.
    pub fn end(&self) -> &[Affine3A] {
        &self.end
    }

    /// Notes the matrices before the ticks of a frame, and where the root is.
    pub fn begin_frame(&mut self, now: &[Affine3A], root: Root, ticks: FrameTicks) {
        self.course.begin_frame(root, ticks);
        // They may have been nowhere.
        let are_known = self.seen.iter().all(Affine3A::is_finite);
        self.before.copy_from_slice(if are_known { &self.seen } else { now });
        self.noted.copy_from_slice(now);
        self.seen.copy_from_slice(now);
    }

    /// Lets the next tick take the whole way: the last frame has put them elsewhere.
    pub fn at_once(&mut self) {
        self.course.at_once();
    }

    /// Goes on by a tick. Tells whether anything moves in it.
    pub fn advance(&mut self, now: &[Affine3A], root: Root) -> bool {
        self.seen.copy_from_slice(now);
        let Self { end, noted, before, course, .. } = self;
        let stands = |moved: Option<&RigidMotion>| match moved.map(affine) {
            None => now == *noted,
            Some(moved) => {
                let mut both = now.iter().zip(&*noted);
                both.all(|(now, noted)| is_near(now, &(moved * *noted)))
            }
        };
        let stood = |shown: Option<&RigidMotion>| {
            let (shown, mut both) = (affine_of(shown), before.iter().zip(&*noted));
            both.all(|(before, noted)| is_near(&(shown * *before), noted))
        };
        let Some(OnTheWay { part, motion }) = course.advance(root, stands, stood) else {
            let moves = now != *end;
            end.copy_from_slice(now);
            return moves;
        };
        let shown = affine_of(motion.as_ref().map(|it| &it.shown));
        let moved = affine_of(motion.as_ref().map(|it| &it.moved));
        for (end, (before, noted)) in end.iter_mut().zip(before.iter().zip(&*noted)) {
            *end = moved * between(&(shown * *before), noted, part);
        }
        true
    }
}

/// A motion as a matrix, if there is one.
fn affine_of(motion: Option<&RigidMotion>) -> Affine3A {
    motion.map_or(Affine3A::IDENTITY, affine)
}

/// A motion as a matrix.
fn affine(motion: &RigidMotion) -> Affine3A {
    let RigidMotion { pivot, rotation, shift } = *motion;
    Affine3A::from_rotation_translation(rotation, pivot + shift - rotation * pivot)
}

/// How far two matrices are from each other, where a turn by a radian counts as a metre.
fn distance_of(one: &Affine3A, other: &Affine3A) -> f32 {
    let axes = one.matrix3 - other.matrix3;
    let turn = axes.x_axis.length().max(axes.y_axis.length()).max(axes.z_axis.length());
    // A model of another unit has axes of another length.
    let length = other.matrix3.x_axis.length().max(f32::MIN_POSITIVE);
    one.translation.distance(other.translation) + turn / length
}

/// Whether two matrices are the same but for rounding.
fn is_near(one: &Affine3A, other: &Affine3A) -> bool {
    one == other || distance_of(one, other) < 1e-5 + 1e-6 * other.translation.length()
}

/// A matrix at a part of the way from one to another.
fn between(from: &Affine3A, to: &Affine3A, part: f32) -> Affine3A {
    let (a, b) = (&from.matrix3, &to.matrix3);
    Affine3A {
        matrix3: Mat3A::from_cols(
            a.x_axis.lerp(b.x_axis, part),
            a.y_axis.lerp(b.y_axis, part),
            a.z_axis.lerp(b.z_axis, part),
        ),
        translation: from.translation.lerp(to.translation, part),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::frames::FrameClock;
    use crate::solver::Pose;
    use bevy::ecs::entity::Entity;
    use bevy::math::{Quat, Vec3};
    use core::time::Duration;

    const ROOT: Root = Root { entity: Entity::PLACEHOLDER, pose: Some(Pose::IDENTITY) };

    fn at(x: f32) -> Vec<Affine3A> {
        vec![Affine3A::IDENTITY, Affine3A::from_rotation_translation(Quat::IDENTITY, Vec3::X * x)]
    }

    /// A frame that is as long as so many ticks.
    fn ticks(count: u32) -> FrameTicks {
        let tick = Duration::from_millis(16);
        FrameClock::default().begin_frame(tick * count, tick, Duration::ZERO)
    }

    fn ways(track: &mut SkinTrack, now: &[f32]) -> Vec<(bool, f32)> {
        let way = |x: &f32| (track.advance(&at(*x), ROOT), track.end()[1].translation.x);
        now.iter().map(way).collect()
    }

    #[test]
    fn joints_go_through_ticks_as_poses_do() {
        let mut track = SkinTrack::new(at(0.0), ROOT);
        assert_eq!(ways(&mut track, &[0.0]), [(false, 0.0)]);
        track.begin_frame(&at(4.0), ROOT, ticks(4));
        let spread = [(true, 1.0), (true, 2.0), (true, 3.0), (true, 4.0)];
        assert_eq!(ways(&mut track, &[4.0; 4]), spread);
        track.begin_frame(&at(4.0), ROOT, ticks(2));
        assert_eq!(ways(&mut track, &[4.0; 2]), [(false, 4.0); 2]);
        // What moves in the ticks is taken as it is.
        assert_eq!(ways(&mut track, &[5.0, 7.0, 7.0]), [(true, 5.0), (true, 7.0), (false, 7.0)]);
        track.begin_frame(&at(10.0), ROOT, ticks(3));
        track.at_once();
        assert_eq!(ways(&mut track, &[10.0; 2]), [(true, 10.0), (false, 10.0)]);
        // More ticks than expected do not overshoot.
        track.begin_frame(&at(12.0), ROOT, ticks(2));
        assert_eq!(ways(&mut track, &[12.0; 3]), [(true, 11.0), (true, 12.0), (false, 12.0)]);
    }

    /// A joint that frames move on a character that ticks move, which is shown elsewhere between them.
    #[test]
    fn joints_that_frames_move_are_on_their_way_on_what_ticks_move() {
        let root = |x: f32| {
            let pose = Pose { translation: Vec3::X * x, ..Pose::IDENTITY };
            Root { pose: Some(pose), ..ROOT }
        };
        let joints = |beside: f32, x: f32| {
            [0.0, beside].map(|beside| Affine3A::from_translation(Vec3::X * (x + beside)))
        };
        let mut track = SkinTrack::new(joints(0.0, 0.0).to_vec(), root(0.0));
        track.advance(&joints(0.0, 10.0), root(10.0));
        track.begin_frame(&joints(4.0, 9.0), root(9.0), ticks(4));
        for (tick, expected) in [21.0, 32.0, 43.0, 54.0].into_iter().enumerate() {
            let x = 20.0 + 10.0 * tick as f32;
            assert!(track.advance(&joints(4.0, x), root(x)));
            let [own, joint] = [0, 1].map(|i| track.end()[i].translation.x);
            assert_eq!((own, joint), (x, expected));
        }
    }
}
