//! The bodies of a tick: how colliders answer that are of one which cloths move.

use bevy::prelude::*;

use crate::solver::{Collider, ColliderMotion, Mobility};

/// The body that a collider is a part of.
#[derive(Clone, Copy)]
pub(crate) struct TickBody {
    /// The entity with its `ColliderMass`.
    pub entity: Entity,
    /// How it answers to impulses; `None` while it sleeps.
    pub mobility: Option<Mobility>,
    /// Its centre of mass in the collider's frame \[m\].
    pub center_of_mass: Vec3,
    /// How many cloths are near it, each of which meets a part of it.
    pub cloths: u32,
}

impl TickBody {
    /// How it answers to one of the cloths that are near it.
    pub fn part(&self) -> Option<Mobility> {
        let Mobility { inverse_mass, inverse_inertia, .. } = self.mobility?;
        let cloths = self.cloths.max(1) as f32;
        let (inverse_mass, inverse_inertia) = (inverse_mass * cloths, inverse_inertia * cloths);
        Some(Mobility { inverse_mass, inverse_inertia, ..self.mobility? })
    }

    /// A collider as a part of it.
    pub fn of<'a>(&self, collider: Collider<'a>) -> Collider<'a> {
        Collider {
            measured: true,
            centre: self.center_of_mass,
            body: self.entity.to_bits(),
            mobility: self.part(),
            ..collider
        }
    }
}

/// A body that is no collider: pins may pull at it.
pub(crate) struct LoneBody {
    pub body: TickBody,
    /// Where it is.
    pub motion: ColliderMotion,
}

impl LoneBody {
    /// The collider that stands for it, which nothing collides with.
    pub fn collider(&self) -> Collider<'static> {
        static PLACE: Sphere = Sphere { radius: 1e-3 };
        let Self { body, motion } = self;
        let collider = Collider::new(&PLACE, motion.start()).in_layers(0).measured();
        body.of(Collider { key: body.entity.to_bits(), ..collider })
    }
}
