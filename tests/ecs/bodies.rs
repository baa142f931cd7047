//! Bodies of a game that cloths move: `ColliderMass`, `BodyImpulse`, `ColliderBody`.

use std::time::Duration;

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    BodyImpulse, ClothComponent, ClothErrorKind, ClothPaused, ClothSystems, ColliderBody,
    ColliderMass, prelude::*,
};

const GRAVITY: f32 = 9.81;
const RADIUS: f32 = 0.15;

/// What a game's own engine knows of a body.
#[derive(Component, Default)]
struct Moves {
    velocity: Vec3,
    spin: Vec3,
    /// How long it has been still \[s\].
    still: f32,
    falls_asleep: bool,
}

fn fall(mut bodies: Query<(&mut Transform, &mut Moves, &mut ColliderMass)>, time: Res<Time>) {
    let dt = time.delta_secs();
    for (mut place, mut body, mut mass) in &mut bodies {
        if mass.sleeps {
            continue;
        }
        body.velocity.y -= GRAVITY * dt;
        place.translation += body.velocity * dt;
        place.rotation = (Quat::from_scaled_axis(body.spin * dt) * place.rotation).normalize();
        body.still = if body.velocity.length() < 0.01 { body.still + dt } else { 0.0 };
        if body.falls_asleep && body.still > 0.5 {
            (body.velocity, body.spin, mass.sleeps) = (Vec3::ZERO, Vec3::ZERO, true);
        }
    }
}

fn be_pushed(mut bodies: Query<(&mut Moves, &BodyImpulse, &mut ColliderMass)>) {
    for (mut body, impulse, mut mass) in &mut bodies {
        if mass.sleeps {
            if impulse.wakes {
                (mass.sleeps, body.still) = (false, 0.0);
            }
            continue;
        }
        body.velocity += impulse.linear / mass.mass;
        body.spin += impulse.angular / mass.principal_inertia;
    }
}

fn engine() -> App {
    let mut app = app();
    app.add_systems(FixedUpdate, fall)
        .add_systems(FixedPostUpdate, be_pushed.after(ClothSystems::Finish));
    app
}

fn ball(mass: f32, at: Vec3) -> impl Bundle {
    let collider = (SdfCollider::from(Sphere::new(RADIUS)), ColliderMass::sphere(mass, RADIUS));
    (collider, Moves::default(), Transform::from_translation(at))
}

/// A metre of cloth held at its corners.
fn hammock(size: Vec2, count: UVec2) -> impl Bundle {
    let last = count.x * count.y - 1;
    let corners = [0, count.x - 1, last + 1 - count.x, last];
    (Cloth::sheet(size, count), ClothPins::vertices(corners))
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Transform>(entity).unwrap().translation
}

/// How far a body goes up and down in a second \[m\].
fn swing(app: &mut App, body: Entity) -> f32 {
    let mut heights = Vec::new();
    for _ in 0..64 {
        app.update();
        heights.push(place(app, body).y);
    }
    heights.iter().fold(f32::MIN, |a, &b| a.max(b))
        - heights.iter().fold(f32::MAX, |a, &b| a.min(b))
}

#[test]
fn a_hammock_carries_a_ball_of_the_game() {
    let mut app = engine();
    spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(24)));
    let body = spawn(&mut app, ball(2.0, Vec3::Y * 0.4));
    updates(&mut app, 9 * 64);
    assert!(swing(&mut app, body) < 0.01);
    let at = place(&app, body);
    assert!((-0.3..0.0).contains(&at.y) && at.xz().length() < 0.02, "{at}");
    assert_eq!(failure(&app, body), None);
}

