//! From a skinned mesh's frame to those of its joints.

use bevy::asset::LoadState;
use bevy::ecs::system::SystemParam;
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;

use crate::error::skin::SkinProblem;

/// The app's inverse bind poses, where it has any.
#[derive(SystemParam)]
pub(crate) struct Bindposes<'w> {
    bindposes: Option<Res<'w, Assets<SkinnedMeshInverseBindposes>>>,
    server: Option<Res<'w, AssetServer>>,
}

impl Bindposes<'_> {
    /// Those of a skinned mesh, one for each joint; `None` while they are loading.
    ///
    /// # Errors
    /// [`SkinProblem`] where they are not there, or not as many as joints.
    pub fn of(&self, skinned: &SkinnedMesh) -> Result<Option<&[Mat4]>, SkinProblem> {
        let SkinnedMesh { inverse_bindposes, joints } = skinned;
        let bindposes = self.bindposes.as_ref().and_then(|all| all.get(inverse_bindposes));
        let Some(bindposes) = bindposes else {
            let server = self.server.as_ref();
            return match server.and_then(|server| server.get_load_state(inverse_bindposes)) {
                Some(LoadState::Loading | LoadState::NotLoaded) => Ok(None),
                _ => Err(SkinProblem::NoBindposes),
            };
        };
        if joints.len() != bindposes.len() {
            let (joints, bindposes) = (joints.len(), bindposes.len());
            return Err(SkinProblem::WrongBindposeCount { joints, bindposes });
        }
        Ok(Some(bindposes))
    }
}
