//! Bodies of Rapier that cloths move: carried, at rest, asleep, awake again.

use crate::falls::physics_app;
use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{ClothCollider, ColliderMass, RapierClothPlugin, prelude::*};
use bevy_rapier3d::prelude::*;

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

/// A metre of cloth held at its corners, `count` particles a side.
fn hammock(app: &mut App, count: u32) -> Entity {
    let corners = [0, count - 1, count * (count - 1), count * count - 1];
    let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(count));
    spawn(app, (cloth, ClothPins::vertices(corners)))
}

fn ball(app: &mut App, mass: f32, at: Vec3) -> Entity {
    let ball = (RigidBody::Dynamic, Collider::ball(0.15), ColliderMassProperties::Mass(mass));
    let ball = (ball, ClothCollider::default(), Sleeping::default());
    spawn(app, (ball, Transform::from_translation(at)))
}

fn place(app: &App, body: Entity) -> Vec3 {
    app.world().get::<Transform>(body).unwrap().translation
}

fn sleeps(app: &App, body: Entity) -> bool {
    app.world().get::<Sleeping>(body).unwrap().sleeping
}

/// How far a body goes up and down in a second \[m\].
fn swing(app: &mut App, body: Entity) -> f32 {
    let heights: Vec<_> = (0..64)
        .map(|_| {
            app.update();
            place(app, body).y
        })
        .collect();
    let most = heights.iter().fold(f32::MIN, |a, &b| a.max(b));
    most - heights.iter().fold(f32::MAX, |a, &b| a.min(b))
}

#[test]
fn a_hammock_carries_balls_of_any_mass() {
    for mass in [0.05, 0.2, 1.0, 3.0, 10.0] {
        let mut app = physics_app();
        hammock(&mut app, 32);
        let body = ball(&mut app, mass, Vec3::Y * 0.5);
        updates(&mut app, 9 * 64);
        let swings = 0.5 * swing(&mut app, body);
        println!("{mass} kg swings by {swings} m at {}", place(&app, body));
        assert!(swings < 5e-3, "{mass} kg swings by {swings} m");
        let at = place(&app, body);
        assert!((-0.4..0.1).contains(&at.y) && at.xz().length() < 0.05, "{mass} kg: {at}");
    }
}

#[test]
fn both_fall_asleep_and_wake_together() {
    let mut app = physics_app();
    let cloth = hammock(&mut app, 24);
    let body = ball(&mut app, 1.0, Vec3::Y * 0.2);
    let mut ticks = 0;
    while !(sleeps(&app, body) && simulation(&app, cloth).is_asleep()) {
        app.update();
        ticks += 1;
        assert!(ticks < 40 * 64, "{} {}", sleeps(&app, body), simulation(&app, cloth).is_asleep());
    }
    println!("asleep after {} s", ticks as f32 / 64.0);
    let at = place(&app, body);
    updates(&mut app, 128);
    assert!(sleeps(&app, body) && simulation(&app, cloth).is_asleep());
    assert_eq!(place(&app, body), at);
    // A corner is let go.
    insert(&mut app, cloth, ClothPins::vertices([0, 23, 24 * 24 - 1]));
    updates(&mut app, 64);
    assert!(!sleeps(&app, body) && place(&app, body).y < at.y - 0.2, "{}", place(&app, body));
}

#[test]
fn a_crate_hangs_in_a_cloth_that_is_pinned_to_it() {
    let mut app = physics_app();
    let mass = ColliderMassProperties::Mass(2.0);
    let body = (RigidBody::Dynamic, Collider::cuboid(0.5, 0.05, 0.05), mass);
    let body = spawn(&mut app, (body, Transform::from_xyz(0.0, -1.05, 0.0)));
    let pins = ClothPins::vertices(0..25).and(ClothPins::vertices(600..625).anchored_to(body));
    let upright = Transform::from_xyz(0.0, -0.5, 0.0)
        .with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    let cloth = spawn(&mut app, (Cloth::sheet(Vec2::ONE, UVec2::splat(25)), pins, upright));
    updates(&mut app, 6 * 64);
    assert!(swing(&mut app, body) < 5e-3);
    let at = place(&app, body);
    assert!((-1.1..-1.02).contains(&at.y) && at.xz().length() < 0.02, "{at}");
    assert_eq!((failure(&app, cloth), failure(&app, body)), (None, None));
    insert(&mut app, cloth, ClothPins::vertices(0..25));
    updates(&mut app, 48);
    assert!(place(&app, body).y < at.y - 1.0, "it does not fall: {}", place(&app, body));
    // Nothing moves it any more.
    assert!(app.world().get::<ColliderMass>(body).is_none());
}

