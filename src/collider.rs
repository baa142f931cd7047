//! What cloths collide with, and where it is in each tick.

mod bake;
mod disturbance;
mod shape;

pub use bake::{BakeSdf, SdfCells};
pub use shape::{CustomSdf, SdfShape};

pub(crate) use bake::{finish_bakes, start_bakes};
pub(crate) use disturbance::{Disturbances, note_disturbances};

use crate::{
    cloth::{
        pose::{MovingPose, pose_now},
        setup::pose_error,
    },
    error::{Blame, ClothError, Failures},
    sdf::{DistanceField, SignedDistance},
    solver::{self, ParameterError, Pose},
};
use bevy::prelude::*;
use std::sync::Arc;

/// Way in a tick from which on a collider has been put elsewhere, and has not gone there \[m\].
const JUMP: f32 = 10.0;

/// A rigid solid that all cloths collide with.
///
/// It follows its entity, which may be scaled alike along all axes; another scale is refused with a
/// [`ClothError`], and the collider is left out as long. May be moved in the fixed schedule
/// or once a frame, and changed at any time. Where it goes more than 10 m in a tick it has been put
/// there, and sweeps nothing on its way.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((SdfCollider::from(Sphere::new(0.5)), Transform::from_xyz(0.0, 1.0, 0.0)));
/// commands.spawn(SdfCollider::from(InfinitePlane3d::default()).with_friction(0.8));
/// # }
/// ```
#[derive(Component, Reflect, Clone, Debug)]
#[reflect(Component, Debug, Clone)]
#[require(Transform, ColliderPose)]
pub struct SdfCollider {
    /// The solid, in the entity's frame.
    pub shape: SdfShape,
    /// Coulomb's coefficient of friction \[1\]. Higher holds better; a pair's is the geometric
    /// mean.
    pub friction: f32,
    /// Whether cloths see it.
    pub enabled: bool,
}

impl SdfCollider {
    /// A collider with a friction of 0.5.
    pub fn new(shape: impl Into<SdfShape>) -> Self {
        Self { shape: shape.into(), friction: 0.5, enabled: true }
    }

    /// A collider of a baked field, see [`BakeSdf`].
    pub fn field(field: Handle<DistanceField>) -> Self {
        Self::new(field)
    }

    /// A collider of any other solid.
    pub fn custom(shape: impl SignedDistance) -> Self {
        Self::new(SdfShape::Custom(CustomSdf(Arc::new(shape))))
    }

    /// With another coefficient of friction \[1\]. Higher holds better.
    pub fn with_friction(self, friction: f32) -> Self {
        Self { friction, ..self }
    }
}

impl<S: Into<SdfShape>> From<S> for SdfCollider {
    fn from(shape: S) -> Self {
        Self::new(shape)
    }
}

/// Where a collider was, is and goes.
#[derive(Component, Default)]
pub(crate) struct ColliderPose(Option<MovingPose>);

/// All colliders of a tick, in the order of their entities.
#[derive(Resource, Default)]
pub(crate) struct ColliderSnapshot(Vec<Gathered>);

struct Gathered {
    entity: Entity,
    shape: SdfShape,
    start: Pose,
    end: Pose,
    friction: f32,
}

impl ColliderSnapshot {
    /// The colliders as the solver takes them, in `room`, which is empty. What is not loaded is
    /// left out.
    pub fn colliders<'a>(
        &'a self,
        fields: Option<&'a Assets<DistanceField>>,
        room: ColliderRoom,
    ) -> Vec<solver::Collider<'a>> {
        let mut colliders = room.reuse();
        colliders.extend(self.0.iter().filter_map(|collider| {
            Some(solver::Collider {
                shape: collider.shape.get(fields)?,
                start: collider.start,
                end: collider.end,
                friction: collider.friction,
            })
        }));
        colliders
    }
}

/// Memory for the solver's colliders, kept from tick to tick.
#[derive(Default)]
pub(crate) struct ColliderRoom(Vec<solver::Collider<'static>>);

impl ColliderRoom {
    /// Empties `used` and keeps its memory.
    pub fn keep(used: Vec<solver::Collider<'_>>) -> Self {
        Self(retype(used))
    }

    /// Takes the memory.
    pub fn reuse<'a>(self) -> Vec<solver::Collider<'a>> {
        retype(self.0)
    }
}

/// The same memory for another lifetime: collecting into equal elements is done in place.
fn retype<'a>(mut used: Vec<solver::Collider<'_>>) -> Vec<solver::Collider<'a>> {
    used.clear();
    used.into_iter().map_while(|_| None).collect()
}

