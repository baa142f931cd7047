//! Colliders that come, change and go.

use crate::falls::{physics, physics_app};
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothCollider, ClothLayers, RapierClothPlugin, SdfColliderDisabled, SdfShape, prelude::*,
};
use bevy_rapier3d::prelude::*;

fn sphere(app: &mut App) -> Entity {
    spawn(app, (Collider::ball(0.3), Transform::default(), ClothCollider::default()))
}

fn has_solid(app: &App, entity: Entity) -> bool {
    app.world().get::<SdfCollider>(entity).is_some()
}

fn radius(app: &App, entity: Entity) -> Option<f32> {
    match app.world().get::<SdfCollider>(entity)?.shape {
        SdfShape::Sphere(sphere) => Some(sphere.radius),
        _ => None,
    }
}

#[test]
fn what_is_marked_is_met_until_it_is_not() {
    let mut app = physics_app();
    let entity = sphere(&mut app);
    let unmarked = spawn(&mut app, (Collider::ball(0.3), Transform::default()));
    app.update();
    assert!(has_solid(&app, entity) && !has_solid(&app, unmarked));
    app.world_mut().entity_mut(entity).remove::<ClothCollider>();
    app.update();
    assert!(!has_solid(&app, entity));
    app.world_mut().entity_mut(entity).insert(ClothCollider::default());
    app.update();
    assert!(has_solid(&app, entity));
    app.world_mut().entity_mut(entity).remove::<Collider>();
    assert!(!has_solid(&app, entity));
}

/// Puts a component on an entity, and takes it off again.
fn on_and_off<C: Component + Default>(app: &mut App, on: Entity, collider: Entity) {
    app.update();
    assert!(has_solid(app, collider));
    app.world_mut().entity_mut(on).insert(C::default());
    app.update();
    assert!(!has_solid(app, collider), "{}", core::any::type_name::<C>());
    app.world_mut().entity_mut(on).remove::<C>();
    app.update();
    assert!(has_solid(app, collider), "{}", core::any::type_name::<C>());
}

#[test]
fn sensors_and_what_is_disabled_are_passed_through() {
    let mut app = physics_app();
    let entity = sphere(&mut app);
    on_and_off::<Sensor>(&mut app, entity, entity);
    on_and_off::<ColliderDisabled>(&mut app, entity, entity);
    let body = spawn(&mut app, (RigidBody::KinematicPositionBased, Transform::default()));
    app.world_mut().entity_mut(entity).insert(ChildOf(body));
    on_and_off::<RigidBodyDisabled>(&mut app, body, entity);
}

#[test]
fn all_are_met_where_the_plugin_says_so() {
    let mut app = app_with((physics(), ClothPlugin::default(), RapierClothPlugin::all()));
    let entity = spawn(&mut app, (Collider::ball(0.3), Transform::default()));
    let sensor = spawn(&mut app, (Collider::ball(0.3), Transform::default(), Sensor));
    let passed = spawn(&mut app, (Collider::ball(0.3), Transform::default(), SdfColliderDisabled));
    app.update();
    assert!(has_solid(&app, entity));
    assert!(!has_solid(&app, sensor) && !has_solid(&app, passed));
    app.world_mut().entity_mut(passed).remove::<SdfColliderDisabled>();
    app.update();
    assert!(has_solid(&app, passed));
}

#[test]
fn a_solid_of_the_users_own_wins() {
    let mut app = physics_app();
    let own = SdfCollider::from(Sphere::new(0.7));
    let before = spawn(&mut app, (Collider::ball(0.3), own.clone(), ClothCollider::default()));
    let later = sphere(&mut app);
    app.update();
    assert_eq!((radius(&app, before), radius(&app, later)), (Some(0.7), Some(0.3)));
    app.world_mut().entity_mut(later).insert(own);
    *app.world_mut().get_mut::<Collider>(later).unwrap() = Collider::ball(0.2);
    app.update();
    assert_eq!(radius(&app, later), Some(0.7));
    // It stays when nothing of the engine is left, and its place is taken where it goes.
    app.world_mut().entity_mut(before).remove::<ClothCollider>();
    app.world_mut().entity_mut(later).remove::<SdfCollider>();
    app.update();
    assert_eq!((radius(&app, before), radius(&app, later)), (Some(0.7), Some(0.2)));
}

#[test]
fn shape_friction_and_layers_follow() {
    let mut app = physics_app();
    let entity = sphere(&mut app);
    let surface = |app: &App| {
        let collider = app.world().get::<SdfCollider>(entity).unwrap();
        (collider.friction, collider.layers)
    };
    app.update();
    assert_eq!(surface(&app), (0.5, ClothLayers::ALL));
    app.world_mut().entity_mut(entity).insert(Friction::coefficient(0.7));
    app.update();
    assert_eq!(surface(&app), (0.7, ClothLayers::ALL));
    let wish = ClothCollider { friction: Some(0.1), layers: ClothLayers(4), ..default() };
    app.world_mut().entity_mut(entity).insert(wish);
    app.update();
    assert_eq!(surface(&app), (0.1, ClothLayers(4)));
    *app.world_mut().get_mut::<Collider>(entity).unwrap() = Collider::ball(0.2);
    app.update();
    assert_eq!(radius(&app, entity), Some(0.2));
    assert_eq!(surface(&app), (0.1, ClothLayers(4)));
}

#[test]
fn what_is_unchanged_is_not_touched() {
    #[derive(Resource, Default)]
    struct Changes(usize);
    let mut app = physics_app();
    app.init_resource::<Changes>();
    app.add_systems(
        Last,
        |changed: Query<(), Changed<SdfCollider>>, mut changes: ResMut<Changes>| {
            changes.0 += changed.iter().count();
        },
    );
    sphere(&mut app);
    spawn(
        &mut app,
        (RigidBody::Dynamic, Collider::ball(0.1), Transform::default(), ClothCollider::default()),
    );
    updates(&mut app, 10);
    assert_eq!(app.world().resource::<Changes>().0, 2);
}

#[test]
fn what_is_gone_is_passed_through() {
    let mut app = physics_app();
    let entity = sphere(&mut app);
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(0.0, 0.35, 0.0)));
    updates(&mut app, 30);
    assert!(positions(&app, cloth).iter().all(|p| p.length() > 0.3));
    app.world_mut().despawn(entity);
    updates(&mut app, 60);
    assert!(positions(&app, cloth).iter().all(|p| p.y < -0.3));
}

#[test]
fn an_inspector_sees_the_marker() {
    let app = physics_app();
    let registry = app.world().resource::<AppTypeRegistry>().read();
    let known = registry.get_with_short_type_path("ClothCollider");
    assert!(known.is_some_and(|it| it.data::<ReflectComponent>().is_some()));
}
