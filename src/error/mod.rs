//! Errors, reported on the entity that they concern.

pub(crate) mod body;
pub(crate) mod engine;
pub(crate) mod failures;
pub(crate) mod problems;
pub(crate) mod proxy;
pub(crate) mod skin;

use bevy::prelude::*;

use crate::error::body::BodyProblem;
use crate::error::engine::EngineProblem;
use crate::error::problems::{
    FieldProblem, GrabProblem, HangProblem, MeshProblem, PinProblem, ScaleProblem, WeightProblem,
};
use crate::error::proxy::ProxyProblem;
use crate::error::skin::SkinProblem;
use crate::sdf::BakeError;
use crate::sdf::shapes::ShellError;
use crate::solver::{GraphError, LatticeError, ParameterError, SolverError, StateError};

/// Something that is wrong with a cloth, a collider or a wind zone, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}{entity}{}{kind}", kind.subject(), kind.joint())]
pub struct ClothError {
    /// The cloth, collider or zone.
    pub entity: Entity,
    /// The problem with it.
    pub kind: ClothErrorKind,
}

/// The problem of a [`ClothError`], without its entity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClothErrorKind {
    /// The mesh cannot become a cloth.
    #[error(transparent)]
    Mesh(MeshProblem),
    /// The cloth's own mesh cannot be written. It is simulated all the same.
    #[error("cannot be drawn: {0}")]
    Draw(MeshProblem),
    /// The rest shape makes no lattice.
    #[error("{0}; change `Cloth` or its mesh")]
    Shape(LatticeError),
    /// The triangles of the mesh make no cloth at the entity's scale.
    #[error("{0}; change its mesh or its scale")]
    Graph(GraphError),
    /// A number of a component is out of its range. A running cloth keeps the last good ones, a collider or
    /// zone is left out.
    #[error("{problem}; change `{component:?}`")]
    Parameter {
        /// The component that holds the number.
        component: ClothComponent,
        /// The number and its range.
        problem: ParameterError,
    },
    /// `ClothWeights` cannot be used. A running cloth keeps the last good ones.
    #[error("{0}; change `ClothWeights`")]
    Weights(WeightProblem),
    /// `ClothSkin` cannot be used. A running cloth keeps the last good one.
    #[error("{0} (it has `ClothSkin`)")]
    Skin(SkinProblem),
    /// `ClothProxy` cannot be used. A running cloth goes on as it was.
    #[error("{0}; change `ClothProxy`")]
    Proxy(ProxyProblem),
    /// `ClothBody` cannot be fitted, or a capsule of it cannot be used. The other capsules are there.
    #[error(transparent)]
    Body(BodyProblem),
    /// A pin holds nothing, or is held by nothing.
    #[error("pin {pin}: {problem}")]
    Pin {
        /// Index in `ClothPins::pins`.
        pin: usize,
        /// The problem with it.
        problem: PinProblem,
    },
    /// The cloth does not start hung from its pins, but in its rest shape.
    #[error("starts in its rest shape: {0} (it has `HangOnStart`)")]
    Hang(HangProblem),
    /// The cloth is not pushed as it was asked for, by a `PushCloth` or by `ClothSimulation::push`.
    #[error("is not pushed: {0}")]
    Push(SolverError),
    /// A force of `ClothForces` cannot be used. The others act.
    #[error("force {force} of `ClothForces` is left out: {problem}")]
    Forces {
        /// Index in `ClothForces::forces`.
        force: usize,
        /// The problem with it.
        problem: SolverError,
    },
    /// `ClothGrab` holds nothing.
    #[error("is not grabbed: {0}; change `ClothGrab`")]
    Grab(GrabProblem),
    /// `ClothSnapshot` cannot be put back. The cloth stays as it was.
    #[error(transparent)]
    Snapshot(StateError),
    /// The transform of the entity cannot be used.
    #[error(transparent)]
    Scale(ScaleProblem),
    /// The entity or one of its ancestors has no `Transform`.
    #[error(
        "it has no `Transform`, or one of its parents has none; insert `Transform::default()` where it is missing"
    )]
    NoTransform,
    /// The solver refuses to go on. The cloth stays where it was last finite.
    #[error("{0}; the cloth is frozen until this is fixed")]
    Solver(SolverError),
    /// The plugin's schedule does not run at a fixed step.
    #[error(
        "is not simulated: the schedule given to `ClothPlugin` does not run in the fixed main \
         loop; use `FixedPostUpdate` (the default) or another fixed schedule"
    )]
    VariableStep,
    /// The mesh cannot become a distance field, or not with these settings.
    #[error(transparent)]
    Bake(BakeError),
    /// The mesh's surface cannot have this thickness.
    #[error(transparent)]
    Shell(ShellError),
    /// The collider's mesh cannot be read.
    #[error(transparent)]
    ColliderMesh(MeshProblem),
    /// The collider's distance field is not there and not coming. The collider is left out until it is.
    #[error(transparent)]
    Field(FieldProblem),
    /// The collider of a physics engine cannot be used. Cloths pass through it.
    #[error(transparent)]
    Engine(EngineProblem),
}

