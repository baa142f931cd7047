//! Loads saved distance fields, and says which will never come.

use std::io;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoadError, AssetLoader, LoadContext, LoadState};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::collider::shape::SdfShape;
use crate::error::ClothErrorKind;
use crate::error::problems::FieldProblem;
use crate::sdf::{DistanceField, SavedFieldError};

/// Loads `.sdf` files, which [`DistanceField::to_bytes`] makes; [`ClothPlugin`](crate::ClothPlugin)
/// registers it.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn spawn(mut commands: Commands, assets: Res<AssetServer>) {
/// commands.spawn(SdfCollider::field(assets.load("rock.sdf")));
/// # }
/// ```
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct DistanceFieldLoader;

/// Why an `.sdf` file could not be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadFieldError {
    /// The file cannot be read.
    #[error("it cannot be read: {0}")]
    Read(#[from] io::Error),
    /// It holds no distance field.
    #[error(transparent)]
    Content(#[from] SavedFieldError),
}

impl AssetLoader for DistanceFieldLoader {
    type Asset = DistanceField;
    type Settings = ();
    type Error = LoadFieldError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        _: &mut LoadContext<'_>,
    ) -> Result<DistanceField, LoadFieldError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(DistanceField::from_bytes(&bytes)?)
    }

    fn extensions(&self) -> &[&str] {
        &["sdf"]
    }
}

/// The app's distance fields, where it has any.
#[derive(SystemParam)]
pub(crate) struct FieldSource<'w> {
    fields: Option<Res<'w, Assets<DistanceField>>>,
    server: Option<Res<'w, AssetServer>>,
}

impl FieldSource<'_> {
    /// The fields that are there.
    pub fn assets(&self) -> Option<&Assets<DistanceField>> {
        self.fields.as_deref()
    }

    /// Whether the shape's field, if it is one, is there or may still come.
    pub fn check(&self, shape: &SdfShape) -> Result<(), ClothErrorKind> {
        let SdfShape::Field(handle) = shape else {
            return Ok(());
        };
        if self.fields.as_ref().is_some_and(|fields| fields.contains(handle)) {
            return Ok(());
        }
        let problem = match self.server.as_ref().and_then(|server| server.get_load_state(handle)) {
            Some(LoadState::Loading) => return Ok(()),
            Some(LoadState::Failed(error)) => load_problem(handle, &error),
            _ => FieldProblem::Missing,
        };
        Err(ClothErrorKind::Field(problem))
    }
}

/// The problem that a failed load is told as.
fn load_problem(handle: &Handle<DistanceField>, error: &AssetLoadError) -> FieldProblem {
    let path = handle.path().map(ToString::to_string).unwrap_or_default();
    let content = match error {
        AssetLoadError::AssetLoaderError(error) => error.error().downcast_ref(),
        _ => None,
    };
    match content {
        Some(LoadFieldError::Content(problem)) => {
            FieldProblem::Content { path, problem: problem.clone() }
        }
        _ => FieldProblem::LoadFailed { path, reason: error.to_string() },
    }
}
