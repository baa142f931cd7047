//! The mouse draws the curtain by its rings.

use super::curtain::{Rail, Ring};
use bevy::prelude::*;

/// A ring that is dragged follows the pointer along the rail, and takes the others along.
pub fn draw_by_mouse(
    drag: On<Pointer<Drag>>,
    rings: Query<&Ring>,
    handles: Query<&ChildOf>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut rail: Single<&mut Rail>,
) {
    // The ring itself, or the handle around it.
    let dragged = handles.get(drag.entity).map_or(drag.entity, ChildOf::parent);
    let (Ok(ring), (camera, eye)) = (rings.get(dragged), *camera) else { return };
    // Where the pointer's ray crosses the upright plane of the rail.
    if let Ok(ray) = camera.viewport_to_world(eye, drag.pointer_location.position)
        && let Some(at) = ray.plane_intersection_point(Vec3::ZERO, InfinitePlane3d::new(Vec3::Z))
    {
        rail.draw_to(ring, at.x);
    }
}
