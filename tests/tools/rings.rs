//! The curtain of the example, drawn by a mouse that is not there.
//!
//! Truth: a ring that is dragged comes to where the pointer's ray crosses the plane of the rail, as the camera
//! projects it; the others keep their parts of the way, and the cloth follows its ends.

#[allow(dead_code)]
#[path = "../../examples/curtain.rs"]
mod curtain;

use bevy::{
    camera::{
        CameraProjection, CameraProjectionPlugin, ComputedCameraValues, NormalizedRenderTarget,
        RenderTargetInfo, visibility::VisibilityPlugin,
    },
    picking::{
        InteractionPlugin, PickingPlugin, PickingSystems,
        backend::ray::{RayId, RayMap},
        mesh_picking::MeshPickingPlugin,
        pointer::{Location, PointerAction, PointerId, PointerInput},
    },
    prelude::*,
};
use bevy_drape::prelude::*;
use curtain::{Ring, draw, draw_by_mouse};
use examples_common::Particles;

use crate::support::app::*;

const POINTER: PointerId = PointerId::Mouse;
const SCREEN: UVec2 = UVec2::new(1280, 720);

/// Where the pointer is on the screen \[pixels\].
#[derive(Resource, Default)]
struct Cursor(Vec2);

/// The curtain, a camera that looks at it from the side, and a mouse.
fn app_with_rings() -> (App, Entity) {
    let picking = (PickingPlugin, InteractionPlugin, MeshPickingPlugin);
    // Bounds and what is in view, as in a window: what is in no view is not picked.
    let mut app =
        app_with((ClothPlugin::default(), VisibilityPlugin, CameraProjectionPlugin, picking));
    app.init_resource::<Cursor>()
        .insert_resource(Particles(16))
        .add_systems(FixedUpdate, draw)
        .add_observer(draw_by_mouse);
    app.world_mut().run_system_cached(curtain::spawn).unwrap();
    let projection = PerspectiveProjection { fov: 0.6, aspect_ratio: 16.0 / 9.0, ..default() };
    let screen = RenderTargetInfo { physical_size: SCREEN, scale_factor: 1.0 };
    let computed = ComputedCameraValues {
        clip_from_view: projection.get_clip_from_view(),
        target_info: Some(screen),
        ..default()
    };
    let eye = Transform::from_xyz(1.6, 1.5, 4.2).looking_at(Vec3::new(-0.15, 1.2, 0.0), Vec3::Y);
    let camera =
        spawn(&mut app, (Camera { computed, ..default() }, Projection::from(projection), eye));
    spawn(&mut app, POINTER);
    // As a window would make it.
    let aim = move |cursor: Res<Cursor>,
                    cameras: Query<(&Camera, &GlobalTransform)>,
                    mut rays: ResMut<RayMap>| {
        let (camera_now, eye) = cameras.get(camera).expect("it is there");
        let ray = camera_now.viewport_to_world(eye, cursor.0).expect("it is on the screen");
        rays.map.insert(RayId::new(camera, POINTER), ray);
    };
    app.add_systems(
        PreUpdate,
        aim.after(PickingSystems::ProcessInput).before(PickingSystems::Backend),
    );
    // Closed as far as it is by itself.
    updates(&mut app, 200);
    (app, camera)
}

/// The pixel in which a place of the world is seen.
fn pixel(app: &App, camera: Entity, at: Vec3) -> Vec2 {
    let camera = app.world().entity(camera);
    let (lens, eye) = (camera.get::<Camera>().unwrap(), camera.get::<GlobalTransform>().unwrap());
    lens.world_to_viewport(eye, at).expect("it is in view")
}

fn send(app: &mut App, action: PointerAction) {
    let target = NormalizedRenderTarget::None { width: SCREEN.x, height: SCREEN.y };
    let position = app.world().resource::<Cursor>().0;
    app.world_mut().write_message(PointerInput::new(
        POINTER,
        Location { target, position },
        action,
    ));
    updates(app, 2);
}

