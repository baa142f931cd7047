//! Problems of the colliders of physics engines, each with what to do about it.

use crate::sdf::BakeError;
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
    /// The entity has colliders of two engines.
    #[error(
        "it has colliders of two engines, and cloths collide with {kept}'s alone; move the other to a child"
    )]
    TwoEngines {
        /// The engine whose collider is taken.
        kept: &'static str,
    },
}
