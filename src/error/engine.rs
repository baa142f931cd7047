//! Problems of the colliders of physics engines, each with what to do about it.

use crate::sdf::BakeError;
use crate::sdf::shapes::{CompoundError, HeightFieldError, ShellError};
use crate::solver::ParameterError;

/// Why cloths do not collide with the collider of a physics engine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineProblem {
    /// The shape is a surface or a line, without an inside to hold cloths out of.
    #[error(
        "its {shape} has no inside to hold cloths out of; give `ClothCollider` a `thickness`, or the entity a closed shape"
    )]
    NoInside {
        /// What the engine calls the shape.
        shape: &'static str,
    },
    /// The shape is not one that a distance can be had of.
    #[error(
        "cloths cannot collide with its {shape}; give the entity an `SdfCollider`, which takes the place of the engine's"
    )]
    Unsupported {
        /// What the engine calls the shape.
        shape: &'static str,
    },
    /// A number of the shape is out of its range.
    #[error("{0}; change its `Collider`")]
    Shape(ParameterError),
    /// The parts of the shape make no whole.
    #[error("{0}; change its `Collider`")]
    Compound(CompoundError),
    /// The heights of the shape make no ground.
    #[error("{0}; change its `Collider`")]
    HeightField(HeightFieldError),
    /// The shape would be cut into too many parts.
    #[error("its {shape} of {count} parts is too large, {most} is the most; divide it")]
    TooMany {
        /// What the engine calls the shape.
        shape: &'static str,
        /// How many segments or boxes of voxels it has.
        count: usize,
        /// How many it may have.
        most: usize,
    },
    /// A number of `ClothCollider` is out of its range.
    #[error("{0}; change its `ClothCollider`")]
    Parameter(ParameterError),
    /// The shape cannot become a distance field.
    #[error("its {shape} cannot be baked: {problem}")]
    Bake {
        /// What the engine calls the shape.
        shape: &'static str,
        /// The problem with it.
        problem: BakeError,
    },
    /// The shape cannot have a thickness.
    #[error("its {shape} cannot be thickened: {problem}")]
    Shell {
        /// What the engine calls the shape.
        shape: &'static str,
        /// The problem with it.
        problem: ShellError,
    },
    /// The mesh has a border.
    #[error(
        "its {shape} is not closed, {open_edges} edges have one triangle only; give `ClothCollider` a `thickness`, or fill the \
         mesh's holes"
    )]
    OpenMesh {
        /// What the engine calls the shape.
        shape: &'static str,
        /// Number of such edges.
        open_edges: usize,
    },
    /// The mass of the body is none that cloths can move. They lie on it as on a wall.
    #[error("cloths cannot move its body: {0}; give it a mass, or make it static or kinematic")]
    Mass(ParameterError),
    /// The entity has colliders of two engines.
    #[error(
        "it has colliders of two engines, and cloths collide with {kept}'s alone; move the other to a child"
    )]
    TwoEngines {
        /// The engine whose collider is taken.
        kept: &'static str,
    },
}
