//! Waits for what is done in the background.

use bevy::prelude::*;
use bevy_drape::prelude::*;

/// Time stands still until the fields of meshes are baked and cloths that start hung are at rest, so that every
/// run is the same.
pub(crate) fn wait_for_tasks(
    baking: Query<(), (With<BakeSdf>, Without<SdfCollider>, Without<ClothFailure>)>,
    cloths: Query<&ClothSimulation>,
    mut time: ResMut<Time<Virtual>>,
) {
    if baking.is_empty() && !cloths.iter().any(ClothSimulation::is_hanging) {
        time.unpause();
    } else {
        time.pause();
    }
}
