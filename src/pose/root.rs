//! What the topmost ancestor of an entity does in ticks.
//!
//! A game may move a character in its ticks, and animate its joints once a frame. Then a joint moves in every tick, and what the frame has
//! done to it is seen only beside the motion of the character.

use bevy::prelude::*;

use crate::solver::{Pose, RigidMotion};

/// The topmost ancestor of an entity, or itself, and where it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub entity: Entity,
    /// `None` where it cannot be used: it has not moved.
    pub pose: Option<Pose>,
}

impl Root {
    /// The topmost ancestor of an entity that has any, by what is above each.
    pub fn above(entity: Entity, parent: impl Fn(Entity) -> Option<Entity>) -> Option<Entity> {
        core::iter::successors(parent(entity), |it| parent(*it)).last()
    }
}

/// The pose of a root, as it is looked at before each frame's ticks and in each of them.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct RootTrack {
    /// Whose pose it is; `None` after it was loaded.
    #[cfg_attr(feature = "serialize", serde(skip))]
    entity: Option<Entity>,
    /// Where it was seen last.
    seen: Pose,
    /// At the start of the frame, before its ticks.
    noted: Pose,
    /// Where it was before that.
    before: Pose,
    /// The last tick moved it.
    by_ticks: bool,
}

/// How ticks move a root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RootMotion {
    /// From where the ticks of the last frame left it to where this one began: it was shown elsewhere, or put there.
    pub shown: RigidMotion,
    /// From there on in the ticks of this frame.
    pub moved: RigidMotion,
}

impl PartialEq for RootTrack {
    /// Whether it moves in the same way. Whose pose it is is looked at anew.
    fn eq(&self, other: &Self) -> bool {
        let Self { entity: _, seen, noted, before, by_ticks } = *self;
        [seen, noted, before] == [other.seen, other.noted, other.before]
            && by_ticks == other.by_ticks
    }
}

impl RootTrack {
    /// Something newly seen: it has not moved.
    pub fn new(Root { entity, pose }: Root) -> Self {
        let pose = pose.unwrap_or(Pose::IDENTITY);
        Self { entity: Some(entity), seen: pose, noted: pose, before: pose, by_ticks: false }
    }

    /// Whether it could be that of anything.
    pub fn is_sound(&self) -> bool {
        [self.seen, self.noted, self.before].iter().all(Pose::is_valid)
    }

    /// Notes the pose before the ticks of a frame.
    pub fn begin_frame(&mut self, now: Root) {
        let now = self.look(now);
        (self.before, self.noted, self.seen) = (self.seen, now, now);
    }

    /// Lets nothing have been done to it before the frame.
    pub fn at_once(&mut self) {
        self.before = self.noted;
    }

    /// Goes on by a tick. Tells how it has moved, if it is ticks that move it.
    pub fn advance(&mut self, now: Root) -> Option<RootMotion> {
        let now = self.look(now);
        self.seen = now;
        let before = core::mem::replace(&mut self.by_ticks, now != self.noted);
        (before || self.by_ticks).then(|| RootMotion {
            shown: RigidMotion::between(&self.before, &self.noted),
            moved: RigidMotion::between(&self.noted, &now),
        })
    }

    /// Where the root is now. Another one has not come from where the last one was.
    fn look(&mut self, now: Root) -> Pose {
        if self.entity.is_some_and(|entity| entity != now.entity) {
            *self = Self::new(now);
        }
        self.entity = Some(now.entity);
        now.pose.unwrap_or(self.seen)
    }
}
