//! Waits for what is done in the background.

use bevy::prelude::*;
use bevy_drape::prelude::*;

/// Something that is loading, and that time waits for.
#[derive(Component)]
pub struct Awaited;

/// Time stands still until what is loading is there, the fields of meshes are baked and cloths that start hung are at rest, so that every
/// run is the same.
pub(crate) fn wait_for_tasks(
    baking: Query<(), (With<BakeSdf>, Without<SdfCollider>, Without<ClothFailure>)>,
    cloths: Query<&ClothSimulation>,
    awaited: Query<(), With<Awaited>>,
    mut time: ResMut<Time<Virtual>>,
) {
    if awaited.is_empty() && baking.is_empty() && !cloths.iter().any(ClothSimulation::is_hanging) {
        time.unpause();
    } else {
        time.pause();
    }
}
