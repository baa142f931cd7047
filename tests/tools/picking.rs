//! A mouse that is not there: rays and buttons go through Bevy's picking as those of a window do.
//!
//! Truths: a ray meets a cloth where it is now and not where it was; what is grabbed comes to where the ray
//! crosses the plane it was grabbed in, within what the spring gives under the weight it lifts.

use crate::support::app::*;
use bevy::{
    camera::NormalizedRenderTarget,
    ecs::system::RunSystemOnce,
    picking::{
        InteractionPlugin, PickingPlugin, PickingSystems,
        backend::ray::{RayId, RayMap},
        mesh_picking::{
            MeshPickingSettings,
            ray_cast::{MeshRayCast, MeshRayCastSettings, RayCastVisibility},
        },
        pointer::{Location, PointerAction, PointerId, PointerInput},
    },
    prelude::*,
};
use bevy_drape::{ClothGrab, ClothInterpolation, ClothPicking, ClothPickingPlugin, prelude::*};

const POINTER: PointerId = PointerId::Mouse;

/// Where the mouse points.
#[derive(Resource)]
struct Aim {
    camera: Entity,
    at: Vec3,
}

/// A camera at z = 4 that looks along -z, and a mouse.
fn app_with_mouse() -> App {
    let mut app =
        app_with((ClothPlugin::default(), PickingPlugin, InteractionPlugin, ClothPickingPlugin));
    app.insert_resource(MeshPickingSettings {
        ray_cast_visibility: RayCastVisibility::Any,
        ..default()
    });
    let camera = spawn(&mut app, (Camera::default(), Transform::from_xyz(0.0, 0.0, 4.0)));
    spawn(&mut app, POINTER);
    app.insert_resource(Aim { camera, at: Vec3::new(9.0, 9.0, 0.0) });
    let aim = |aim: Res<Aim>, mut rays: ResMut<RayMap>| {
        let from = Vec3::new(0.0, 0.0, 4.0);
        let direction = Dir3::new(aim.at - from).expect("it is away from the camera");
        rays.map.insert(RayId::new(aim.camera, POINTER), Ray3d::new(from, direction));
    };
    app.add_systems(
        PreUpdate,
        aim.after(PickingSystems::ProcessInput).before(PickingSystems::Backend),
    );
    app
}

fn point_at(app: &mut App, at: Vec3) {
    app.world_mut().resource_mut::<Aim>().at = at;
    app.update();
}

fn button(app: &mut App, action: PointerAction) {
    let target = NormalizedRenderTarget::None { width: 100, height: 100 };
    let location = Location { target, position: Vec2::splat(50.0) };
    app.world_mut().write_message(PointerInput::new(POINTER, location, action));
    app.update();
    app.update();
}

/// A metre of cloth that hangs upright from its first row, its middle at the origin.
fn hanging() -> impl Bundle {
    (
        sheet(),
        ClothPins::from(PinSelection::FirstRow),
        ClothMaterial { drag: 2.0, ..default() },
        Transform::from_rotation(Quat::from_rotation_x(90.0_f32.to_radians())),
    )
}

#[test]
fn rays_meet_the_cloth_where_it_is_now() {
    let mut app = app_with_mouse();
    let cloth = spawn(&mut app, (sheet(), ClothInterpolation::LastTick));
    updates(&mut app, 2);
    let hit = |app: &mut App, from: Vec3, way: Dir3| {
        let cast = move |mut cast: MeshRayCast| {
            let settings = MeshRayCastSettings::default().with_visibility(RayCastVisibility::Any);
            cast.cast_ray(Ray3d::new(from, way), &settings).first().map(|(_, hit)| hit.point)
        };
        app.world_mut().run_system_once(cast).unwrap()
    };
    for ticks in [0, 20, 40] {
        updates(&mut app, ticks);
        let middle = positions(&app, cloth).iter().sum::<Vec3>() / 64.0;
        // From above and from below: it has two sides.
        for (from, way) in [(3.0, Dir3::NEG_Y), (-9.0, Dir3::Y)] {
            let at = hit(&mut app, Vec3::new(0.03, from, 0.02), way).expect("it is there");
            assert!((at.y - middle.y).abs() < 1e-3, "{at} {middle}");
        }
        // Level with where it was.
        if ticks > 0 {
            assert_eq!(hit(&mut app, Vec3::new(-5.0, 0.0, 0.0), Dir3::X), None);
        }
    }
}