#[test]
fn two_strips_carry_it_together() {
    let mut app = engine();
    for side in [-0.2, 0.2] {
        let strip = spawn(&mut app, hammock(Vec2::new(0.2, 1.0), UVec2::new(8, 40)));
        insert(&mut app, strip, Transform::from_xyz(side, 0.0, 0.0));
    }
    let size = Vec3::new(0.6, 0.1, 0.2);
    let plank = (SdfCollider::from(Cuboid::from_size(size)), ColliderMass::cuboid(0.4, size));
    let plank = spawn(&mut app, (plank, Moves::default(), Transform::from_xyz(0.0, 0.2, 0.0)));
    updates(&mut app, 9 * 64);
    assert!(swing(&mut app, plank) < 0.01);
    let at = place(&app, plank);
    assert!((-0.3..0.06).contains(&at.y) && at.xz().length() < 0.05, "{at}");
}

#[test]
fn both_fall_asleep_and_wake_together() {
    let mut app = engine();
    let cloth = spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(24)));
    let body = spawn(&mut app, ball(1.0, Vec3::Y * 0.2));
    app.world_mut().get_mut::<Moves>(body).unwrap().falls_asleep = true;
    let sleeps = |app: &App| app.world().get::<ColliderMass>(body).unwrap().sleeps;
    let mut ticks = 0;
    while !(sleeps(&app) && simulation(&app, cloth).is_asleep()) {
        app.update();
        ticks += 1;
        assert!(ticks < 40 * 64, "awake: {} {}", sleeps(&app), simulation(&app, cloth).is_asleep());
    }
    let at = place(&app, body);
    updates(&mut app, 128);
    assert!(sleeps(&app) && simulation(&app, cloth).is_asleep());
    assert_eq!(place(&app, body), at);
    // One corner is let go.
    insert(&mut app, cloth, ClothPins::vertices([0, 23, 24 * 24 - 1]));
    updates(&mut app, 64);
    assert!(!sleeps(&app), "the ball sleeps in the air");
    assert!(place(&app, body).y < at.y - 0.2, "{at} to {}", place(&app, body));
}

#[test]
fn a_cloth_that_sleeps_goes_on_carrying_what_does_not() {
    let mut app = engine();
    let cloth = spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(24)));
    let body = spawn(&mut app, ball(0.5, Vec3::Y * 0.17));
    insert(&mut app, cloth, bevy_drape::ClothSleepThreshold { distance: 0.05, time: 0.5 });
    updates(&mut app, 30 * 64);
    assert!(swing(&mut app, body) < 5e-3);
    let at = place(&app, body);
    updates(&mut app, 10 * 64);
    assert!(place(&app, body).distance(at) < 5e-3, "{at} to {}", place(&app, body));
}

#[test]
fn a_body_of_two_colliders_is_one() {
    let mut app = engine();
    spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(24)));
    let body = ColliderMass::cuboid(1.0, Vec3::new(0.4, 0.1, 0.1));
    let body = spawn(&mut app, (body, Moves::default(), Transform::from_xyz(0.0, 0.2, 0.0)));
    for side in [-0.1, 0.1] {
        let part = SdfCollider::from(Cuboid::new(0.2, 0.1, 0.1));
        let part = (part, ColliderBody(body), ChildOf(body), Transform::from_xyz(side, 0.0, 0.0));
        spawn(&mut app, part);
    }
    updates(&mut app, 9 * 64);
    assert!(swing(&mut app, body) < 0.015);
    let at = place(&app, body);
    assert!((-0.3..0.05).contains(&at.y), "{at}");
}

