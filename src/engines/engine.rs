//! What is asked of a physics engine.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::engines::solid::{EngineSolid, Reader};
use crate::error::engine::EngineProblem;

/// The systems that adapt an engine's colliders.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Adapting {
    Avian,
    Rapier,
}

/// A physics engine, as cloths see it.
pub(crate) trait Engine: Send + Sync + 'static {
    const NAME: &'static str;
    const SET: Adapting;
    /// Whether a collider without friction has its body's.
    const FRICTION_OF_BODY: bool;
    type Collider: Component;
    /// Is on colliders that the engine has taken in.
    type Known: Component;
    type Sensor: Component;
    type ColliderDisabled: Component;
    type Body: Component;
    type BodyDisabled: Component;
    type Friction: Component;

    fn friction(friction: &Self::Friction) -> f32;

    /// Whether forces move a body.
    fn is_dynamic(body: &Self::Body) -> bool;

    /// Wakes a body that sleeps.
    fn wake(body: Entity, commands: &mut Commands);

    /// The collider's solid, and the scale that its pose is to have.
    fn read(
        collider: &Self::Collider,
        reader: &mut Reader,
    ) -> Result<(EngineSolid, f32), EngineProblem>;
}

/// Whether a scale is the same along all axes, and positive: a solid is then posed with it.
pub(crate) fn is_even(scale: Vec3) -> bool {
    let (least, most) = (scale.min_element(), scale.max_element());
    least > 0.0 && most.is_finite() && most - least <= 1e-5 * most
}

/// The bodies of colliders.
#[derive(SystemParam)]
pub(crate) struct Bodies<'w, 's, E: Engine> {
    bodies: Query<
        'w,
        's,
        (Has<<E as Engine>::BodyDisabled>, Option<&'static <E as Engine>::Friction>),
        With<<E as Engine>::Body>,
    >,
    disabled: Query<'w, 's, (), With<<E as Engine>::BodyDisabled>>,
    kinds: Query<'w, 's, &'static <E as Engine>::Body>,
    parents: Query<'w, 's, &'static ChildOf>,
}

impl<E: Engine> Bodies<'_, '_, E> {
    /// Whether the body of a collider is disabled, and its friction.
    fn of(&self, collider: Entity) -> Option<(bool, Option<&E::Friction>)> {
        let mut up = core::iter::once(collider).chain(self.parents.iter_ancestors(collider));
        up.find_map(|entity| self.bodies.get(entity).ok())
    }

    /// The body that a collider, or what is carried by one, moves with; `None` where forces do not move it.
    pub fn dynamic(&self, entity: Entity) -> Option<Entity> {
        let mut up = core::iter::once(entity).chain(self.parents.iter_ancestors(entity));
        let (body, kind) = up.find_map(|entity| Some((entity, self.kinds.get(entity).ok()?)))?;
        (E::is_dynamic(kind) && !self.disabled.contains(body)).then_some(body)
    }

    pub fn is_disabled(&self, collider: Entity) -> bool {
        !self.disabled.is_empty() && self.of(collider).is_some_and(|(disabled, _)| disabled)
    }

    pub fn friction(&self, collider: Entity) -> Option<&E::Friction> {
        if E::FRICTION_OF_BODY { self.of(collider)?.1 } else { None }
    }
}