#[test]
fn the_mouse_grabs_pulls_and_lets_go() {
    let mut app = app_with_mouse();
    let cloth = spawn(&mut app, hanging());
    updates(&mut app, 100);
    let start = Vec3::new(0.2, -0.3, 0.0);
    point_at(&mut app, start);
    button(&mut app, PointerAction::Press(PointerButton::Primary));
    let grab = *app.world().get::<ClothGrab>(cloth).expect("it is grabbed");
    assert!(grab.target.distance(start) < 0.01, "{grab:?}");
    let nearest = |app: &App, to: Vec3| {
        positions(app, cloth).iter().map(|it| it.distance(to)).fold(f32::MAX, f32::min)
    };
    // To the side and up, in the plane where it was grabbed. The spring of 200 N/m lifts some 2 N.
    let goal = Vec3::new(0.1, 0.1, 0.0);
    point_at(&mut app, goal);
    updates(&mut app, 200);
    let target = app.world().get::<ClothGrab>(cloth).unwrap().target;
    assert!(target.distance(goal) < 0.01 && nearest(&app, goal) < 0.03, "{target}");
    button(&mut app, PointerAction::Release(PointerButton::Primary));
    assert!(app.world().get::<ClothGrab>(cloth).is_none());
    // It falls back to where it hung.
    updates(&mut app, 400);
    assert!(nearest(&app, Vec3::new(0.0, -0.5, 0.0)) < 0.1);
    assert_eq!(failure(&app, cloth), None);
}

#[test]
fn what_is_not_asked_for_is_not_grabbed() {
    let mut app = app_with_mouse();
    let cloth = spawn(&mut app, hanging());
    updates(&mut app, 10);
    let grabbed = |app: &App| app.world().get::<ClothGrab>(cloth).copied();
    // Beside the cloth; by another button; switched off.
    point_at(&mut app, Vec3::new(0.9, 0.0, 0.0));
    button(&mut app, PointerAction::Press(PointerButton::Primary));
    button(&mut app, PointerAction::Release(PointerButton::Primary));
    point_at(&mut app, Vec3::ZERO);
    button(&mut app, PointerAction::Press(PointerButton::Secondary));
    button(&mut app, PointerAction::Release(PointerButton::Secondary));
    app.world_mut().resource_mut::<ClothPicking>().enabled = false;
    button(&mut app, PointerAction::Press(PointerButton::Primary));
    button(&mut app, PointerAction::Release(PointerButton::Primary));
    assert_eq!(grabbed(&app), None);
    // The game's own grab stays the game's.
    app.world_mut().resource_mut::<ClothPicking>().enabled = true;
    let own = ClothGrab::particle(3, Vec3::ONE);
    app.world_mut().entity_mut(cloth).insert(own);
    button(&mut app, PointerAction::Press(PointerButton::Primary));
    button(&mut app, PointerAction::Release(PointerButton::Primary));
    assert_eq!(grabbed(&app), Some(own));
}

#[test]
fn a_cloth_that_goes_while_it_is_held_is_let_go() {
    let mut app = app_with_mouse();
    let cloth = spawn(&mut app, hanging());
    updates(&mut app, 10);
    point_at(&mut app, Vec3::ZERO);
    button(&mut app, PointerAction::Press(PointerButton::Primary));
    assert!(app.world().get::<ClothGrab>(cloth).is_some());
    app.world_mut().despawn(cloth);
    updates(&mut app, 3);
    button(&mut app, PointerAction::Release(PointerButton::Primary));
}