fn move_to(app: &mut App, pixel: Vec2) {
    let delta = pixel - app.world().resource::<Cursor>().0;
    app.world_mut().resource_mut::<Cursor>().0 = pixel;
    send(app, PointerAction::Move { delta });
}

/// Rings and their places, along the rail.
fn rings(app: &mut App) -> Vec<(f32, Vec3)> {
    let mut query = app.world_mut().query::<(&Ring, &GlobalTransform)>();
    let mut rings: Vec<_> =
        query.iter(app.world()).map(|(ring, place)| (ring.0, place.translation())).collect();
    rings.sort_by(|a, b| a.0.total_cmp(&b.0));
    rings
}

/// Presses on a ring, moves to where a place of the world is seen, in some steps, and lets go.
fn drag(app: &mut App, camera: Entity, ring: usize, to: Vec3) {
    let from = rings(app)[ring].1;
    let (start, end) = (pixel(app, camera, from), pixel(app, camera, to));
    move_to(app, start);
    send(app, PointerAction::Press(PointerButton::Primary));
    for part in 1..=4 {
        move_to(app, start.lerp(end, part as f32 / 4.0));
    }
    send(app, PointerAction::Release(PointerButton::Primary));
    // At half a metre a second, two metres at most.
    updates(app, 280);
}

#[test]
fn a_ring_comes_to_where_the_pointer_has_dragged_it() {
    let (mut app, camera) = app_with_rings();
    let cloth =
        app.world_mut().query_filtered::<Entity, With<Cloth>>().single(app.world()).unwrap();
    for (ring, x) in [(12, 0.9), (12, -0.3), (6, -0.2), (3, -0.9)] {
        let before = rings(&mut app);
        // In the plane of the rail.
        drag(&mut app, camera, ring, before[ring].1.with_x(x).with_z(0.0));
        let after = rings(&mut app);
        assert!((after[ring].1.x - x).abs() < 1e-3, "{ring} to {x}: {:?}", after[ring]);
        // All keep their part of the way from the first, which stays.
        assert_eq!(before[0], after[0]);
        let way = |ring: usize| (after[ring].1.x - after[0].1.x) / after[ring].0;
        assert!((1..13).all(|ring| (way(ring) - way(12)).abs() < 1e-4), "{after:?}");
        let hem = positions(&app, cloth);
        assert!((hem[15].x - after[12].1.x).abs() < 0.01 && hem[0].x == hem[0].x.min(hem[15].x));
    }
    assert_eq!(failure(&app, cloth), None);
}

#[test]
fn a_ring_stays_on_the_rail_and_what_is_no_ring_draws_nothing() {
    let (mut app, camera) = app_with_rings();
    let places = |app: &mut App| rings(app).iter().map(|ring| ring.1.x).collect::<Vec<_>>();
    let open = places(&mut app);
    // The first one is fixed, and a drag that begins beside the rings draws nothing.
    drag(&mut app, camera, 0, Vec3::new(0.5, 2.2, 0.0));
    assert_eq!(places(&mut app), open);
    let [from, to] = [0.9, -0.9].map(|x| pixel(&app, camera, Vec3::new(x, 1.0, 0.0)));
    move_to(&mut app, from);
    send(&mut app, PointerAction::Press(PointerButton::Primary));
    move_to(&mut app, to);
    send(&mut app, PointerAction::Release(PointerButton::Primary));
    updates(&mut app, 200);
    assert_eq!(places(&mut app), open);
    // Too far: from 0.2 to all of its 2.2 m.
    drag(&mut app, camera, 12, Vec3::new(1.6, 2.2, 0.0));
    assert!((rings(&mut app)[12].1.x - 1.1).abs() < 1e-3);
    drag(&mut app, camera, 12, Vec3::new(-1.3, 2.2, 0.0));
    assert!((rings(&mut app)[12].1.x - (0.2 * 2.2 - 1.1)).abs() < 1e-3);
}
