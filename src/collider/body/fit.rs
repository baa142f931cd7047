//! Reads the skinned meshes of a body, and makes a list of capsules.

use bevy::ecs::system::SystemParam;
use bevy::math::Affine3A;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;
use bevy_drape_core::sdf::fit::{BodySurface, JointCapsule, fit_body};

use crate::cloth::Cloth;
use crate::collider::body::BodyCapsule;
use crate::error::body::BodyProblem;
use crate::error::skin::SkinProblem;
use crate::mesh::raw::RawMesh;
use crate::mesh::skinned::VertexWeights;
use crate::mesh::source::MeshSource;
use crate::pose::bindposes::Bindposes;

/// What bodies are made of.
#[derive(SystemParam)]
pub(crate) struct Skinned<'w, 's> {
    skinned: Query<'w, 's, (&'static SkinnedMesh, Option<&'static Mesh3d>), Without<Cloth>>,
    children: Query<'w, 's, &'static Children>,
    parents: Query<'w, 's, &'static ChildOf>,
    bindposes: Bindposes<'w>,
}

/// A skinned mesh, read.
struct Surface {
    raw: RawMesh,
    owners: Vec<u16>,
    inverse_bindposes: Vec<Affine3A>,
    /// Its joints, by their places in the skeleton.
    joints: Vec<usize>,
}

impl Skinned<'_, '_> {
    /// The capsules of a body; `None` while its meshes are loading.
    ///
    /// # Errors
    /// [`BodyProblem`] where there is no mesh, or one that cannot be read.
    pub fn fit(
        &self,
        body: Entity,
        meshes: &MeshSource,
    ) -> Result<Option<Vec<BodyCapsule>>, BodyProblem> {
        let mut skeleton = Numbered::default();
        let mut surfaces = Vec::new();
        for mesh in core::iter::once(body).chain(self.children.iter_descendants(body)) {
            let Ok((skinned, mesh3d)) = self.skinned.get(mesh) else { continue };
            let problem = |problem| BodyProblem::Mesh { mesh, problem };
            match self.read(skinned, mesh3d, meshes, &mut skeleton).map_err(problem)? {
                Some(surface) => surfaces.push(surface),
                None => return Ok(None),
            }
        }
        if surfaces.is_empty() {
            return Err(BodyProblem::NoSkinnedMesh);
        }
        let parents: Vec<_> = skeleton.joints.iter().map(|it| self.above(*it, &skeleton)).collect();
        let surfaces: Vec<_> = surfaces.iter().map(Surface::view).collect();
        let capsule = |JointCapsule { joint, capsule }: JointCapsule| BodyCapsule {
            joint: skeleton.joints[joint],
            from: capsule.from,
            to: capsule.to,
            radius: capsule.radius,
        };
        let capsules: Vec<_> = fit_body(&surfaces, &parents).into_iter().map(capsule).collect();
        if capsules.is_empty() { Err(BodyProblem::NoArea) } else { Ok(Some(capsules)) }
    }

    fn read(
        &self,
        skinned: &SkinnedMesh,
        mesh3d: Option<&Mesh3d>,
        meshes: &MeshSource,
        skeleton: &mut Numbered,
    ) -> Result<Option<Surface>, SkinProblem> {
        let Some(bindposes) = self.bindposes.of(skinned)? else { return Ok(None) };
        let handle = mesh3d.map(|it| &it.0);
        let Some(mesh) = meshes.get(handle).map_err(SkinProblem::Mesh)? else { return Ok(None) };
        let raw = RawMesh::read(mesh).map_err(SkinProblem::Mesh)?;
        let weights = VertexWeights::read(mesh, raw.positions.len(), skinned.joints.len())?;
        let owners = (0..raw.positions.len()).map(|vertex| weights.strongest(vertex));
        Ok(Some(Surface {
            owners: owners.collect::<Result<_, _>>()?,
            raw: raw.within(),
            inverse_bindposes: bindposes.iter().map(|it| Affine3A::from_mat4(*it)).collect(),
            joints: skinned.joints.iter().map(|joint| skeleton.number(*joint)).collect(),
        }))
    }

    /// The nearest joint above another.
    fn above(&self, joint: Entity, skeleton: &Numbered) -> Option<usize> {
        self.parents.iter_ancestors(joint).find_map(|it| skeleton.numbers.get(&it).copied())
    }
}

impl Surface {
    fn view(&self) -> BodySurface<'_> {
        BodySurface {
            points: &self.raw.positions,
            triangles: &self.raw.triangles,
            owners: &self.owners,
            joints: &self.joints,
            inverse_bindposes: &self.inverse_bindposes,
        }
    }
}

/// The joints of all meshes, each once.
#[derive(Default)]
struct Numbered {
    joints: Vec<Entity>,
    numbers: HashMap<Entity, usize>,
}

impl Numbered {
    fn number(&mut self, joint: Entity) -> usize {
        *self.numbers.entry(joint).or_insert_with(|| {
            self.joints.push(joint);
            self.joints.len() - 1
        })
    }
}
