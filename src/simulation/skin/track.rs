//! The joints of a skin from tick to tick.

use bevy::math::{Affine3A, Mat3A};

/// The matrices that move a skinned mesh, at a tick's end. What moves once a frame is spread over the frame's ticks, as
/// [`PoseTrack`](crate::pose::PoseTrack) does for poses: between two matrices in proportion, so that every vertex goes straight.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SkinTrack {
    /// At the last tick's end.
    end: Vec<Affine3A>,
    /// At the start of the frame, before its ticks.
    noted: Vec<Affine3A>,
    /// `end` at the start of the frame.
    from: Vec<Affine3A>,
    /// Ticks that the frame was expected to run.
    ticks: u32,
    /// Ticks that it has run.
    done: u32,
}

impl SkinTrack {
    /// Something newly seen: it has not moved.
    pub fn new(now: Vec<Affine3A>) -> Self {
        Self { noted: now.clone(), from: now.clone(), end: now, ticks: 0, done: 0 }
    }

    /// Whether it could be that of so many joints.
    pub fn is_sound(&self, joints: usize) -> bool {
        let Self { end, noted, from, ticks: _, done } = self;
        let sound =
            |all: &Vec<Affine3A>| all.len() == joints && all.iter().all(Affine3A::is_finite);
        [end, noted, from].into_iter().all(sound) && *done <= u32::MAX / 2
    }

    /// The matrices at the last tick's end.
    pub fn end(&self) -> &[Affine3A] {
        &self.end
    }

    /// Notes the matrices before the `ticks` ticks of a frame.
    pub fn begin_frame(&mut self, now: &[Affine3A], ticks: u32) {
        self.noted.copy_from_slice(now);
        self.from.copy_from_slice(&self.end);
        (self.ticks, self.done) = (ticks, 0);
    }

    /// Spreads nothing over this frame's ticks: the next one takes the whole way.
    pub fn at_once(&mut self) {
        self.ticks = 0;
    }

    /// Goes on by a tick. Tells whether anything moves in it.
    pub fn advance(&mut self, now: &[Affine3A]) -> bool {
        self.done += 1;
        let is_spread = self.done < self.ticks && now == self.noted && self.from != self.noted;
        if is_spread {
            let part = self.done as f32 / self.ticks as f32;
            for (end, (from, to)) in self.end.iter_mut().zip(self.from.iter().zip(&self.noted)) {
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
    use bevy::math::{Quat, Vec3};

    fn at(x: f32) -> Vec<Affine3A> {
        vec![Affine3A::IDENTITY, Affine3A::from_rotation_translation(Quat::IDENTITY, Vec3::X * x)]
    }

    fn ways(track: &mut SkinTrack, now: &[f32]) -> Vec<(bool, f32)> {
        let way = |x: &f32| (track.advance(&at(*x)), track.end()[1].translation.x);
        now.iter().map(way).collect()
    }

    #[test]
    fn joints_go_through_ticks_as_poses_do() {
        let mut track = SkinTrack::new(at(0.0));
        assert_eq!(ways(&mut track, &[0.0]), [(false, 0.0)]);
        track.begin_frame(&at(4.0), 4);
        let spread = [(true, 1.0), (true, 2.0), (true, 3.0), (true, 4.0)];
        assert_eq!(ways(&mut track, &[4.0; 4]), spread);
        track.begin_frame(&at(4.0), 2);
        assert_eq!(ways(&mut track, &[4.0; 2]), [(false, 4.0); 2]);
        // What moves in the ticks is taken as it is.
        assert_eq!(ways(&mut track, &[5.0, 7.0, 7.0]), [(true, 5.0), (true, 7.0), (false, 7.0)]);
        track.begin_frame(&at(10.0), 3);
        track.at_once();
        assert_eq!(ways(&mut track, &[10.0; 2]), [(true, 10.0), (false, 10.0)]);
        // More ticks than expected do not overshoot.
        track.begin_frame(&at(12.0), 2);
        assert_eq!(ways(&mut track, &[12.0; 3]), [(true, 11.0), (true, 12.0), (false, 12.0)]);
    }
}
