//! Where a collider came from, taken out and put back with the cloths that it meets.

use bevy::prelude::*;

use crate::collider::tick_colliders::ColliderPose;
use crate::pose::track::PoseTrack;

/// The way of a moving collider so far, which the next tick starts from: what
/// [`ClothSnapshot`](crate::ClothSnapshot) is to a cloth.
///
/// It is taken by [`SdfColliderSnapshot::of`]. Put on an entity with an [`SdfCollider`](crate::SdfCollider) it is
/// taken over, and is gone after the next tick. A collider that is loaded without it has not moved, and wakes
/// cloths that sleep near it.
///
/// With the feature `serialize` it is read and written by serde, in a form that has a version.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque, Component, Debug, PartialEq, Clone)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(ColliderPose)]
pub struct SdfColliderSnapshot {
    pose: PoseTrack,
}

impl SdfColliderSnapshot {
    /// The state of a collider; `None` where there is none, or no tick has seen it.
    pub fn of(collider: EntityRef) -> Option<Self> {
        let pose = collider.get::<ColliderPose>()?;
        Some(Self { pose: *pose.moving()? })
    }
}

#[cfg(feature = "serialize")]
crate::serialize::versioned!(SdfColliderSnapshot, pose: PoseTrack);

/// Takes over a state as soon as it is there. One that is damaged is that of a collider that has not moved.
pub(crate) fn restore_collider(
    inserted: On<Insert, SdfColliderSnapshot>,
    mut colliders: Query<(&SdfColliderSnapshot, &mut ColliderPose)>,
) {
    if let Ok((state, mut pose)) = colliders.get_mut(inserted.entity)
        && state.pose.is_sound()
    {
        pose.come_from(state.pose);
    }
}

/// By now it has been seen.
pub(crate) fn forget_states(
    states: Query<Entity, With<SdfColliderSnapshot>>,
    mut commands: Commands,
) {
    for entity in &states {
        commands.entity(entity).try_remove::<SdfColliderSnapshot>();
    }
}
