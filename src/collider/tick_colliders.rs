//! Where all colliders are in a tick: kept from tick to tick, and looked at again only where something
//! of them has changed.

use bevy::ecs::entity_disabling::Disabled;
use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::collider::impulse::ColliderImpulse;
use crate::collider::load::FieldSource;
use crate::collider::shape::SdfShape;
use crate::collider::tick_body::{LoneBody, TickBody};
use crate::collider::{JUMP, SdfCollider, SdfColliderDisabled};
use crate::error::failures::{Blame, Failures};
use crate::error::{ClothComponent, ClothErrorKind};
use crate::pose::frames::FrameTicks;
use crate::pose::moves::Moves;
use crate::pose::root::Placed;
use crate::pose::track::PoseTrack;
use crate::pose::{OwnScale, PoseError, comes_along, pose_now_scaled, to_world};
use crate::sdf::DistanceField;
use crate::solver::{self, ColliderMotion, Pose, RigidMotion};

/// Where a collider was, is and goes.
#[derive(Component, Default)]
pub(crate) struct ColliderPose {
    /// Boxed, so that looking over those that stand still passes through little memory.
    moving: Option<Box<PoseTrack>>,
    /// The collider stood still in the last tick: as long as nothing of it changes there is nothing to do.
    still: bool,
    /// Whether its impulse was asked for.
    measured: bool,
    /// Whether cloths passed through it.
    disabled: bool,
}

impl ColliderPose {
    /// The collider's motion so far, if a tick has seen it.
    pub(crate) fn moving(&self) -> Option<&PoseTrack> {
        self.moving.as_deref()
    }

    /// Lets the collider go on from a motion.
    pub(crate) fn come_from(&mut self, pose: PoseTrack) {
        self.moving = Some(Box::new(pose));
        self.still = false;
    }
}

/// All colliders of a tick, in the order of their entities.
#[derive(Resource, Default)]
pub(crate) struct TickColliders {
    pub(crate) colliders: Vec<Gathered>,
    /// Bodies that are no colliders.
    pub(crate) lone_bodies: Vec<LoneBody>,
    /// Counts the changes: as long as it stays, all stand still and are what they were.
    pub(crate) version: u64,
}

/// A collider as it is in the tick.
pub(crate) struct Gathered {
    pub entity: Entity,
    pub shape: SdfShape,
    /// `None` while its field is not there.
    pub motion: Option<ColliderMotion>,
    pub friction: f32,
    pub layers: ClothLayers,
    pub measured: bool,
    /// The body that it is a part of, if cloths move it.
    pub body: Option<TickBody>,
}

impl TickColliders {
    /// The colliders as the solver takes them, in `room`, which is empty. What is not loaded is
    /// left out.
    pub fn colliders<'a>(
        &'a self,
        fields: Option<&'a Assets<DistanceField>>,
        room: ColliderRoom,
    ) -> Vec<solver::Collider<'a>> {
        let mut colliders = room.reuse();
        colliders.extend(self.present().filter_map(|(collider, motion)| {
            let known = solver::Collider {
                shape: collider.shape.get(fields)?,
                motion,
                friction: collider.friction,
                layers: collider.layers.0,
                key: collider.entity.to_bits(),
                measured: collider.measured,
                centre: Vec3::ZERO,
                body: 0,
                mobility: None,
            };
            Some(collider.body.map_or(known, |body| body.of(known)))
        }));
        let lone = |it: &LoneBody| -> solver::Collider<'a> { it.collider() };
        colliders.extend(self.lone_bodies.iter().map(lone));
        colliders
    }

    /// The bodies of the tick's colliders, each with its centre \[m\], with the places of the colliders and their keys.
    pub(crate) fn bodies(
        &self,
        fields: Option<&Assets<DistanceField>>,
    ) -> impl Iterator<Item = (usize, &TickBody, Vec3, u64)> {
        let present = self.present().filter(move |(it, _)| it.shape.get(fields).is_some());
        let present = present.map(|(it, motion)| (it.body.as_ref(), motion, it.entity.to_bits()));
        let lone = self.lone_bodies.iter();
        let lone = lone.map(|it| (Some(&it.body), it.motion, it.body.entity.to_bits()));
        let all = present.chain(lone).enumerate();
        all.filter_map(|(place, (body, motion, key))| {
            let body = body?;
            Some((place, body, to_world(&motion.end(), body.center_of_mass), key))
        })
    }

    /// The colliders that are present, in the order in which the solver takes them.
    pub(crate) fn present(&self) -> impl Iterator<Item = (&Gathered, ColliderMotion)> {
        self.colliders.iter().filter_map(|collider| Some((collider, collider.motion?)))
    }

    /// A collider of the tick.
    pub(crate) fn known(&self, entity: Entity) -> Option<&Gathered> {
        let place = self.colliders.binary_search_by_key(&entity, |collider| collider.entity);
        place.ok().map(|at| &self.colliders[at])
    }

    /// Puts a collider in its place, in place of what was known of it; or takes it out. It is `same` where
    /// its component has not changed.
    fn put(&mut self, entity: Entity, gathered: Option<Gathered>, same: bool) {
        let colliders = &mut self.colliders;
        let place = colliders.binary_search_by_key(&entity, |collider| collider.entity);
        match (place, gathered) {
            (Ok(at), Some(gathered)) => {
                let still = same && gathered.stands_as(&colliders[at]);
                colliders[at] = gathered;
                if still {
                    return;
                }
            }
            (Err(at), Some(gathered)) => colliders.insert(at, gathered),
            (Ok(at), None) => drop(colliders.remove(at)),
            (Err(_), None) => return,
        }
        self.version += 1;
    }
}

