//! Camera, sun and sky.

use crate::View;
use bevy::{
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap, NotShadowCaster},
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
};

/// Color of the sky, and of the ground far away.
const SKY: Color = Color::srgb(0.80, 0.84, 0.88);

/// Adds them.
pub(crate) fn set_up_view(
    view: Res<View>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut commands: Commands,
) {
    commands.spawn((
        Camera3d::default(),
        Transform::from_translation(view.from).looking_at(view.at, Vec3::Y),
        Projection::from(PerspectiveProjection { fov: 0.6, ..default() }),
        DistanceFog {
            color: SKY,
            falloff: FogFalloff::Linear { start: 7.0, end: 24.0 },
            ..default()
        },
    ));
    // The sky is a thing in the fog as well, so that the ground ends in it without a line.
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(27.0).mesh().uv(32, 16))),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: SKY,
            unlit: true,
            cull_mode: None,
            ..default()
        })),
        NotShadowCaster,
    ));
    // A low sun from the left shows the folds. Hems are narrow, and so is what their shadow is drawn by.
    commands.insert_resource(DirectionalLightShadowMap { size: 4096 });
    commands.spawn((
        DirectionalLight { illuminance: 8500.0, shadow_maps_enabled: true, ..default() },
        CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: 9.0, ..default() }.build(),
        Transform::from_xyz(-3.0, 3.6, 2.4).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    // The sky, from the other side, without shadows.
    commands.spawn((
        DirectionalLight { illuminance: 1500.0, color: Color::srgb(0.75, 0.85, 1.0), ..default() },
        Transform::from_xyz(3.0, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}
