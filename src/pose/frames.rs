//! Where the ticks of a frame lie between the poses of two frames.
//!
//! Something that moves once a frame is seen before each frame's ticks, where the frame before has put it. A tick takes it where it was at the
//! tick's own time, a frame late: that lies between the last two of these poses, whatever the lengths of frames and ticks. So what moves
//! evenly from frame to frame moves evenly from tick to tick. Were the way of a frame shared among its ticks, then at 60 frames and 64
//! ticks a second two ticks in each fifteenth frame would be half as fast as the others, and shake the cloth.

use core::time::Duration;

use bevy::prelude::*;

/// Frames are regular as long as none takes more than this many times as long as the one before, or the other way round.
const REGULAR: f64 = 1.5;
/// How far the delay may be from a frame's length, as a part of it. What the last pose is not enough for goes on as it went so far.
const SLACK: f64 = 0.25;
/// Part of a frame's length in the mean delay.
const FOLLOWS: f64 = 0.1;
/// Parts of a frame within which a tick is at one of its poses: what rounding makes of that.
const ROUNDING: f32 = 1e-4;

/// The lengths of frames.
#[derive(Resource, Default)]
pub(crate) struct FrameClock {
    /// Length of the frame whose ticks are to come, and of the one before \[s\].
    lengths: [f64; 2],
    /// How late ticks see what moves once a frame, while frames are regular \[s\].
    delay: Option<f64>,
}

/// Where the ticks of a frame lie between the last two poses, from 0 at the first to 1 at the last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct FrameTicks {
    /// Ticks that the frame is expected to run.
    pub count: u32,
    /// Where the end of the last tick before them lies.
    begins: f32,
    /// How much further the end of each one lies.
    step: f32,
}

impl FrameClock {
    /// Begins a frame that is `length` long, in ticks of `tick`. So much time is left over from the ticks before.
    pub fn begin_frame(&mut self, length: Duration, tick: Duration, left: Duration) -> FrameTicks {
        let count = (left + length).as_nanos() / tick.as_nanos().max(1);
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        let [length, tick, left] = [length, tick, left].map(|time| time.as_secs_f64());
        self.lengths = [length, self.lengths[0]];
        let (from, over) = match self.delay() {
            // Evenly over the frame, however long the way took.
            None => (0.0, length),
            Some(delay) => (self.lengths[1] - delay, self.lengths[1]),
        };
        let [begins, step] = [from - left, tick].map(|time| (time / over) as f32);
        if over > 0.0 {
            FrameTicks { count, begins, step }
        } else {
            FrameTicks { count, begins: 1.0, step: 0.0 }
        }
    }

    /// How late the frame's ticks are; `None` where its length is another than before.
    fn delay(&mut self) -> Option<f64> {
        let [length, before] = self.lengths;
        let is_regular =
            length.min(before) > 0.0 && length.max(before) <= REGULAR * length.min(before);
        let near = |delay: &f64| (delay - length).abs() <= SLACK * length;
        let delay = self.delay.filter(near).unwrap_or(length);
        self.delay = is_regular.then_some(delay + FOLLOWS * (length - delay));
        self.delay
    }
}

impl FrameTicks {
    /// Whether it could be that of any frame.
    pub fn is_sound(&self) -> bool {
        self.begins.is_finite() && self.step.is_finite()
    }

    /// Where the end of the tick of this number lies, from 1 on. `None` where it is at the last pose.
    #[inline]
    pub fn part(&self, tick: u32) -> Option<f32> {
        if tick > self.count {
            return None;
        }
        let slack = SLACK as f32;
        let part = (self.begins + self.step * tick as f32).clamp(-slack, 1.0 + slack);
        ((part - 1.0).abs() > ROUNDING).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begin(clock: &mut FrameClock, [length, tick, left]: [f64; 3]) -> FrameTicks {
        let [length, tick, left] = [length, tick, left].map(Duration::from_secs_f64);
        clock.begin_frame(length, tick, left)
    }

    /// Places of what goes on evenly, by a metre a second, at the ends of all ticks of frames of these lengths.
    fn places(lengths: impl IntoIterator<Item = f64>, tick: f64) -> Vec<f64> {
        let (mut clock, mut left) = (FrameClock::default(), Duration::ZERO);
        let (mut poses, mut places) = ([0.0; 2], Vec::new());
        let tick = Duration::from_secs_f64(tick);
        for length in lengths {
            let length = Duration::from_secs_f64(length);
            let ticks = clock.begin_frame(length, tick, left);
            let [from, to] = poses;
            places.extend((1..=ticks.count).map(|tick| {
                let part = ticks.part(tick).map_or(1.0, f64::from);
                from + part * (to - from)
            }));
            left = left + length - tick * ticks.count;
            poses = [to, to + length.as_secs_f64()];
        }
        places
    }

    fn worst_step(places: &[f64], tick: f64) -> f64 {
        let steps = places.windows(2).map(|pair| pair[1] - pair[0] - tick);
        steps.fold(0.0, |worst, step| step.abs().max(worst))
    }

    #[test]
    fn what_goes_evenly_by_frames_goes_evenly_by_ticks() {
        let tick = 1.0 / 64.0;
        for frames in [24.0, 30.0, 50.0, 60.0, 64.0, 75.0, 120.0, 144.0, 240.0] {
            let places = places((0..2 * frames as usize).map(|_| 1.0 / frames), tick);
            assert!(places.len() >= 127, "{frames} a second: {} ticks", places.len());
            let worst = worst_step(&places[8..], tick);
            assert!(worst < 2e-4 * tick, "{frames} a second: a tick is off by {worst:e} s");
        }
    }

    #[test]
    fn frames_that_are_not_quite_regular_go_evenly_too() {
        let tick = 1.0 / 64.0;
        // Off by up to 2 ms.
        let lengths = (0..600).map(|i| 1.0 / 60.0 + 0.002 * ((i * i) as f64).sin());
        let places = places(lengths, tick);
        let worst = worst_step(&places[100..], tick);
        assert!(worst < 0.03 * tick, "a tick is off by {worst:e} s");
    }

    #[test]
    fn a_frame_of_another_length_is_shared_among_its_ticks() {
        let mut clock = FrameClock::default();
        begin(&mut clock, [0.01, 0.01, 0.0]);
        begin(&mut clock, [0.01, 0.01, 0.0]);
        let ticks = begin(&mut clock, [0.04, 0.01, 0.0]);
        let parts = [1, 2, 3, 4, 5].map(|tick| ticks.part(tick));
        let expected = [Some(0.25), Some(0.5), Some(0.75), None, None];
        for (part, expected) in parts.into_iter().zip(expected) {
            let off = part.unwrap_or(1.0) - expected.unwrap_or(1.0);
            assert!(off.abs() < 1e-6, "{parts:?}");
        }
    }

    #[test]
    fn time_that_stands_still_leads_to_the_last_pose() {
        let mut clock = FrameClock::default();
        for _ in 0..3 {
            assert_eq!(begin(&mut clock, [0.0, 0.01, 0.005]).count, 0);
        }
        // Ticks that were shortened meanwhile, and one that time has come for.
        assert_eq!(begin(&mut clock, [0.0, 0.002, 0.005]).part(1), None);
        assert_eq!(begin(&mut clock, [0.01, 0.01, 0.0]).part(1), None);
    }
}
