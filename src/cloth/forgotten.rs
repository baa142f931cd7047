//! A cloth in a world that has no plugin does not move, and nothing else would say why.

use bevy::ecs::lifecycle::HookContext;
use bevy::ecs::world::DeferredWorld;
use bevy::prelude::*;

use crate::mesh::rest_cache::RestCache;

/// The world was told.
#[derive(Resource)]
struct Told;

/// Says, once a world, that a cloth wants the plugin.
pub(crate) fn ask_for_plugin(mut world: DeferredWorld, context: HookContext) {
    if world.contains_resource::<RestCache>() {
        return;
    }
    // Queued, so that of many cloths spawned together one is told of.
    world.commands().queue(move |world: &mut World| {
        if !world.contains_resource::<Told>() {
            world.insert_resource(Told);
            tracing::warn!(
                "cloth {} is in a world without `ClothPlugin`, and does not move: add the plugin to the app",
                context.entity
            );
        }
    });
}
