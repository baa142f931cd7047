//! The topmost ancestor of an entity, as ticks move it.
//!
//! A game may move a character in its ticks, and animate its joints once a frame. Then a joint moves in every tick, and what the frame has
//! done to it is seen only beside the motion of the character.

use bevy::prelude::*;

use crate::pose::pose_of;
use crate::solver::{Pose, RigidMotion};

/// The topmost ancestor of an entity, or itself, and where it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub entity: Entity,
    /// `None` where it cannot be used: it has not moved.
    pub pose: Option<Pose>,
}

/// An entity's pose, and its root.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    pub pose: Pose,
    pub root: Root,
}

impl Root {
    /// The root of an entity, by the transform and the parent of each.
    pub fn of(
        entity: Entity,
        place: impl Fn(Entity) -> Option<(Transform, Option<Entity>)>,
    ) -> Self {
        let (mut root, mut found) = (entity, place(entity));
        while let Some((_, Some(parent))) = found {
            (root, found) = (parent, place(parent));
        }
        let pose = found.and_then(|(place, _)| pose_of(&GlobalTransform::from(place)).ok());
        Self { entity: root, pose }
    }
}

impl Placed {
    /// An entity without ancestors.
    pub fn alone(entity: Entity, pose: Pose) -> Self {
        Self { pose, root: Root { entity, pose: Some(pose) } }
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