impl Gathered {
    /// Whether it stands still where it stood before.
    fn stands_as(&self, before: &Self) -> bool {
        self.motion == before.motion && self.motion.is_none_or(|it| it.start() == it.end())
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

/// Reuses the memory of a list for another lifetime: collecting into equal elements is done in place.
fn retype<'a>(mut used: Vec<solver::Collider<'_>>) -> Vec<solver::Collider<'a>> {
    used.clear();
    used.into_iter().map_while(|_| None).collect()
}

/// A collider, and what tells at once whether anything of it has changed: most stand still, so that they
/// are only passed over.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Found {
    entity: Entity,
    collider: Ref<'static, SdfCollider>,
    place: Option<Ref<'static, Transform>>,
    has_parent: Has<ChildOf>,
    measured: Has<ColliderImpulse>,
    disabled: Has<SdfColliderDisabled>,
    scale: Option<&'static OwnScale>,
    pose: &'static mut ColliderPose,
}

/// Notes where colliders are before a frame's ticks. What led cloths has made these `jumps`: what came along has jumped as well.
pub(crate) fn note_colliders(
    colliders: &mut Query<Found>,
    moves: &mut Moves,
    transforms: &TransformHelper,
    ticks: FrameTicks,
    jumps: &[RigidMotion],
) {
    let orphans = moves.any_orphan();
    for FoundItem { entity, place, has_parent, scale, mut pose, .. } in colliders {
        if pose.still && !orphans && !moves.moved_one(entity, place.as_ref(), has_parent) {
            continue;
        }
        pose.still = false;
        if let Some(moving) = &mut pose.moving
            && let Ok(now) = pose_now_scaled(transforms, entity, scale)
        {
            let before = moving.seen();
            moving.begin_frame(placed(entity, now, has_parent, moves), ticks);
            let came_along = jumps.iter().any(|jump| comes_along(jump, &before, &now));
            if came_along || has_jumped(&before, &now, ticks.count) {
                moving.at_once();
            }
        }
    }
}

