//! Problems of skinned cloths, each with what to do about it.

use bevy::prelude::*;

use crate::error::problems::MeshProblem;
use crate::solver::ParameterError;

/// Why a [`ClothSkin`](crate::ClothSkin) cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SkinProblem {
    /// The entity is not skinned.
    #[error("the entity has no `SkinnedMesh`; put `ClothSkin` on the entity that has it")]
    NotSkinned,
    /// The cloth is a sheet.
    #[error("a sheet has no joints; use `Cloth::of_mesh3d()`")]
    NotAMesh,
    /// The mesh cannot be read.
    #[error(transparent)]
    Mesh(MeshProblem),
    /// The mesh has no joints, or not in Bevy's formats.
    #[error(
        "its mesh has no `ATTRIBUTE_JOINT_INDEX` of four u16 and no `ATTRIBUTE_JOINT_WEIGHT` of four floats for each vertex; \
         export it with its skin"
    )]
    NoWeights,
    /// The inverse bind poses are not there and not coming.
    #[error(
        "its inverse bind poses are not among `Assets<SkinnedMeshInverseBindposes>`, and nothing loads them; add them there"
    )]
    NoBindposes,
    /// Joints and bind poses are not as many.
    #[error("it has {joints} joints, but {bindposes} inverse bind poses; give one for each")]
    WrongBindposeCount {
        /// Joints of the `SkinnedMesh`.
        joints: usize,
        /// Inverse bind poses.
        bindposes: usize,
    },
    /// There are more joints than a mesh can have.
    #[error("it has {joints} joints, but a skinned mesh has {most} at most; split the mesh")]
    TooManyJoints {
        /// Joints of the `SkinnedMesh`.
        joints: usize,
        /// Most that are drawn.
        most: usize,
    },
    /// A vertex follows a joint that is not there.
    #[error(
        "vertex {vertex} follows joint {joint}, but there are {joints}; export mesh and skeleton together"
    )]
    NoSuchJoint {
        /// The vertex.
        vertex: usize,
        /// The index of the joint.
        joint: u16,
        /// Joints of the `SkinnedMesh`.
        joints: usize,
    },
    /// The weights of a vertex do not sum up to one.
    #[error(
        "the weights of vertex {vertex} are {weights:?}: none may be negative, and their sum must be 1; normalize them \
         (`Mesh::normalize_joint_weights`)"
    )]
    Weights {
        /// The vertex.
        vertex: usize,
        /// Its weights.
        weights: [f32; 4],
    },
    /// A joint, or one of its ancestors, is gone or has no `Transform`.
    #[error("its joint {0} is not there or has no `Transform`; what follows it stays where it was")]
    JointGone(Entity),
    /// A joint scales the mesh unevenly, or to nothing.
    #[error(
        "its joint {joint} scales it by {scale}; the scale must be uniform, positive and neither huge nor tiny, or the cloth has \
         no length at rest: put an uneven scale into the mesh"
    )]
    UnevenScale {
        /// The joint.
        joint: Entity,
        /// How it scales the mesh.
        scale: Vec3,
    },
    /// A map goes by vertex colour, and the mesh has none.
    #[error(
        "`{field}` goes by vertex colour, but its mesh has none; paint it, or use another `SkinMap`"
    )]
    NoColors {
        /// The field of `ClothSkin`.
        field: &'static str,
    },
    /// A map goes by an attribute that the mesh does not have, or not as one float a vertex.
    #[error(
        "`{field}` goes by the attribute `{name}`, but its mesh has none of this name and of one float a vertex; register it with \
         `GltfPlugin::add_custom_vertex_attribute` (of an attribute `_{name}` in the file the name is `{name}`)"
    )]
    NoAttribute {
        /// The field of `ClothSkin`.
        field: &'static str,
        /// The attribute's name.
        name: String,
    },
    /// A map goes by the weight of a joint that is not there.
    #[error("`{field}` goes by the weight of the joint `{name}`, but no joint has this `Name`")]
    NoNamedJoint {
        /// The field of `ClothSkin`.
        field: &'static str,
        /// The joint's name.
        name: String,
    },
    /// A list has not one number a vertex.
    #[error("`{field}` has {got} numbers, but there are {expected} vertices; give one for each")]
    WrongLength {
        /// The field of `ClothSkin`.
        field: &'static str,
        /// Vertices of the mesh.
        expected: usize,
        /// Numbers given.
        got: usize,
    },
    /// A number is out of its range.
    #[error("at particle {particle}, {problem}")]
    OutOfRange {
        /// The particle.
        particle: usize,
        /// The number and its range.
        problem: ParameterError,
    },
    /// The mesh has no normal where there is a backstop.
    #[error("its mesh has no normal at particle {particle}, which has a backstop; give it normals")]
    NoNormal {
        /// The particle.
        particle: usize,
    },
}
