//! How a mesh is skinned, by particle of its cloth.

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;
use bevy_drape_core::surface::Influences;

use crate::error::skin::SkinProblem;
use crate::mesh::raw::RawMesh;
use crate::mesh::rest_shape::RestShape;

/// Joints that a mesh has at most, as those of Bevy's shaders.
const MOST_JOINTS: usize = 256;
/// How far the weights of a vertex may sum up to something else than one: above what small formats round.
const ROUNDING: f32 = 0.02;

/// Where the particles of a skinned mesh are before joints move them, and which joints do.
#[derive(Clone, Debug)]
pub(crate) struct SkinnedShape {
    /// Positions in the mesh's own frame \[m\].
    pub points: Vec<Vec3>,
    /// Normals of the surface there, of length one.
    pub normals: Vec<Vec3>,
    pub influences: Vec<Influences>,
}

impl SkinnedShape {
    /// Reads a mesh that `joints` joints move. Where several vertices make a particle, the first of them says which.
    ///
    /// # Errors
    /// [`SkinProblem`] where it has no such joints or weights.
    pub fn read(mesh: &Mesh, rest: &RestShape, joints: usize) -> Result<Self, SkinProblem> {
        let RestShape::Mesh(shape) = rest else { return Err(SkinProblem::NotAMesh) };
        let weights = VertexWeights::read(mesh, rest.vertex_count(), joints)?;
        let raw = RawMesh::read(mesh).map_err(SkinProblem::Mesh)?;
        let count = rest.particle_count();
        let mut out = Self {
            points: shape.positions.clone(),
            normals: normals(&raw, rest),
            influences: vec![Influences::default(); count],
        };
        let mut is_told = vec![false; count];
        for (vertex, particle) in rest.used_vertices() {
            let influences = weights.of(vertex)?;
            if !core::mem::replace(&mut is_told[particle], true) {
                out.influences[particle] = influences;
            }
        }
        Ok(out)
    }

    /// How much all particles together follow each of so many joints \[1\].
    pub fn shares(&self, joints: usize) -> Vec<f32> {
        let mut shares = vec![0.0; joints];
        for influences in &self.influences {
            for (joint, weight) in influences.joints.into_iter().zip(influences.weights) {
                if weight > 0.0 {
                    shares[joint as usize] += weight;
                }
            }
        }
        shares
    }
}

/// The joints of a mesh's vertices, and their weights.
pub(crate) struct VertexWeights<'a> {
    indices: &'a [[u16; 4]],
    weights: &'a [[f32; 4]],
    joints: usize,
}

impl<'a> VertexWeights<'a> {
    /// Those of a mesh of so many vertices, that so many joints move.
    ///
    /// # Errors
    /// [`SkinProblem`] where it has none, or more joints than a mesh can have.
    pub fn read(mesh: &'a Mesh, vertices: usize, joints: usize) -> Result<Self, SkinProblem> {
        if joints > MOST_JOINTS {
            return Err(SkinProblem::TooManyJoints { joints, most: MOST_JOINTS });
        }
        let attribute = |which| mesh.try_attribute_option(which).ok().flatten();
        match (attribute(Mesh::ATTRIBUTE_JOINT_INDEX), attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT)) {
            (
                Some(VertexAttributeValues::Uint16x4(indices)),
                Some(VertexAttributeValues::Float32x4(weights)),
            ) if indices.len() == vertices && weights.len() == vertices => {
                Ok(Self { indices, weights, joints })
            }
            _ => Err(SkinProblem::NoWeights),
        }
    }

    /// Those of a vertex.
    ///
    /// # Errors
    /// [`SkinProblem`] where the weights do not sum up to one, or a joint is not there.
    pub fn of(&self, vertex: usize) -> Result<Influences, SkinProblem> {
        let (joints, weights) = (self.indices[vertex], self.weights[vertex]);
        let sum: f32 = weights.iter().sum();
        let good = weights.iter().all(|weight| (0.0..=1.0 + ROUNDING).contains(weight));
        if !good || (sum - 1.0).abs() > ROUNDING {
            return Err(SkinProblem::Weights { vertex, weights });
        }
        let followed = joints.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        for (joint, _) in followed {
            self.check(vertex, joint)?;
        }
        Ok(Influences { joints, weights })
    }

    /// The joint that moves a vertex most.
    ///
    /// # Errors
    /// [`SkinProblem`] where it is not there.
    pub fn strongest(&self, vertex: usize) -> Result<u16, SkinProblem> {
        let both = self.indices[vertex].into_iter().zip(self.weights[vertex]);
        // Of equal ones the first.
        let most = both.reduce(|most, next| if next.1 > most.1 { next } else { most });
        let joint = most.map_or(0, |(joint, _)| joint);
        self.check(vertex, joint).map(|()| joint)
    }

    fn check(&self, vertex: usize, joint: u16) -> Result<(), SkinProblem> {
        let joints = self.joints;
        let is_there = usize::from(joint) < joints;
        is_there.then_some(()).ok_or(SkinProblem::NoSuchJoint { vertex, joint, joints })
    }
}

/// The normal of each particle: the mean of those of its vertices, or of its triangles where the mesh has none.
fn normals(raw: &RawMesh, rest: &RestShape) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; rest.particle_count()];
    match &raw.normals {
        Some(normals) => {
            for (vertex, particle) in rest.used_vertices() {
                sums[particle] += normals[vertex].normalize_or_zero();
            }
        }
        None => {
            for triangle in &raw.triangles {
                let [a, b, c] = triangle.map(|vertex| raw.positions[vertex as usize]);
                let normal = (b - a).cross(c - a);
                for particle in triangle.iter().filter_map(|&vertex| rest.particle_of(vertex)) {
                    sums[particle as usize] += normal;
                }
            }
        }
    }
    sums.into_iter().map(Vec3::normalize_or_zero).collect()
}