/// A collider's pose, and its root.
fn placed(entity: Entity, pose: Pose, has_parent: bool, moves: &Moves) -> Placed {
    match has_parent {
        true => Placed { pose, root: moves.root(entity) },
        false => Placed::alone(entity, pose),
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
    mut colliders: Query<Found>,
    mut moves: Moves,
    transforms: TransformHelper,
    fields: FieldSource,
    mut snapshot: ResMut<TickColliders>,
    mut failures: Failures,
) {
    let orphans = moves.any_orphan();
    for found in &mut colliders {
        let FoundItem { entity, collider, place, has_parent, measured, disabled, scale, mut pose } =
            found;
        let same = !collider.is_changed();
        let as_before = pose.measured == measured && pose.disabled == disabled;
        let still = pose.still && as_before && same && !orphans;
        if still && !moves.moved_one(entity, place.as_ref(), has_parent) {
            continue;
        }
        (pose.measured, pose.disabled) = (measured, disabled);
        let now = pose_now_scaled(&transforms, entity, scale);
        let now = now.map(|now| placed(entity, now, has_parent, &moves));
        let gathered = match gather(entity, &collider, now, &mut pose, &fields) {
            Ok(gathered) => {
                failures.clear(entity, Blame::Component(ClothComponent::SdfCollider));
                failures.clear(entity, Blame::Pose);
                (!disabled).then_some(Gathered { measured, ..gathered })
            }
            Err(error) => {
                // What comes back later has not moved from where it was lost.
                *pose = ColliderPose::default();
                if error.blame() != Blame::Pose && now.is_ok() {
                    failures.clear(entity, Blame::Pose);
                }
                failures.report(entity, error);
                None
            }
        };
        snapshot.put(entity, gathered, same);
    }
}

fn gather(
    entity: Entity,
    collider: &SdfCollider,
    now: Result<Placed, PoseError>,
    pose: &mut ColliderPose,
    fields: &FieldSource,
) -> Result<Gathered, ClothErrorKind> {
    let &SdfCollider { friction, layers, .. } = collider;
    let component = ClothComponent::SdfCollider;
    collider.check().map_err(|problem| ClothErrorKind::Parameter { component, problem })?;
    let now = now?;
    let track = pose.moving.get_or_insert_with(|| Box::new(PoseTrack::new(now)));
    track.advance(now);
    let (start, end) = (track.start(), track.end());
    let start = if has_jumped(&start, &end, 1) { end } else { start };
    // A field may yet come, or be changed.
    pose.still = start == end && end == now.pose && !matches!(collider.shape, SdfShape::Field(_));
    fields.check(&collider.shape)?;
    let motion =
        collider.shape.get(fields.assets()).map(|shape| ColliderMotion::new(shape, start, end));
    let shape = collider.shape.clone();
    Ok(Gathered { entity, shape, motion, friction, layers, measured: false, body: None })
}

/// When `SdfCollider` is removed, drops it from the tick, clears its errors and forgets its motion.
pub(crate) fn forget_collider(
    removed: On<Remove, SdfCollider>,
    mut snapshot: ResMut<TickColliders>,
    mut failures: Failures,
    mut commands: Commands,
) {
    snapshot.put(removed.entity, None, false);
    failures.clear(removed.entity, Blame::Component(ClothComponent::SdfCollider));
    failures.clear(removed.entity, Blame::Pose);
    commands.entity(removed.entity).try_remove::<ColliderPose>();
}

/// When an entity is disabled, drops its collider from the tick.
pub(crate) fn drop_disabled(disabled: On<Add, Disabled>, mut snapshot: ResMut<TickColliders>) {
    snapshot.put(disabled.entity, None, false);
}

/// When an entity is enabled again, its collider starts where it is now: it has not come from where it was disabled.
pub(crate) fn take_up_enabled(
    enabled: On<Remove, Disabled>,
    mut colliders: Query<&mut ColliderPose, Allow<Disabled>>,
) {
    if let Ok(mut pose) = colliders.get_mut(enabled.entity) {
        *pose = ColliderPose::default();
    }
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
        world.init_resource::<TickColliders>();
        let entities: Vec<_> =
            (0..6).map(|_| world.spawn(SdfCollider::from(Sphere::default())).id()).collect();
        // Another archetype, which Bevy visits later.
        for entity in &entities[2..4] {
            world.entity_mut(*entity).insert(Other);
        }
        world.run_system_once(gather_colliders).unwrap();
        let gathered: Vec<_> = world
            .resource::<TickColliders>()
            .colliders
            .iter()
            .map(|collider| collider.entity)
            .collect();
        let mut sorted = gathered.clone();
        sorted.sort_unstable();
        assert_eq!((gathered.len(), &gathered), (6, &sorted));
    }

    #[test]
    fn the_room_for_colliders_is_kept() {
        let sphere = Sphere::new(1.0);
        let pose = Pose::IDENTITY;
        let collider = solver::Collider::new(&sphere, pose);
        let used = vec![collider; 10];
        let at = used.as_ptr().addr();
        let again = ColliderRoom::keep(used).reuse();
        assert_eq!((again.len(), again.as_ptr().addr()), (0, at));
        assert!(again.capacity() >= 10);
    }
}