#[test]
fn masses_out_of_range_are_told_and_the_rest_goes_on() {
    let good = ColliderMass::sphere(1.0, RADIUS);
    for bad in [
        ColliderMass { mass: 0.0, ..good },
        ColliderMass { mass: f32::INFINITY, ..good },
        ColliderMass { mass: f32::NAN, ..good },
        ColliderMass { principal_inertia: Vec3::new(1.0, 0.0, 1.0), ..good },
        ColliderMass { principal_inertia: Vec3::NAN, ..good },
        ColliderMass { principal_axes: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..good },
        ColliderMass { center_of_mass: Vec3::NAN, ..good },
    ] {
        let mut app = app();
        let cloth = spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(8)));
        let body = (SdfCollider::from(Sphere::new(RADIUS)), bad);
        let body = spawn(&mut app, (body, Transform::from_xyz(0.0, -0.2, 0.0)));
        updates(&mut app, 64);
        let told = failure(&app, body).expect("it is told");
        let ClothErrorKind::Parameter { component: ClothComponent::ColliderMass, .. } = told.kind
        else {
            panic!("{told}")
        };
        // It stays a collider, and nothing moves it.
        assert_eq!(failure(&app, cloth), None);
        assert_eq!(*app.world().get::<BodyImpulse>(body).unwrap(), BodyImpulse::default());
        assert!(simulation(&app, cloth).last_tick().unwrap().contact_count > 0);
        insert(&mut app, body, good);
        updates(&mut app, 4);
        assert_eq!(failure(&app, body), None);
        assert!(app.world().get::<BodyImpulse>(body).unwrap().linear.y < 0.0);
    }
}

#[test]
fn the_frame_rate_makes_no_difference() {
    let run = |frame: TimeUpdateStrategy, frames: usize| {
        let mut app = engine();
        let cloth = spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(16)));
        let body = spawn(&mut app, ball(0.5, Vec3::Y * 0.2));
        app.insert_resource(frame);
        updates(&mut app, frames);
        assert_eq!(simulation(&app, cloth).tick_count(), 60);
        (bits(&app, cloth), place(&app, body).to_array().map(f32::to_bits))
    };
    let each = run(TimeUpdateStrategy::FixedTimesteps(1), 60);
    assert_eq!(run(TimeUpdateStrategy::FixedTimesteps(3), 20), each);
    let slow = TimeUpdateStrategy::ManualDuration(Duration::from_micros(15625 / 5));
    assert_eq!(run(slow, 300), each);
}

#[test]
fn a_body_that_loses_its_mass_is_a_wall_again() {
    let mut app = engine();
    let cloth = spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(16)));
    let body = spawn(&mut app, ball(0.5, Vec3::Y * 0.16));
    updates(&mut app, 6 * 64);
    app.world_mut().entity_mut(body).remove::<ColliderMass>();
    let at = place(&app, body);
    updates(&mut app, 64);
    assert_eq!(place(&app, body), at);
    assert_eq!(failure(&app, body), None);
    assert!(simulation(&app, cloth).last_tick().unwrap().contact_count > 0);
}

/// A crate that hangs in a sheet by all of its lower edge, or by its corners; the upper edge is held.
fn hung(app: &mut App, mass: f32, corners: bool, is_collider: bool) -> (Entity, Entity) {
    let size = Vec3::new(1.0, 0.1, 0.1);
    let crate_ = (ColliderMass::cuboid(mass, size), Moves::default());
    let crate_ = spawn(app, (crate_, Transform::from_xyz(0.0, -1.05, 0.0)));
    if is_collider {
        insert(app, crate_, SdfCollider::from(Cuboid::from_size(size)));
    }
    let lower = if corners { vec![600, 624] } else { (600..625).collect() };
    let pins = ClothPins::vertices(0..25).and(ClothPins::vertices(lower).anchored_to(crate_));
    let upright = Transform::from_xyz(0.0, -0.5, 0.0)
        .with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    let cloth = (Cloth::sheet(Vec2::ONE, UVec2::splat(25)), pins, upright);
    (spawn(app, cloth), crate_)
}