/// Notes where all colliders are before a frame's ticks.
pub(crate) fn note_collider(
    entity: Entity,
    pose: &mut ColliderPose,
    transforms: &TransformHelper,
    ticks: u32,
) {
    if let Some(pose) = &mut pose.0
        && let Ok(now) = pose_now(transforms, entity)
    {
        let before = pose.end();
        pose.begin_frame(now, ticks);
        if has_jumped(&before, &now, ticks) {
            pose.at_once();
        }
    }
}

/// Whether a collider has been put elsewhere; one that moves once a frame has as much room for each of
/// its ticks, four at most.
fn has_jumped(from: &Pose, to: &Pose, ticks: u32) -> bool {
    let most = JUMP * ticks.clamp(1, 4) as f32;
    from.translation.distance_squared(to.translation) > most * most
}

/// Takes the poses of all colliders through the tick.
pub(crate) fn gather_colliders(
    mut colliders: Query<(Entity, &SdfCollider, &mut ColliderPose)>,
    transforms: TransformHelper,
    mut snapshot: ResMut<ColliderSnapshot>,
    mut failures: Failures,
) {
    snapshot.0.clear();
    for (entity, collider, mut pose) in &mut colliders {
        match gather(entity, collider, &mut pose, &transforms) {
            Ok(gathered) => {
                snapshot.0.extend(gathered);
                failures.clear(entity, Blame::Collider);
                failures.clear(entity, Blame::Pose);
            }
            Err(error) => failures.report(entity, error),
        }
    }
    snapshot.0.sort_unstable_by_key(|collider| collider.entity);
}

fn gather(
    entity: Entity,
    collider: &SdfCollider,
    pose: &mut ColliderPose,
    transforms: &TransformHelper,
) -> Result<Option<Gathered>, ClothError> {
    let friction = collider.friction;
    if !(0.0..=1e3).contains(&friction) {
        let problem = ParameterError { name: "friction", value: friction, range: "from 0 to 1000" };
        return Err(ClothError::Parameter { entity, component: "SdfCollider", problem });
    }
    let now = match pose_now(transforms, entity) {
        Ok(now) => now,
        Err(error) => {
            // What comes back later has not moved from where it was lost.
            pose.0 = None;
            return Err(pose_error(entity, error));
        }
    };
    let (start, end) = pose.0.get_or_insert(MovingPose::new(now)).advance(now);
    let start = if has_jumped(&start, &end, 1) { end } else { start };
    let shape = collider.shape.clone();
    Ok(collider.enabled.then_some(Gathered { entity, shape, start, end, friction }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::ecs::system::RunSystemOnce;

    #[derive(Component)]
    struct Other;

    #[test]
    fn colliders_are_in_the_order_of_their_entities() {
        let mut world = World::new();
        world.init_resource::<ColliderSnapshot>();
        let entities: Vec<_> =
            (0..6).map(|_| world.spawn(SdfCollider::from(Sphere::default())).id()).collect();
        // Another archetype, which Bevy visits later.
        for entity in &entities[2..4] {
            world.entity_mut(*entity).insert(Other);
        }
        world.run_system_once(gather_colliders).unwrap();
        let gathered: Vec<_> =
            world.resource::<ColliderSnapshot>().0.iter().map(|collider| collider.entity).collect();
        let mut sorted = gathered.clone();
        sorted.sort_unstable();
        assert_eq!((gathered.len(), &gathered), (6, &sorted));
    }

    #[test]
    fn the_room_for_colliders_is_kept() {
        let sphere = Sphere::new(1.0);
        let pose = Pose::IDENTITY;
        let collider = solver::Collider { shape: &sphere, start: pose, end: pose, friction: 0.5 };
        let used = vec![collider; 10];
        let at = used.as_ptr().addr();
        let again = ColliderRoom::keep(used).reuse();
        assert_eq!((again.len(), again.as_ptr().addr()), (0, at));
        assert!(again.capacity() >= 10);
    }
}
