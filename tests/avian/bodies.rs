//! Bodies of Avian that cloths move: carried, at rest, asleep, awake again.

use crate::falls::physics_app;
use crate::support::app::*;
use avian3d::prelude::*;
use bevy::prelude::*;
use bevy_drape::{ClothCollider, ColliderMass, prelude::*};

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

/// A metre of cloth held at its corners, `count` particles a side.
pub fn hammock(app: &mut App, count: u32) -> Entity {
    let corners = [0, count - 1, count * (count - 1), count * count - 1];
    let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(count));
    spawn(app, (cloth, ClothPins::vertices(corners)))
}

pub fn ball(app: &mut App, mass: f32, at: Vec3) -> Entity {
    let ball = (RigidBody::Dynamic, Collider::sphere(0.15), Mass(mass));
    spawn(app, (ball, ClothCollider::default(), Transform::from_translation(at)))
}

fn place(app: &App, body: Entity) -> Vec3 {
    app.world().get::<Position>(body).unwrap().0
}

fn sleeps(app: &App, body: Entity) -> bool {
    app.world().get::<Sleeping>(body).is_some()
}

/// How far a body goes up and down in a second \[m\].
fn swing(app: &mut App, body: Entity) -> f32 {
    let heights: Vec<_> = (0..64)
        .map(|_| {
            app.update();
            place(app, body).y
        })
        .collect();
    let most = |a: f32, &b: &f32| a.max(b);
    heights.iter().fold(f32::MIN, most) + heights.iter().map(|y| -y).fold(f32::MIN, f32::max)
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
    let body = (RigidBody::Dynamic, Collider::cuboid(1.0, 0.1, 0.1), Mass(2.0));
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
fn one_way_bodies_and_those_that_stand_are_left_alone() {
    let mut app = physics_app();
    let cloth = hammock(&mut app, 16);
    let place_at = Transform::from_xyz(0.0, -0.2, 0.0);
    for kind in [RigidBody::Static, RigidBody::Kinematic] {
        let wall = (kind, Collider::sphere(0.15), ClothCollider::default(), place_at);
        let wall = spawn(&mut app, wall);
        updates(&mut app, 64);
        assert!(app.world().get::<ColliderMass>(wall).is_none(), "{kind:?}");
        assert!(simulation(&app, cloth).last_tick().unwrap().contact_count > 0);
        app.world_mut().despawn(wall);
    }
    let body = ball(&mut app, 1.0, Vec3::Y * 0.2);
    insert(&mut app, body, ClothCollider { one_way: true, ..default() });
    updates(&mut app, 64);
    assert!(app.world().get::<ColliderMass>(body).is_none());
    assert!(place(&app, body).y < -2.0, "{}", place(&app, body));
}

#[test]
fn a_cloth_waits_with_physics_that_is_paused() {
    let mut app = physics_app();
    hammock(&mut app, 16);
    let body = ball(&mut app, 1.0, Vec3::Y * 0.16);
    updates(&mut app, 64);
    app.world_mut().resource_mut::<Time<Physics>>().pause();
    app.update();
    let at = place(&app, body);
    updates(&mut app, 64);
    assert_eq!(place(&app, body), at);
    app.world_mut().resource_mut::<Time<Physics>>().unpause();
    updates(&mut app, 6 * 64);
    assert!(swing(&mut app, body) < 0.02);
}

#[test]
fn a_body_without_a_mass_is_told_of() {
    let mut app = physics_app();
    let cloth = hammock(&mut app, 16);
    let body = ball(&mut app, 0.0, Vec3::Y * -0.2);
    insert(&mut app, body, (NoAutoMass, GravityScale(0.0)));
    updates(&mut app, 32);
    let told = failure(&app, body).expect("it is told");
    assert!(told.to_string().contains("give it a mass"), "{told}");
    assert_eq!(failure(&app, cloth), None);
    insert(&mut app, body, Mass(1.0));
    updates(&mut app, 8);
    assert_eq!(failure(&app, body), None);
}

#[test]
fn a_pile_of_boxes_under_a_cloth_falls_asleep_and_wakes() {
    let ground = |app: &mut App| {
        let solid = (RigidBody::Static, Collider::cuboid(10.0, 1.0, 10.0));
        spawn(app, (solid, ClothCollider::default(), Transform::from_xyz(0.0, -0.5, 0.0)));
    };
    let cube = |app: &mut App, at| {
        let solid = Collider::cuboid(pile::SIDE, pile::SIDE, pile::SIDE);
        let body = (RigidBody::Dynamic, solid, Mass(pile::MASS));
        spawn(app, (body, ClothCollider::default(), Transform::from_translation(at)))
    };
    let touch = |app: &mut App, at| {
        let ball = ball(app, 2.0, at);
        insert(app, ball, CollisionLayers::NONE);
        ball
    };
    pile::sleeps_and_wakes(physics_app(), ground, cube, touch, sleeps);
}

/// A board that leans in a cloth.
fn leaning_board(app: &mut App) -> (Entity, Entity) {
    let rough = || Friction::new(leaning::FRICTION);
    let ground = |app: &mut App| {
        let solid = (RigidBody::Static, Collider::cuboid(10.0, 1.0, 10.0), rough());
        spawn(app, (solid, Transform::from_xyz(0.0, -0.5, 0.0)));
    };
    let board = |app: &mut App, place| {
        let Vec3 { x, y, z } = leaning::SIZE;
        let solid = (RigidBody::Dynamic, Collider::cuboid(x, y, z), Mass(leaning::MASS), rough());
        spawn(app, (solid, ClothCollider::default(), place))
    };
    leaning::set_up(app, ground, board)
}

#[test]
fn what_leans_in_a_cloth_falls_asleep() {
    let mut app = physics_app();
    let both = leaning_board(&mut app);
    leaning::fall_asleep(&mut app, both, sleeps);
}

#[test]
fn what_becomes_kinematic_in_a_cloth_stays_where_it_is() {
    let carried = |app: &mut App| {
        hammock(app, 24);
        ball(app, 1.0, Vec3::Y * 0.2)
    };
    for set_up in [carried, |app: &mut App| leaning_board(app).1] {
        let mut app = physics_app();
        let body = set_up(&mut app);
        updates(&mut app, 128);
        assert!(app.world().get::<ColliderMass>(body).is_some());
        insert(&mut app, body, (RigidBody::Kinematic, LinearVelocity::ZERO, AngularVelocity::ZERO));
        let at = place(&app, body);
        updates(&mut app, 64);
        assert_eq!(place(&app, body), at);
        assert_eq!(app.world().get::<AngularVelocity>(body).unwrap().0, Vec3::ZERO);
        assert!(app.world().get::<ColliderMass>(body).is_none());
        // Moved by cloth again.
        insert(&mut app, body, RigidBody::Dynamic);
        updates(&mut app, 64);
        assert!(app.world().get::<ColliderMass>(body).is_some());
        assert!(place(&app, body).distance(at) < 0.1, "{}", place(&app, body));
    }
}

#[test]
fn a_crate_lies_on_a_cloth_on_the_ground() {
    let mut app = physics_app();
    let ground = (RigidBody::Static, Collider::cuboid(10.0, 1.0, 10.0), ClothCollider::default());
    spawn(&mut app, (ground, Transform::from_xyz(0.0, -0.5, 0.0)));
    let cloth = Cloth::sheet(Vec2::splat(1.2), UVec2::splat(40));
    let cloth = spawn(&mut app, (cloth, Transform::from_xyz(0.0, 0.02, 0.0)));
    updates(&mut app, 64);
    let cube = (RigidBody::Dynamic, Collider::cuboid(0.3, 0.3, 0.3), Mass(2.0));
    let at = Transform::from_xyz(0.0, 0.4, 0.0).with_rotation(Quat::from_rotation_y(0.3));
    let cube = spawn(&mut app, (cube, ClothCollider::default(), at));
    let mut ticks = 0;
    while !(sleeps(&app, cube) && simulation(&app, cloth).is_asleep()) && ticks < 20 * 64 {
        app.update();
        ticks += 1;
        if ticks % 32 == 0 {
            let s = simulation(&app, cloth);
            println!(
                "{} s: {} v {} asleep {} {} strain {}",
                ticks as f32 / 64.0,
                place(&app, cube),
                app.world().get::<LinearVelocity>(cube).unwrap().0,
                sleeps(&app, cube),
                s.is_asleep(),
                s.strain().max
            );
        }
    }
    assert!(ticks < 20 * 64);
}

/// A stick of 12 g turns 35 times as easily about its length as across. Falling 5 cm onto cloth that sinks by 25 cm, it may come to 2 m/s, and roll
/// at 400 rad/s; seen by the cloth as it is, it is spun up beyond that.
#[test]
fn a_light_stick_is_not_spun_up() {
    let mut fastest = 0.0_f32;
    for draw in 0..6 {
        let part = draw as f32;
        let mut app = physics_app();
        hammock(&mut app, 7 + 3 * (draw % 3));
        let stick = (RigidBody::Dynamic, Collider::cuboid(0.077, 0.0092, 0.0092), Mass(0.012));
        let turn = Quat::from_scaled_axis(Vec3::new(1.0 + part, 0.3, 2.0 - part));
        let at = Vec3::new(0.12 - 0.05 * part, 0.05, 0.2 - 0.07 * part);
        let place = Transform::from_translation(at).with_rotation(turn);
        let stick = spawn(&mut app, (stick, ClothCollider::default(), place));
        for _ in 0..320 {
            app.update();
            let spin = app.world().get::<AngularVelocity>(stick).unwrap().0;
            fastest = fastest.max(spin.length());
        }
        println!("draw {draw}: {fastest} rad/s");
    }
    assert!(fastest < 400.0, "{fastest} rad/s");
}
