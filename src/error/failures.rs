//! Errors on entities: put on, told once, and taken off.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::error::engine::EngineProblem;
use crate::error::problems::{MeshProblem, PinProblem};
use crate::error::skin::SkinProblem;
use crate::error::{ClothComponent, ClothError, ClothErrorKind, ClothFailure};
use crate::solver::{ParameterError, SolverError};

/// The component or circumstance that has to change before an error is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blame {
    /// A number of it.
    Component(ClothComponent),
    Shape,
    Proxy,
    Weights,
    Skin,
    /// Like `Pose`, for what a skin follows: it can mend without a change of `ClothSkin`.
    Joints,
    Body,
    Pins,
    /// It can mend without a change of component, and is checked again and again.
    Pose,
    /// Like `Pose`, for mesh problems that can mend without a change of `Cloth` or `BakeSdf`: a missing mesh, a
    /// `SkinnedMesh`.
    Unseen,
    Motion,
    Drawing,
    Schedule,
    Bake,
    Engine,
    /// The mass of an engine's body.
    EngineMass,
    Push,
    Forces,
    Grab,
    Snapshot,
}

/// When an error stands in a cloth's way, and is gone.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The cloth is not set up before one of its components changes.
    SetUp,
    /// The cloth is not set up, and this can mend without such a change.
    SetUpUnseen,
    /// The cloth runs all the same. It is gone with the cloth.
    Running,
    /// It is not about a cloth.
    Apart,
}

impl Blame {
    /// Each is named, so that none can be forgotten.
    fn stage(self) -> Stage {
        match self {
            Self::Component(component) => match component {
                ClothComponent::ClothMaterial | ClothComponent::ClothSettings => Stage::SetUp,
                ClothComponent::ClothAir
                | ClothComponent::ClothSelfCollision
                | ClothComponent::ClothInterCollision
                | ClothComponent::ClothTeleport
                | ClothComponent::ClothInertia
                | ClothComponent::ClothCulling
                | ClothComponent::ClothLod
                | ClothComponent::ClothSleepThreshold
                | ClothComponent::HangOnStart => Stage::Running,
                ClothComponent::SdfCollider
                | ClothComponent::ColliderMass
                | ClothComponent::WindZone => Stage::Apart,
            },
            Self::Shape | Self::Proxy | Self::Weights | Self::Skin => Stage::SetUp,
            Self::Joints | Self::Pose | Self::Unseen => Stage::SetUpUnseen,
            Self::Pins
            | Self::Motion
            | Self::Drawing
            | Self::Schedule
            | Self::Push
            | Self::Forces
            | Self::Grab
            | Self::Snapshot => Stage::Running,
            Self::Bake | Self::Body | Self::Engine | Self::EngineMass => Stage::Apart,
        }
    }
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
    pub fn report(&mut self, entity: Entity, kind: ClothErrorKind) {
        let error = ClothError { entity, kind };
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
            others.retain(|other| other.kind.blame() != error.kind.blame());
            entity.insert(ClothFailure::new(error, others));
        });
    }

    /// Tells how it went with what is to blame.
    pub fn tell(&mut self, entity: Entity, blame: Blame, outcome: Result<(), ClothErrorKind>) {
        match outcome {
            Ok(()) => self.clear(entity, blame),
            Err(kind) => self.report(entity, kind),
        }
    }

    /// Tells whether the numbers of a component are in their ranges.
    pub fn tell_numbers(
        &mut self,
        entity: Entity,
        component: ClothComponent,
        outcome: Result<(), ParameterError>,
    ) {
        let outcome = outcome.map_err(|problem| ClothErrorKind::Parameter { component, problem });
        self.tell(entity, Blame::Component(component), outcome);
    }

    /// Forgets the entity's error if it is this component's.
    pub fn clear(&mut self, entity: Entity, blame: Blame) {
        self.clear_where(entity, move |known| known == blame);
    }

    /// Forgets the errors of an entity that is no cloth any more.
    pub fn clear_those_of_cloths(&mut self, entity: Entity) {
        self.clear_where(entity, |blame| blame.stage() != Stage::Apart);
    }

    /// Forgets the errors that kept a cloth from being set up.
    pub fn clear_those_of_set_up(&mut self, entity: Entity) {
        let is_of_set_up = |stage| matches!(stage, Stage::SetUp | Stage::SetUpUnseen);
        self.clear_where(entity, move |blame| is_of_set_up(blame.stage()));
    }

    fn clear_where(&mut self, entity: Entity, is_gone: impl Fn(Blame) -> bool + Send + 'static) {
        if !self.has_any(entity, &is_gone) {
            return;
        }
        self.commands.entity(entity).queue_silenced(move |mut entity: EntityWorldMut| {
            let mut left = known_errors(&mut entity);
            left.retain(|error| !is_gone(error.kind.blame()));
            if let Some(error) = left.pop() {
                entity.insert(ClothFailure::new(error, left));
            }
        });
    }

    /// Whether the entity has an error of this component.
    pub fn blames(&self, entity: Entity, blame: Blame) -> bool {
        self.has_any(entity, |known| known == blame)
    }

    /// Whether the entity has an error for which it cannot be set up before a component of it changes.
    pub fn keep_from_set_up(&self, entity: Entity) -> bool {
        let at = |stage| self.has_any(entity, |blame| blame.stage() == stage);
        at(Stage::SetUp) && !at(Stage::SetUpUnseen)
    }

    fn has_any(&self, entity: Entity, is_meant: impl Fn(Blame) -> bool) -> bool {
        let is_known = |known: &ClothFailure| known.errors().any(|e| is_meant(e.kind.blame()));
        self.known.get(entity).is_ok_and(is_known)
    }
}