/// A component of which a number may be out of its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClothComponent {
    /// [`ClothMaterial`](crate::ClothMaterial).
    ClothMaterial,
    /// [`ClothSettings`](crate::ClothSettings).
    ClothSettings,
    /// [`ClothAir`](crate::ClothAir).
    ClothAir,
    /// [`ClothSelfCollision`](crate::ClothSelfCollision).
    ClothSelfCollision,
    /// [`ClothInterCollision`](crate::ClothInterCollision).
    ClothInterCollision,
    /// [`ClothTeleport`](crate::ClothTeleport).
    ClothTeleport,
    /// [`ClothInertia`](crate::ClothInertia).
    ClothInertia,
    /// [`ClothCulling`](crate::ClothCulling).
    ClothCulling,
    /// [`ClothLod`](crate::ClothLod).
    ClothLod,
    /// [`ClothSleepThreshold`](crate::ClothSleepThreshold).
    ClothSleepThreshold,
    /// [`HangOnStart`](crate::HangOnStart).
    HangOnStart,
    /// [`SdfCollider`](crate::SdfCollider).
    SdfCollider,
    /// [`ColliderMass`](crate::ColliderMass).
    ColliderMass,
    /// [`WindZone`](crate::WindZone).
    WindZone,
}

impl ClothComponent {
    /// The noun before the number of an entity that has it.
    fn subject(self) -> &'static str {
        match self {
            Self::SdfCollider | Self::ColliderMass => "collider ",
            Self::WindZone => "wind zone ",
            _ => "cloth ",
        }
    }
}

impl ClothErrorKind {
    /// The noun before the entity's number.
    fn subject(&self) -> &'static str {
        match self {
            Self::Parameter { component, .. } => component.subject(),
            // A cloth, a collider or a wind zone.
            Self::Scale(_) | Self::NoTransform => "entity ",
            Self::Bake(_)
            | Self::Shell(_)
            | Self::ColliderMesh(_)
            | Self::Field(_)
            | Self::Engine(_) => "collider ",
            Self::Body(_) => "body ",
            _ => "cloth ",
        }
    }

    /// The text between the entity and the message.
    fn joint(&self) -> &'static str {
        match self {
            Self::Draw(_) | Self::Hang(_) | Self::Push(_) | Self::Grab(_) | Self::VariableStep => {
                " "
            }
            Self::Pin { .. } | Self::Forces { .. } => ", ",
            _ => ": ",
        }
    }
}

/// Is on an entity as long as something is wrong with its cloth, collider or wind zone.
///
/// Each error is logged once. It is removed when the component at fault is changed and found good.
///
/// An inspector sees the messages. The component is neither cloned with the entity nor saved with a world.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[component(clone_behavior = Ignore)]
#[reflect(Component, Debug, PartialEq, Clone, from_reflect = false)]
pub struct ClothFailure {
    /// The error: of several, the one that came last.
    #[reflect(ignore)]
    pub error: ClothError,
    /// The other errors, at most one for each `Blame`.
    #[reflect(ignore)]
    others: Vec<ClothError>,
    /// The messages of all errors, the one that came last first: an inspector shows them.
    messages: Vec<String>,
}

impl ClothFailure {
    /// For an error that came last, and the others.
    fn new(error: ClothError, others: Vec<ClothError>) -> Self {
        let mut failure = Self { error, others, messages: Vec::new() };
        failure.messages = failure.errors().map(ToString::to_string).collect();
        failure
    }

    /// Everything that is wrong, what came last first.
    pub fn errors(&self) -> impl Iterator<Item = &ClothError> {
        core::iter::once(&self.error).chain(self.others.iter().rev())
    }
}
