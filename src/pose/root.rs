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
    pub pose: Pose,
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
    /// The last tick moved it.
    by_ticks: bool,
}

impl PartialEq for RootTrack {
    /// Whether it moves in the same way. Whose pose it is is looked at anew.
    fn eq(&self, other: &Self) -> bool {
        let of = |Self { entity: _, seen, noted, by_ticks }: &Self| (*seen, *noted, *by_ticks);
        of(self) == of(other)
    }
}

impl RootTrack {
    /// Something newly seen: it has not moved.
    pub fn new(Root { entity, pose }: Root) -> Self {
        Self { entity: Some(entity), seen: pose, noted: pose, by_ticks: false }
    }

    /// Whether it could be that of anything.
    pub fn is_sound(&self) -> bool {
        self.seen.is_valid() && self.noted.is_valid()
    }

    /// Notes the pose before the ticks of a frame. Tells how that has carried what hangs on it, if it is ticks that move it: between
    /// them it may be shown elsewhere.
    pub fn begin_frame(&mut self, now: Root) -> Option<RigidMotion> {
        self.be(&now);
        let carried = self.by_ticks.then(|| RigidMotion::between(&self.seen, &now.pose));
        (self.seen, self.noted) = (now.pose, now.pose);
        carried
    }

    /// Goes on by a tick. Tells how the frame's ticks have moved it, if they have.
    pub fn advance(&mut self, now: Root) -> Option<RigidMotion> {
        self.be(&now);
        self.seen = now.pose;
        self.by_ticks = now.pose != self.noted;
        self.by_ticks.then(|| RigidMotion::between(&self.noted, &now.pose))
    }

    /// Becomes the track of this root. Another one has not come from where the last one was.
    fn be(&mut self, now: &Root) {
        if self.entity.is_some_and(|entity| entity != now.entity) {
            *self = Self::new(*now);
        }
        self.entity = Some(now.entity);
    }
}
