//! Changes among the colliders since the last tick: where a sleeping cloth has to wake.

use bevy::ecs::message::MessageCursor;
use bevy::math::bounding::{Aabb3d, BoundingVolume, IntersectsVolume};
use bevy::prelude::*;

use crate::cloth::layers::ClothLayers;
use crate::collider::shape::SdfShape;
use crate::collider::snapshot::SdfColliderSnapshot;
use crate::collider::tick_colliders::{Gathered, TickColliders};
use crate::sdf::DistanceField;
use crate::solver::{ColliderMotion, Pose};

/// Where colliders moved, came, went or changed in this tick, and what they were like in it.
#[derive(Resource, Default)]
pub(crate) struct Disturbances {
    /// The snapshot's, when it was last looked at.
    version: u64,
    /// All colliders of the tick, in the order of their entities.
    seen: Vec<Seen>,
    before: Vec<Seen>,
    /// Boxes in the world in which something happened.
    places: Vec<Aabb3d>,
    /// Something without bounds happened.
    everywhere: bool,
}

#[derive(Clone)]
struct Seen {
    entity: Entity,
    shape: SdfShape,
    motion: ColliderMotion,
    friction: f32,
    layers: ClothLayers,
    /// In its own frame; `None` where it has none.
    bounds: Option<Aabb3d>,
}

impl Disturbances {
    /// Whether anything happened within `margin` of a box, given by its corners \[m\].
    pub fn reach(&self, (min, max): (Vec3, Vec3), margin: f32) -> bool {
        if self.everywhere || self.places.is_empty() {
            return self.everywhere;
        }
        // As much again, for what a field may overestimate and rounding.
        let cloth = Aabb3d::from_min_max(min, max).grow(Vec3::splat(2.0 * margin + 0.01));
        self.places.iter().any(|place| place.intersects(&cloth))
    }

    fn note(&mut self, seen: &Seen) {
        match seen.bounds {
            Some(bounds) => {
                let (start, end) = (seen.motion.start(), seen.motion.end());
                for pose in [&start, &end] {
                    self.places.push(in_world(&bounds, pose));
                }
                if start != end {
                    // The way between.
                    let [a, b] = self.places[self.places.len() - 2..] else { return };
                    self.places.push(a.merge(&b));
                }
            }
            None => self.everywhere = true,
        }
    }
}

/// Compares the tick's colliders with the last one's.
pub(crate) fn note_disturbances(
    snapshot: Res<TickColliders>,
    restored: Query<(), With<SdfColliderSnapshot>>,
    fields: Option<Res<Assets<DistanceField>>>,
    events: Option<Res<Messages<AssetEvent<DistanceField>>>>,
    mut cursor: Local<MessageCursor<AssetEvent<DistanceField>>>,
    mut noted: ResMut<Disturbances>,
) {
    let noted = &mut *noted;
    noted.places.clear();
    noted.everywhere = false;
    let fields_changed = events.is_some_and(|events| cursor.read(&events).count() > 0);
    if !fields_changed && snapshot.version == noted.version {
        return;
    }
    noted.version = snapshot.version;
    core::mem::swap(&mut noted.seen, &mut noted.before);
    noted.seen.clear();
    noted.seen.extend(snapshot.colliders.iter().filter_map(|collider| {
        let &Gathered { entity, ref shape, motion, friction, layers, .. } = collider;
        let motion = motion?;
        let bounds = shape.get(fields.as_deref())?.bounds();
        let shape = shape.clone();
        Some(Seen { entity, shape, motion, friction, layers, bounds })
    }));
    let (seen, mut before) = (core::mem::take(&mut noted.seen), core::mem::take(&mut noted.before));
    let mut gone = before.iter().peekable();
    for now in &seen {
        while let Some(lost) = gone.next_if(|lost| lost.entity < now.entity) {
            noted.note(lost);
        }
        let was = gone.next_if(|was| was.entity == now.entity);
        // What is put back into a scene was there all along.
        let restored = restored.contains(now.entity);
        let stays = now.motion.start() == now.motion.end()
            && (restored || was.is_some_and(|was| was.is_like(now)));
        // A field may be another without another handle; those are few, and seldom.
        if !stays || fields_changed {
            noted.note(now);
            if let Some(was) = was {
                noted.note(was);
            }
        }
    }
    gone.for_each(|lost| noted.note(lost));
    // It would keep solids that nobody has any more.
    before.clear();
    (noted.seen, noted.before) = (seen, before);
}

impl Seen {
    fn is_like(&self, other: &Self) -> bool {
        self.motion.end() == other.motion.end()
            && self.friction == other.friction
            && self.layers == other.layers
            && self.bounds == other.bounds
            && self.shape.is_same(&other.shape)
    }
}

/// The box around a box that is turned, scaled and shifted.
fn in_world(bounds: &Aabb3d, pose: &Pose) -> Aabb3d {
    let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
    let axes = Mat3::from_quat(pose.rotation);
    let centre = pose.rotation * ((min + max) * (0.5 * pose.scale)) + pose.translation;
    let half = (max - min) * (0.5 * pose.scale);
    let reach =
        axes.x_axis.abs() * half.x + axes.y_axis.abs() * half.y + axes.z_axis.abs() * half.z;
    Aabb3d::new(centre, reach)
}
