//! Text over a scene, as lines: without a font.

use crate::Caption;
use bevy::{gizmos::AppGizmoBuilder, prelude::*};

/// Lines that nothing hides.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct Screen;

/// Shows the [`Caption`].
pub(crate) fn show_caption(app: &mut App) {
    app.init_gizmo_group::<Screen>()
        .add_systems(Startup, put_in_front)
        .add_systems(PostUpdate, write.after(TransformSystems::Propagate));
}

fn put_in_front(mut store: ResMut<GizmoConfigStore>) {
    store.config_mut::<Screen>().0.depth_bias = -1.0;
}

/// Writes a metre in front of the camera.
fn write(
    caption: Res<Caption>,
    camera: Single<&GlobalTransform, With<Camera3d>>,
    mut gizmos: Gizmos<Screen>,
) {
    for (line, text) in caption.0.iter().enumerate() {
        let place = camera.transform_point(Vec3::new(-0.53, 0.28 - 0.018 * line as f32, -1.0));
        let turned = Isometry3d::new(place, camera.rotation());
        gizmos.text(turned, text, 0.013, Vec2::new(-0.5, 0.5), Color::BLACK);
    }
}
