//! Errors on entities: put on, told once, and taken off.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::error::problems::{MeshProblem, PinProblem};
use crate::error::{ClothError, ClothFailure};
use crate::solver::SolverError;

/// The component or circumstance that has to change before an error is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blame {
    Shape,
    Weights,
    Material,
    Settings,
    Pins,
    /// It may mend unseen, and is looked at again and again.
    Pose,
    /// As a pose, where only a mesh can tell.
    Unseen,
    Motion,
    Drawing,
    Collider,
    Schedule,
    Bake,
    Teleport,
    Inertia,
    Sleep,
    Air,
    Zone,
    Hanging,
    Push,
    Forces,
    Grab,
    Snapshot,
}

impl Blame {
    /// The blames that a cloth may have.
    pub const OF_CLOTHS: [Self; 19] = [
        Self::Shape,
        Self::Weights,
        Self::Material,
        Self::Settings,
        Self::Pins,
        Self::Pose,
        Self::Unseen,
        Self::Motion,
        Self::Drawing,
        Self::Schedule,
        Self::Teleport,
        Self::Inertia,
        Self::Sleep,
        Self::Air,
        Self::Hanging,
        Self::Push,
        Self::Forces,
        Self::Grab,
        Self::Snapshot,
    ];
}

/// Puts errors on entities, and takes them off.
#[derive(SystemParam)]
pub(crate) struct Failures<'w, 's> {
    commands: Commands<'w, 's>,
    known: Query<'w, 's, &'static ClothFailure>,
    names: Query<'w, 's, &'static Name>,
}

impl Failures<'_, '_> {
    /// Logs an error, with the entity's name where it has one, and keeps it on the entity, once.
    pub fn report(&mut self, entity: Entity, error: ClothError) {
        // By the message, as an error may hold a NaN, which is not equal to itself.
        let message = error.to_string();
        let is_known = |known: &ClothFailure| known.errors().any(|e| e.to_string() == message);
        if self.known.get(entity).is_ok_and(is_known) {
            return;
        }
        match self.names.get(entity) {
            Ok(name) => tracing::error!("{message} (it is called \"{name}\")"),
            Err(_) => tracing::error!("{message}"),
        }
        self.commands.entity(entity).queue_silenced(move |mut entity: EntityWorldMut| {
            let mut others = known_errors(&mut entity);
            others.retain(|other| other.blame() != error.blame());
            entity.insert(ClothFailure { error, others });
        });
    }

    /// Forgets the entity's error if it is this component's.
    pub fn clear(&mut self, entity: Entity, blame: Blame) {
        if self.blames(entity, blame) {
            self.commands.entity(entity).queue_silenced(move |mut entity: EntityWorldMut| {
                let mut left = known_errors(&mut entity);
                left.retain(|error| error.blame() != blame);
                if let Some(error) = left.pop() {
                    entity.insert(ClothFailure { error, others: left });
                }
            });
        }
    }

    /// Whether the entity's error is this component's.
    pub fn blames(&self, entity: Entity, blame: Blame) -> bool {
        let is_to_blame = |known: &ClothFailure| known.errors().any(|e| e.blame() == blame);
        self.known.get(entity).is_ok_and(is_to_blame)
    }

    /// Whether no entity has an error.
    pub fn are_none(&self) -> bool {
        self.known.is_empty()
    }

    /// Whether the entity has an error.
    pub fn has(&self, entity: Entity) -> bool {
        self.known.contains(entity)
    }
}

/// Takes all that is known to be wrong off an entity, what came last at the end.
fn known_errors(entity: &mut EntityWorldMut) -> Vec<ClothError> {
    let Some(ClothFailure { error, mut others }) = entity.take::<ClothFailure>() else {
        return Vec::new();
    };
    others.push(error);
    others
}

impl ClothError {
    pub(crate) fn blame(&self) -> Blame {
        match self {
            Self::Mesh { problem: MeshProblem::Skinned | MeshProblem::Missing, .. }
            | Self::ColliderMesh { problem: MeshProblem::Missing, .. } => Blame::Unseen,
            Self::Pin { problem: PinProblem::AnchorScale(_), .. }
            | Self::Scale { .. }
            // Its entity is too far away.
            | Self::Solver { problem: SolverError::NonFinite { .. }, .. }
            | Self::NoTransform { .. } => Blame::Pose,
            Self::Mesh { .. } | Self::Shape { .. } | Self::Graph { .. } => Blame::Shape,
            Self::Draw { .. } => Blame::Drawing,
            Self::Push { .. } => Blame::Push,
            Self::Forces { .. } => Blame::Forces,
            Self::Grab { .. } => Blame::Grab,
            Self::Snapshot { .. } => Blame::Snapshot,
            Self::Weights { .. } => Blame::Weights,
            Self::Parameter { component: "ClothMaterial", .. } => Blame::Material,
            Self::Parameter { component: "SdfCollider", .. } | Self::Field { .. } => {
                Blame::Collider
            }
            Self::Parameter { component: "ClothTeleport", .. } => Blame::Teleport,
            Self::Parameter { component: "ClothInertia", .. } => Blame::Inertia,
            Self::Parameter { component: "ClothSleepThreshold", .. } => Blame::Sleep,
            Self::Parameter { component: "ClothAir", .. } => Blame::Air,
            Self::Parameter { component: "WindZone", .. } => Blame::Zone,
            Self::Parameter { component: "HangOnStart", .. } | Self::Hang { .. } => Blame::Hanging,
            Self::Parameter { .. } => Blame::Settings,
            Self::Pin { .. } => Blame::Pins,
            Self::Solver { .. } => Blame::Motion,
            Self::VariableStep { .. } => Blame::Schedule,
            Self::Bake { .. } | Self::ColliderMesh { .. } => Blame::Bake,
        }
    }
}