#[test]
fn what_is_moved_once_a_frame_is_left_alone() {
    let by_frame = RapierPhysicsPlugin::<NoUserData>::default();
    let mut app = app_with((by_frame, ClothPlugin::default(), RapierClothPlugin::default()));
    hammock(&mut app, 16);
    let body = ball(&mut app, 1.0, Vec3::Y * 0.2);
    updates(&mut app, 64);
    assert!(app.world().get::<ColliderMass>(body).is_none());
    assert!(place(&app, body).y < -2.0, "{}", place(&app, body));
}

#[test]
fn a_body_without_a_mass_is_told_of() {
    let mut app = physics_app();
    let cloth = hammock(&mut app, 16);
    let body = ball(&mut app, 0.0, Vec3::Y * -0.2);
    updates(&mut app, 32);
    let told = failure(&app, body).expect("it is told");
    assert!(told.to_string().contains("give it a mass"), "{told}");
    assert_eq!(failure(&app, cloth), None);
    insert(&mut app, body, ColliderMassProperties::Mass(1.0));
    updates(&mut app, 8);
    assert_eq!(failure(&app, body), None);
}

#[test]
fn bodies_with_a_velocity_of_their_own_are_carried_and_fall_asleep() {
    let mut app = physics_app();
    hammock(&mut app, 24);
    let body = ball(&mut app, 1.0, Vec3::Y * 0.2);
    insert(&mut app, body, Velocity::default());
    let mut ticks = 0;
    while !sleeps(&app, body) {
        app.update();
        ticks += 1;
        assert!(ticks < 40 * 64, "it does not sleep");
    }
    let at = place(&app, body);
    assert!((-0.4..0.1).contains(&at.y), "{at}");
    // What a game does to its velocity is added.
    app.world_mut().get_mut::<Velocity>(body).unwrap().linear = Vec3::Y * 2.0;
    updates(&mut app, 8);
    assert!(place(&app, body).y > at.y + 0.1, "{}", place(&app, body));
}

#[test]
fn what_leans_in_a_cloth_falls_asleep() {
    let rough = || Friction::coefficient(leaning::FRICTION);
    let ground = |app: &mut App| {
        let solid = (RigidBody::Fixed, Collider::cuboid(5.0, 0.5, 5.0), rough());
        spawn(app, (solid, Transform::from_xyz(0.0, -0.5, 0.0)));
    };
    let board = |app: &mut App, place| {
        let Vec3 { x, y, z } = 0.5 * leaning::SIZE;
        let mass = ColliderMassProperties::Mass(leaning::MASS);
        let solid = (RigidBody::Dynamic, Collider::cuboid(x, y, z), mass, rough());
        spawn(app, (solid, ClothCollider::default(), Sleeping::default(), place))
    };
    let mut app = physics_app();
    let both = leaning::set_up(&mut app, ground, board);
    leaning::fall_asleep(&mut app, both, sleeps);
}

#[test]
fn what_becomes_kinematic_in_a_cloth_stays_where_it_is() {
    for kind in [RigidBody::KinematicPositionBased, RigidBody::KinematicVelocityBased] {
        let mut app = physics_app();
        hammock(&mut app, 24);
        let body = ball(&mut app, 1.0, Vec3::Y * 0.2);
        updates(&mut app, 128);
        assert!(app.world().get::<ColliderMass>(body).is_some());
        insert(&mut app, body, (kind, Velocity::zero()));
        let at = place(&app, body);
        updates(&mut app, 64);
        assert!(place(&app, body).distance(at) < 1e-4, "{} {at}", place(&app, body));
        assert!(app.world().get::<ColliderMass>(body).is_none());
    }
}

#[test]
fn a_pile_of_boxes_under_a_cloth_falls_asleep_and_wakes() {
    let ground = |app: &mut App| {
        let solid = (RigidBody::Fixed, Collider::cuboid(5.0, 0.5, 5.0));
        spawn(app, (solid, ClothCollider::default(), Transform::from_xyz(0.0, -0.5, 0.0)));
    };
    let cube = |app: &mut App, at| {
        let half = 0.5 * pile::SIDE;
        let mass = ColliderMassProperties::Mass(pile::MASS);
        let body = (RigidBody::Dynamic, Collider::cuboid(half, half, half), mass);
        let body = (body, ClothCollider::default(), Sleeping::default());
        spawn(app, (body, Transform::from_translation(at)))
    };
    let touch = |app: &mut App, at| {
        let ball = ball(app, 2.0, at);
        insert(app, ball, CollisionGroups::new(Group::GROUP_2, Group::GROUP_2));
        ball
    };
    pile::sleeps_and_wakes(physics_app(), ground, cube, touch, sleeps);
}