/// Takes all that is known to be wrong off an entity, what came last at the end.
fn known_errors(entity: &mut EntityWorldMut) -> Vec<ClothError> {
    let Some(ClothFailure { error, mut others, .. }) = entity.take::<ClothFailure>() else {
        return Vec::new();
    };
    others.push(error);
    others
}

impl ClothErrorKind {
    pub(crate) fn blame(&self) -> Blame {
        match self {
            Self::Mesh(MeshProblem::Skinned | MeshProblem::Missing)
            | Self::ColliderMesh(MeshProblem::Missing) => Blame::Unseen,
            Self::Pin { problem: PinProblem::AnchorScale { .. }, .. }
            | Self::Scale(_)
            // Its entity is too far away.
            | Self::Solver(SolverError::NonFinite { .. })
            | Self::NoTransform => Blame::Pose,
            Self::Mesh(_) | Self::Shape(_) | Self::Graph(_) => Blame::Shape,
            Self::Proxy(_) => Blame::Proxy,
            Self::Draw(_) => Blame::Drawing,
            Self::Push(_) => Blame::Push,
            Self::Forces { .. } => Blame::Forces,
            Self::Grab(_) => Blame::Grab,
            Self::Snapshot(_) => Blame::Snapshot,
            Self::Weights(_) => Blame::Weights,
            Self::Skin(
                SkinProblem::NotSkinned
                | SkinProblem::NoBindposes
                | SkinProblem::JointGone(_)
                | SkinProblem::UnevenScale { .. },
            ) => Blame::Joints,
            Self::Skin(_) => Blame::Skin,
            Self::Body(_) => Blame::Body,
            Self::Parameter { component, .. } => Blame::Component(*component),
            Self::Field(_) => Blame::Component(ClothComponent::SdfCollider),
            Self::Hang(_) => Blame::Component(ClothComponent::HangOnStart),
            Self::Pin { .. } => Blame::Pins,
            Self::Solver(_) => Blame::Motion,
            Self::VariableStep => Blame::Schedule,
            Self::Bake(_) | Self::Shell(_) | Self::ColliderMesh(_) => Blame::Bake,
            Self::Engine(EngineProblem::Mass(_)) => Blame::EngineMass,
            Self::Engine(_) => Blame::Engine,
        }
    }
}
