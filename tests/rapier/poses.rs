//! Where colliders are: scaled, as children of bodies, and in each tick.

use crate::falls::physics_app;
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothCollider, prelude::*};
use bevy_rapier3d::prelude::*;

/// The least distance, negative inside, of a cloth's particles to a collider, after it has fallen onto it.
fn rests_on(app: &mut App, entity: Entity) -> f32 {
    let cloth = spawn(app, (sheet(), Transform::from_xyz(0.0, 1.2, 0.0)));
    updates(app, 100);
    assert_eq!(failure(app, entity), None);
    let collider = app.world().get::<Collider>(entity).unwrap();
    let place = app.world().get::<Transform>(entity).unwrap();
    let distance = |p: &Vec3| {
        let (place, turn) = (place.translation, place.rotation);
        let distance = collider.distance_to_point(place, turn, *p, false);
        if collider.contains_point(place, turn, *p) { -distance } else { distance }
    };
    positions(app, cloth).iter().map(distance).fold(f32::MAX, f32::min)
}

/// A cube of 0.4 m as a hull.
fn hull() -> Collider {
    let signs = [-0.2, 0.2];
    let corner = |i: usize| Vec3::new(signs[i & 1], signs[i >> 1 & 1], signs[i >> 2 & 1]);
    Collider::convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
}

#[test]
fn scaled_colliders_are_where_the_engine_has_them() {
    let even = Vec3::splat(3.0);
    let uneven = Vec3::new(3.0, 2.0, 4.0);
    for (collider, scale) in [
        (Collider::ball(0.2), even),
        (Collider::ball(0.2), uneven),
        (Collider::cuboid(0.2, 0.2, 0.2), uneven),
        (Collider::capsule_y(0.1, 0.2), even),
        (hull(), even),
        (hull(), uneven),
    ] {
        let mut app = physics_app();
        let turned = Quat::from_rotation_y(0.4);
        let place = Transform::from_rotation(turned).with_scale(scale);
        let entity = spawn(&mut app, (collider, RigidBody::Fixed, place, ClothCollider::default()));
        wait(&mut app, |app| app.world().get::<SdfCollider>(entity).is_some());
        let least = rests_on(&mut app, entity);
        // A baked corner is off by half a cell.
        assert!((-0.012..0.03).contains(&least), "{scale}: {least}");
    }
}

#[test]
fn a_change_of_scale_is_followed() {
    let mut app = physics_app();
    let entity =
        spawn(&mut app, (Collider::ball(0.2), Transform::default(), ClothCollider::default()));
    app.update();
    transform(&mut app, entity).scale = Vec3::new(2.0, 3.0, 2.5);
    updates(&mut app, 2);
    // A ball that is scaled unevenly is a hull, which is baked.
    let is_baked = |app: &App| {
        let collider = app.world().get::<SdfCollider>(entity);
        collider.is_some_and(|it| matches!(it.shape, SdfShape::Custom(_)))
    };
    wait(&mut app, is_baked);
    let least = rests_on(&mut app, entity);
    assert!((0.0..0.03).contains(&least), "{least}");
}

#[test]
fn a_hull_that_is_scaled_anew_sweeps_nothing() {
    let mut app = physics_app();
    let place = Transform::from_scale(Vec3::splat(3.0));
    let entity = spawn(&mut app, (hull(), place, ClothCollider::default()));
    wait(&mut app, |app| app.world().get::<SdfCollider>(entity).is_some());
    // It floats beside the hull.
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(1.5, 0.1, 0.0)));
    app.update();
    // At three times the size that it is baked in, it would reach up to the cloth for a tick.
    transform(&mut app, entity).scale = Vec3::new(3.0, 2.0, 3.0);
    for _ in 0..40 {
        app.update();
        std::thread::sleep(std::time::Duration::from_millis(10));
        let mean = positions(&app, cloth).iter().sum::<Vec3>() / 64.0;
        assert!((mean.x - 1.5).abs() < 1e-3, "{mean}");
    }
}

#[test]
fn children_of_bodies_go_with_them() {
    let mut app = physics_app();
    let body = spawn(
        &mut app,
        (
            RigidBody::KinematicVelocityBased,
            Transform::from_xyz(1.0, 0.0, 0.0).with_rotation(Quat::from_rotation_z(0.3)),
            Velocity::angular(Vec3::Y),
        ),
    );
    let child = spawn(
        &mut app,
        (
            Collider::ball(0.3),
            Transform::from_xyz(-1.0, 0.5, 0.0),
            ClothCollider::default(),
            ChildOf(body),
        ),
    );
    updates(&mut app, 40);
    // Lies on it, and is carried along.
    let centre = app.world().get::<GlobalTransform>(child).unwrap().translation();
    let cloth = spawn(&mut app, (sheet(), Transform::from_translation(centre + 0.35 * Vec3::Y)));
    for _ in 0..60 {
        app.update();
        let centre = app.world().get::<GlobalTransform>(child).unwrap().translation();
        let least =
            positions(&app, cloth).iter().map(|p| p.distance(centre)).fold(f32::MAX, f32::min);
        assert!(least > 0.295, "{least}");
    }
}
