//! Problems of bodies, each with what to do about it.

use bevy::prelude::*;

use crate::error::skin::SkinProblem;
use crate::solver::ParameterError;

/// Why a [`ClothBody`](crate::ClothBody), or a capsule of it, cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyProblem {
    /// There is no skinned mesh, and none has come.
    #[error(
        "nothing at or below it has a `SkinnedMesh` that is no cloth, and none has come within ten seconds; put `ClothBody` on the \
         character, or list its capsules"
    )]
    NoSkinnedMesh,
    /// A skinned mesh cannot be read.
    #[error("its skinned mesh {mesh}: {problem}; or list its capsules")]
    Mesh {
        /// The entity that has it.
        mesh: Entity,
        /// The problem with it.
        problem: SkinProblem,
    },
    /// The meshes have no triangles, or only triangles without area.
    #[error("its skinned meshes have no area; list its capsules")]
    NoArea,
    /// A number of a capsule is out of its range. The other capsules are there.
    #[error("capsule {capsule} is left out: {problem}; change `ClothBody`")]
    Capsule {
        /// Index in `ClothBody::capsules`.
        capsule: usize,
        /// The number and its range.
        problem: ParameterError,
    },
    /// The joint of a capsule is not there. The other capsules are.
    #[error(
        "capsule {capsule} is left out: its joint {joint} is not there or has no `Transform`; drop it from `ClothBody`"
    )]
    JointGone {
        /// Index in `ClothBody::capsules`.
        capsule: usize,
        /// The joint.
        joint: Entity,
    },
}
