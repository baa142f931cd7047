//! The Stanford bunny.

use crate::repository;
use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};

/// The Stanford bunny of `assets/`, 1 m long, sitting on y = 0. It looks towards its -x.
///
/// # Panics
/// When the file cannot be read.
pub fn load_bunny() -> Mesh {
    let path = repository("assets/bunny.obj");
    let (models, _) = tobj::load_obj(&path, &tobj::GPU_LOAD_OPTIONS)
        .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
    let bunny = &models[0].mesh;
    let positions: Vec<[f32; 3]> = bunny.positions.as_chunks().0.to_vec();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(Indices::U32(bunny.indices.clone()))
        .with_computed_smooth_normals()
}
