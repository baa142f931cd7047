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
        let of_mesh = |it: &RestShape| matches!(it, RestShape::Mesh(_));
        if !of_mesh(rest) {
            return Err(SkinProblem::NotAMesh);
        }
        if joints > MOST_JOINTS {
            return Err(SkinProblem::TooManyJoints { joints, most: MOST_JOINTS });
        }
        let attribute = |which| mesh.try_attribute_option(which).ok().flatten();
        let (indices, weights) =
            match (attribute(Mesh::ATTRIBUTE_JOINT_INDEX), attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT))
            {
                (
                    Some(VertexAttributeValues::Uint16x4(indices)),
                    Some(VertexAttributeValues::Float32x4(weights)),
                ) if indices.len() == rest.vertex_count() && weights.len() == indices.len() => {
                    (indices, weights)
                }
                _ => return Err(SkinProblem::NoWeights),
            };
        let raw = RawMesh::read(mesh).map_err(SkinProblem::Mesh)?;
        let count = rest.particle_count();
        let mut out = Self {
            points: vec![Vec3::NAN; count],
            normals: normals(&raw, rest),
            influences: vec![Influences::default(); count],
        };
        for (vertex, particle) in rest.used_vertices() {
            let weights = weights[vertex];
            let sum: f32 = weights.iter().sum();
            let good = weights.iter().all(|weight| (0.0..=1.0 + ROUNDING).contains(weight));
            if !good || (sum - 1.0).abs() > ROUNDING {
                return Err(SkinProblem::Weights { vertex, weights });
            }
            let followed = indices[vertex].into_iter().zip(weights).filter(|(_, w)| *w > 0.0);
            if let Some((joint, _)) = followed.clone().find(|(joint, _)| *joint as usize >= joints)
            {
                return Err(SkinProblem::NoSuchJoint { vertex, joint, joints });
            }
            if out.points[particle].is_nan() {
                out.points[particle] = raw.positions[vertex];
                out.influences[particle] = Influences { joints: indices[vertex], weights };
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
