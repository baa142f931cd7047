//! Loads files, also where nothing is drawn.

use crate::repository;
use bevy::{
    animation::AnimationPlugin, gltf::GltfPlugin, prelude::*,
    world_serialization::WorldSerializationPlugin,
};

/// The files of the repository, wherever a program is run from.
pub(crate) fn asset_folder() -> AssetPlugin {
    AssetPlugin { file_path: repository("assets").to_string_lossy().into(), ..default() }
}

/// Adds what loads and moves them, unless it is there.
pub fn add_gltf(app: &mut App) {
    if app.is_plugin_added::<GltfPlugin>() {
        return;
    }
    app.init_asset::<Image>().add_plugins((
        WorldSerializationPlugin,
        AnimationPlugin,
        GltfPlugin::default(),
    ));
}