#[test]
fn pins_pull_at_what_they_are_on() {
    for (mass, corners, is_collider) in
        [(0.1, false, false), (1.0, false, true), (10.0, false, false), (1.0, true, false)]
    {
        let mut app = engine();
        let (cloth, body) = hung(&mut app, mass, corners, is_collider);
        updates(&mut app, 9 * 64);
        let what = format!("{mass} kg, corners: {corners}");
        assert!(swing(&mut app, body) < 5e-3, "{what}");
        let at = place(&app, body);
        assert!((-1.2..-1.02).contains(&at.y) && at.xz().length() < 0.02, "{what}: {at}");
        assert_eq!((failure(&app, cloth), failure(&app, body)), (None, None), "{what}");
        // What holds the cloth is on the crate still.
        let corner = position(&app, cloth, 600) - at;
        assert!((corner.length() - 0.5025).abs() < 5e-3, "{what}: {corner}");
    }
}

/// A crate on springs hangs lower by what they give.
#[test]
fn soft_pins_pull_at_what_they_are_on() {
    let lowest = |spring: Option<(f32, f32)>| {
        let mut app = engine();
        let (cloth, body) = hung(&mut app, 2.0, false, false);
        if let Some((stiffness, damping)) = spring {
            let lower = ClothPins::vertices(600..625).softly(stiffness, damping).anchored_to(body);
            insert(&mut app, cloth, ClothPins::vertices(0..25).and(lower));
        }
        updates(&mut app, 9 * 64);
        assert!(swing(&mut app, body) < 5e-3, "{spring:?}");
        assert_eq!((failure(&app, cloth), failure(&app, body)), (None, None), "{spring:?}");
        place(&app, body).y
    };
    let gives = lowest(None) - lowest(Some((500.0, 25.0)));
    let expected = 2.0 * GRAVITY / 500.0;
    assert!((gives - expected).abs() < 1e-3, "{gives} m, not {expected}");
}

#[test]
fn a_crate_that_is_let_go_falls() {
    let mut app = engine();
    let (cloth, body) = hung(&mut app, 1.0, false, false);
    updates(&mut app, 4 * 64);
    let at = place(&app, body);
    insert(&mut app, cloth, ClothPins::vertices(0..25));
    updates(&mut app, 32);
    assert!(place(&app, body).y < at.y - 0.8, "{at} to {}", place(&app, body));
}

#[test]
fn what_hangs_and_sleeps_wakes_as_it_is_pulled() {
    let mut app = engine();
    let (cloth, body) = hung(&mut app, 2.0, false, false);
    app.world_mut().get_mut::<Moves>(body).unwrap().falls_asleep = true;
    let sleeps = |app: &App| app.world().get::<ColliderMass>(body).unwrap().sleeps;
    let mut ticks = 0;
    while !(sleeps(&app) && simulation(&app, cloth).is_asleep()) {
        app.update();
        ticks += 1;
        assert!(ticks < 60 * 64, "awake: {} {}", sleeps(&app), simulation(&app, cloth).is_asleep());
    }
    // The cloth is let go above.
    let at = place(&app, body);
    let lower = ClothPins::vertices(600..625).anchored_to(body);
    insert(&mut app, cloth, lower);
    updates(&mut app, 64);
    assert!(!sleeps(&app) && place(&app, body).y < at.y - 0.2, "{at} {}", place(&app, body));
}

/// A cloth that stands still carries what lies in it, and not what has left it, be it while it stands or as it stops.
#[test]
fn a_paused_cloth_carries_a_body_as_long_as_it_is_there() {
    for paused_for in [0, 128] {
        let mut app = engine();
        let cloth = spawn(&mut app, hammock(Vec2::ONE, UVec2::splat(16)));
        let body = spawn(&mut app, ball(3.0, Vec3::Y * 0.2));
        updates(&mut app, 3 * 64);
        let height = |app: &App| app.world().get::<Transform>(body).unwrap().translation.y;
        insert(&mut app, cloth, ClothPaused::default());
        let before = height(&app);
        updates(&mut app, paused_for);
        assert!((height(&app) - before).abs() < 0.03, "{} {before}", height(&app));
        *transform(&mut app, body) = Transform::from_xyz(30.0, 5.0, 0.0);
        let start = app.world().get::<Moves>(body).unwrap().velocity.y;
        updates(&mut app, 64);
        let free = 5.0 + start - 0.5 * GRAVITY;
        assert!((height(&app) - free).abs() < 0.3, "{paused_for}: {} {free}", height(&app));
        // It knows it again when it goes on.
        *transform(&mut app, body) = Transform::from_xyz(0.0, before, 0.0);
        app.world_mut().get_mut::<Moves>(body).unwrap().velocity = Vec3::ZERO;
        app.world_mut().entity_mut(cloth).remove::<ClothPaused>();
        updates(&mut app, 6 * 64);
        assert!((height(&app) - before).abs() < 0.06, "{} {before}", height(&app));
    }
}

