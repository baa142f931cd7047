//! What can go wrong, told to the entity that it concerns.

pub(crate) mod failures;
pub(crate) mod problems;

use bevy::prelude::*;

use crate::error::problems::{
    FieldProblem, GrabProblem, HangProblem, MeshProblem, PinProblem, WeightProblem,
};
use crate::sdf::BakeError;
use crate::solver::{GraphError, LatticeError, ParameterError, SolverError, StateError};

/// Why a cloth, a pin or a collider does not work, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClothError {
    /// The mesh cannot become a cloth.
    #[error("cloth {entity}: {problem}")]
    Mesh {
        /// The cloth.
        entity: Entity,
        /// What is wrong with its mesh.
        problem: MeshProblem,
    },
    /// The cloth's own mesh cannot be written. It is simulated all the same.
    #[error("cloth {entity} cannot be drawn: {problem}")]
    Draw {
        /// The cloth.
        entity: Entity,
        /// What is wrong with its mesh.
        problem: MeshProblem,
    },
    /// The rest shape makes no lattice.
    #[error("cloth {entity}: {problem}; change `Cloth` or its mesh")]
    Shape {
        /// The cloth.
        entity: Entity,
        /// What is wrong with its rest shape.
        problem: LatticeError,
    },
    /// The triangles of the mesh make no cloth at the entity's scale.
    #[error("cloth {entity}: {problem}; change its mesh or its scale")]
    Graph {
        /// The cloth.
        entity: Entity,
        /// What is wrong with its rest shape.
        problem: GraphError,
    },
    /// A number of `ClothMaterial`, `ClothSettings`, `ClothAir`, `HangOnStart`, `SdfCollider` or `WindZone` is out of its
    /// range. A running cloth keeps the last good ones, a collider or zone is left out.
    #[error("{entity}: {problem}; change `{component}`")]
    Parameter {
        /// The cloth, collider or zone.
        entity: Entity,
        /// The component that holds the number.
        component: &'static str,
        /// The number and its range.
        problem: ParameterError,
    },
    /// `ClothWeights` cannot be used. A running cloth keeps the last good ones.
    #[error("cloth {entity}: {problem}; change `ClothWeights`")]
    Weights {
        /// The cloth.
        entity: Entity,
        /// What is wrong with them.
        problem: WeightProblem,
    },
    /// A pin holds nothing, or is held by nothing.
    #[error("cloth {entity}, pin {pin}: {problem}")]
    Pin {
        /// The cloth.
        entity: Entity,
        /// Index in `ClothPins::pins`.
        pin: usize,
        /// What is wrong with it.
        problem: PinProblem,
    },
    /// The cloth does not start hung from its pins, but in its rest shape.
    #[error("cloth {entity} starts in its rest shape: {problem} (it has `HangOnStart`)")]
    Hang {
        /// The cloth.
        entity: Entity,
        /// What is wrong with its pins' places, or how it went.
        problem: HangProblem,
    },
    /// The cloth is not pushed as it was asked for, by a `PushCloth` or by `ClothSimulation::push`.
    #[error("cloth {entity} is not pushed: {problem}")]
    Push {
        /// The cloth.
        entity: Entity,
        /// What is wrong with the push.
        problem: SolverError,
    },
    /// A force of `ClothForces` cannot be used. The others act.
    #[error("cloth {entity}, force {force} of `ClothForces` is left out: {problem}")]
    Forces {
        /// The cloth.
        entity: Entity,
        /// Index in `ClothForces::forces`.
        force: usize,
        /// What is wrong with it.
        problem: SolverError,
    },
    /// `ClothGrab` holds nothing.
    #[error("cloth {entity} is not grabbed: {problem}; change `ClothGrab`")]
    Grab {
        /// The cloth.
        entity: Entity,
        /// What is wrong with it.
        problem: GrabProblem,
    },
    /// `ClothSnapshot` cannot be put back. The cloth stays as it was.
    #[error("cloth {entity}: {problem}")]
    Snapshot {
        /// The cloth.
        entity: Entity,
        /// What is wrong with the state.
        problem: StateError,
    },
    /// The entity's transform is not finite, scales its axes differently, or scales them to nothing usable.
    #[error(
        "{entity}: its transform (with its parents') must be finite and its scale uniform, positive and neither \
         huge nor tiny, but the scale is {scale}; put the uneven scale into the mesh or the size"
    )]
    Scale {
        /// The cloth or collider.
        entity: Entity,
        /// Its scale in the world.
        scale: Vec3,
    },
    /// The entity or one of its ancestors has no `Transform`.
    #[error("{entity}: it or one of its parents has no `Transform`; insert one")]
    NoTransform {
        /// The cloth or collider.
        entity: Entity,
    },
    /// The solver refuses to go on. The cloth stays where it was last finite.
    #[error("cloth {entity}: {problem}; it is held until that is mended")]
    Solver {
        /// The cloth.
        entity: Entity,
        /// What the solver says.
        problem: SolverError,
    },
    /// The plugin's schedule does not run at a fixed step.
    #[error(
        "cloth {entity} is not simulated: the schedule given to `ClothPlugin` does not run in the fixed main \
         loop; use `FixedPostUpdate` (the default) or another fixed schedule"
    )]
    VariableStep {
        /// The cloth.
        entity: Entity,
    },
    /// The mesh cannot become a distance field.
    #[error("collider {entity}: {problem}")]
    Bake {
        /// The collider.
        entity: Entity,
        /// What is wrong with its mesh, or with the settings.
        problem: BakeError,
    },
    /// The collider's mesh cannot be read.
    #[error("collider {entity}: {problem}")]
    ColliderMesh {
        /// The collider.
        entity: Entity,
        /// What is wrong with its mesh.
        problem: MeshProblem,
    },
    /// The collider's distance field is not there and not coming. The collider is left out until it is.
    #[error("collider {entity}: {problem}")]
    Field {
        /// The collider.
        entity: Entity,
        /// What is wrong with its field.
        problem: FieldProblem,
    },
}

/// Is on an entity as long as something is wrong with its cloth, collider or wind zone.
///
/// Each error is logged once. It is removed when the component at fault is changed and found good.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque, Component, Debug, PartialEq, Clone)]
pub struct ClothFailure {
    /// What is wrong: of several things, what came last.
    pub error: ClothError,
    /// What else is, one a component at fault.
    others: Vec<ClothError>,
}

impl ClothFailure {
    /// Everything that is wrong, what came last first.
    pub fn errors(&self) -> impl Iterator<Item = &ClothError> {
        core::iter::once(&self.error).chain(self.others.iter().rev())
    }
}
