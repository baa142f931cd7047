//! Whether something is taken in a tick where it is, or on the way that the last frame has put it.

use crate::pose::frames::FrameTicks;
use crate::pose::root::{Root, RootMotion, RootTrack};
use crate::solver::RigidMotion;

/// The course of something through the ticks of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Course {
    /// Where the frame's ticks lie on the way of the last one.
    ticks: FrameTicks,
    /// Ticks that the frame has run.
    done: u32,
    /// The frame takes the whole way in its first tick.
    at_once: bool,
    /// The last tick moved it below its root. An entity without ancestors is its own root.
    by_ticks: bool,
    /// The topmost of its ancestors, or itself.
    root: RootTrack,
}

/// A place on the way that the last frame has put something.
pub(crate) struct OnTheWay {
    /// The part of the way.
    pub part: f32,
    /// How ticks have moved its root meanwhile, if they have.
    pub motion: Option<RootMotion>,
}

impl Course {
    /// The course of something newly seen: it has not moved.
    pub fn new(root: Root) -> Self {
        let (ticks, root) = (FrameTicks::default(), RootTrack::new(root));
        Self { ticks, done: 0, at_once: false, by_ticks: false, root }
    }

    /// Whether it could be that of anything.
    pub fn is_sound(&self) -> bool {
        self.ticks.is_sound() && self.root.is_sound() && self.done <= u32::MAX / 2
    }

    /// Begins a frame.
    pub fn begin_frame(&mut self, root: Root, ticks: FrameTicks) {
        self.root.begin_frame(root);
        (self.ticks, self.done, self.at_once) = (ticks, 0, false);
    }

    /// Lets the frame take the whole way in its next tick: the last frame has put it elsewhere.
    pub fn at_once(&mut self) {
        self.at_once = true;
    }

    /// Goes on by a tick. Tells where it is on its way; `None` where it is taken as it is.
    ///
    /// `stands` says whether it is where the frame noted it, after a motion of its root, and `stood` whether it was there before, as the
    /// root was shown.
    pub fn advance(
        &mut self,
        root: Root,
        stands: impl FnOnce(Option<&RigidMotion>) -> bool,
        stood: impl FnOnce(Option<&RigidMotion>) -> bool,
    ) -> Option<OnTheWay> {
        self.done += 1;
        let motion = self.root.advance(root);
        let by_ticks = !stands(motion.as_ref().map(|it| &it.moved));
        // What ticks move is shown elsewhere between them, and may by chance be shown where it is put back.
        self.at_once |= self.by_ticks && !by_ticks;
        self.by_ticks = by_ticks;
        if by_ticks || self.at_once || stood(motion.as_ref().map(|it| &it.shown)) {
            return None;
        }
        self.ticks.part(self.done).map(|part| OnTheWay { part, motion })
    }
}