/// From a lift that goes up at 1 m/s, on four straps that are stopped together.
#[test]
fn a_body_goes_along_with_what_leads_cloths_that_stand_still() {
    let mut app = engine();
    let lift = spawn(&mut app, Transform::default());
    let mass = ColliderMass::new(2.0, Vec3::splat(0.1));
    let at = Transform::from_xyz(0.0, -1.0, 0.0);
    let body = spawn(&mut app, (mass, Moves::default(), at));
    let straps: Vec<_> = (0..4)
        .map(|strap| {
            let cloth = Cloth::sheet(Vec2::new(0.1, 1.0), UVec2::new(4, 16));
            let pins = ClothPins::vertices(0..4).anchored_to(lift);
            let pins = pins.and(ClothPins::vertices(60..64).anchored_to(body));
            let at = Transform::from_xyz(strap as f32 * 0.2 - 0.3, -0.5, 0.0)
                .with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
            spawn(&mut app, (cloth, pins, at))
        })
        .collect();
    updates(&mut app, 3 * 64);
    // They wind up, and turn it back.
    app.world_mut().get_mut::<Moves>(body).unwrap().spin = Vec3::Y * 3.0;
    updates(&mut app, 8);
    let spin = |app: &App| app.world().get::<Moves>(body).unwrap().spin.length();
    let turned = spin(&app);
    for strap in straps {
        insert(&mut app, strap, ClothPaused::default());
    }
    let height = |app: &App| app.world().get::<Transform>(body).unwrap().translation.y;
    let before = height(&app);
    updates(&mut app, 64);
    assert!((height(&app) - before).abs() < 0.02, "{} {before}", height(&app));
    app.world_mut().get_mut::<Moves>(body).unwrap().velocity = Vec3::Y;
    for tick in 1..=128 {
        transform(&mut app, lift).translation.y = tick as f32 / 64.0;
        app.update();
    }
    assert!((height(&app) - before - 2.0).abs() < 0.04, "{} {before}", height(&app));
    assert!((spin(&app) - turned).abs() < 1.0, "{} {turned}", spin(&app));
}

#[test]
fn a_cloth_that_is_pinned_to_a_part_of_a_body_pulls_the_body() {
    let hang = |below: bool| {
        let mut app = engine();
        let at = Transform::from_xyz(0.0, -1.0, 0.0);
        let mass = ColliderMass::new(2.0, Vec3::splat(0.1));
        let body = spawn(&mut app, (mass, Moves::default(), at));
        let hook = spawn(&mut app, (Transform::default(), ChildOf(body)));
        let lower = ClothPins::vertices(240..256).anchored_to(if below { hook } else { body });
        let pins = ClothPins::vertices(0..16).and(lower);
        let upright = Transform::from_xyz(0.0, -0.5, 0.0)
            .with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
        let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(16));
        spawn(&mut app, (cloth, pins, upright));
        updates(&mut app, 3 * 64);
        app.world().get::<Transform>(body).unwrap().translation
    };
    let [hook, body] = [hang(true), hang(false)];
    assert!((-1.2..-0.9).contains(&body.y), "{body}");
    assert_eq!(hook, body);
}
