//! Lines over a scene, as asked for.

use bevy::prelude::*;
use bevy_drape::{ClothGizmos, ClothGizmosPlugin, SdfSlice, prelude::*};

/// Lines to look inside.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lines {
    /// Threads, by their strain.
    Threads,
    /// What holds a cloth.
    Pins,
    /// Where it touches.
    Contacts,
    /// Where it has passed through itself.
    Crossings,
    /// What blows on it.
    Wind,
    /// Its box.
    Bounds,
    /// Lines of equal distance around baked meshes and balls.
    Fields,
}

/// Adds those that are named; threads and pins where none is.
pub(crate) fn add_gizmos(app: &mut App, lines: &[Lines]) {
    app.add_plugins(ClothGizmosPlugin);
    if !lines.is_empty() {
        let has = |line| lines.contains(&line);
        let shown = ClothGizmos {
            threads: has(Lines::Threads),
            pins: has(Lines::Pins),
            contacts: has(Lines::Contacts),
            crossings: has(Lines::Crossings),
            wind: has(Lines::Wind),
            bounds: has(Lines::Bounds),
            ..ClothGizmos::NOTHING
        };
        *app.world_mut().resource_mut::<GizmoConfigStore>().config_mut::<ClothGizmos>().1 = shown;
    }
    if lines.contains(&Lines::Fields) {
        app.add_systems(Update, slice);
    }
}

/// Slices what is not the ground.
fn slice(colliders: Query<(Entity, &SdfCollider), Added<SdfCollider>>, mut commands: Commands) {
    for (entity, collider) in &colliders {
        if !matches!(collider.shape, SdfShape::InfinitePlane3d(_)) {
            let slice = SdfSlice { half_size: 0.9, spacing: 0.06, ..default() };
            commands.entity(entity).insert(slice);
        }
    }
}
