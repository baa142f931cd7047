//! The joints of a skin from tick to tick.

use bevy::math::{Affine3A, Mat3A};

use crate::pose::frames::FrameTicks;

/// The matrices that move a skinned mesh, at a tick's end. What moves once a frame is taken where it was at each tick's time, as
/// [`PoseTrack`](crate::pose::PoseTrack) does for poses: between two matrices in proportion, so that every vertex goes straight.
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
    /// Where the frame's ticks lie between the two.
    ticks: FrameTicks,
    /// Ticks that the frame has run.
    done: u32,
}

impl SkinTrack {
    /// Something newly seen: it has not moved.
    pub fn new(now: Vec<Affine3A>) -> Self {
        let (seen, noted, before) = (now.clone(), now.clone(), now.clone());
        Self { end: now, seen, noted, before, ticks: FrameTicks::default(), done: 0 }
    }

    /// Whether it could be that of so many joints.
    pub fn is_sound(&self, joints: usize) -> bool {
        let Self { end, seen, noted, before, ticks, done } = self;
        let sound =
            |all: &Vec<Affine3A>| all.len() == joints && all.iter().all(Affine3A::is_finite);
        let all = [end, seen, noted, before];
        all.into_iter().all(sound) && ticks.is_sound() && *done <= u32::MAX / 2
    }

    /// The matrices at the last tick's end.
    pub fn end(&self) -> &[Affine3A] {
        &self.end
    }

    /// Notes the matrices before the ticks of a frame.
    pub fn begin_frame(&mut self, now: &[Affine3A], ticks: FrameTicks) {
        self.before.copy_from_slice(&self.seen);
        self.noted.copy_from_slice(now);
        self.seen.copy_from_slice(now);
        (self.ticks, self.done) = (ticks, 0);
    }

    /// Lets the next tick take the whole way: the last frame has put them elsewhere.
    pub fn at_once(&mut self) {
        self.before.copy_from_slice(&self.noted);
    }

    /// Goes on by a tick. Tells whether anything moves in it.
    pub fn advance(&mut self, now: &[Affine3A]) -> bool {
        self.done += 1;
        self.seen.copy_from_slice(now);
        let part = self.ticks.part(self.done).filter(|_| now == self.noted && now != self.before);
        if let Some(part) = part {
            for (end, (from, to)) in self.end.iter_mut().zip(self.before.iter().zip(now)) {
                *end = between(from, to, part);
            }
            return true;
        }
        let moves = now != self.end;
        self.end.copy_from_slice(now);
        moves
    }
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
    use bevy::math::{Quat, Vec3};
    use core::time::Duration;

    fn at(x: f32) -> Vec<Affine3A> {
        vec![Affine3A::IDENTITY, Affine3A::from_rotation_translation(Quat::IDENTITY, Vec3::X * x)]
    }

    /// A frame that is as long as so many ticks.
    fn ticks(count: u32) -> FrameTicks {
        let tick = Duration::from_millis(16);
        FrameClock::default().begin_frame(tick * count, tick, Duration::ZERO)
    }

    fn ways(track: &mut SkinTrack, now: &[f32]) -> Vec<(bool, f32)> {
        let way = |x: &f32| (track.advance(&at(*x)), track.end()[1].translation.x);
        now.iter().map(way).collect()
    }

    #[test]
    fn joints_go_through_ticks_as_poses_do() {
        let mut track = SkinTrack::new(at(0.0));
        assert_eq!(ways(&mut track, &[0.0]), [(false, 0.0)]);
        track.begin_frame(&at(4.0), ticks(4));
        let spread = [(true, 1.0), (true, 2.0), (true, 3.0), (true, 4.0)];
        assert_eq!(ways(&mut track, &[4.0; 4]), spread);
        track.begin_frame(&at(4.0), ticks(2));
        assert_eq!(ways(&mut track, &[4.0; 2]), [(false, 4.0); 2]);
        // What moves in the ticks is taken as it is.
        assert_eq!(ways(&mut track, &[5.0, 7.0, 7.0]), [(true, 5.0), (true, 7.0), (false, 7.0)]);
        track.begin_frame(&at(10.0), ticks(3));
        track.at_once();
        assert_eq!(ways(&mut track, &[10.0; 2]), [(true, 10.0), (false, 10.0)]);
        // More ticks than expected do not overshoot.
        track.begin_frame(&at(12.0), ticks(2));
        assert_eq!(ways(&mut track, &[12.0; 3]), [(true, 11.0), (true, 12.0), (false, 12.0)]);
    }
}
