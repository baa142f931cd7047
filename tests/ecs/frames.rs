//! Things that a game moves in `Update`, once a frame, at frame rates that are no multiple of the ticks'.
//!
//! Truths: what hangs on, or lies on, what goes evenly is at rest beside it; what is carried along by a teleport keeps its shape, whatever
//! is around it and comes along; a pin's place in its anchor's frame is the one at which it was spawned.

use crate::{
    skin::{dressed, skinned, usual},
    support::app::*,
};
use bevy::{
    app::{RunFixedMainLoop, RunFixedMainLoopSystems},
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_drape::{ClothSleepThreshold, prelude::*};
use core::{
    f32::consts::{FRAC_PI_2, PI},
    time::Duration,
};

const RATES: [u32; 5] = [30, 60, 75, 144, 240];

/// Moved evenly, by this much in a second.
#[derive(Component)]
struct Goes(Vec3);

fn go(mut going: Query<(&mut Transform, &Goes)>, time: Res<Time>) {
    for (mut transform, goes) in &mut going {
        transform.translation += goes.0 * time.delta_secs();
    }
}

fn app_of_frames(rate: u32) -> App {
    let mut app = app();
    app.add_systems(Update, go);
    set_frame(&mut app, Duration::from_secs_f64(1.0 / f64::from(rate)));
    app
}

fn seconds(app: &mut App, rate: u32, seconds: u32) {
    updates(app, (rate * seconds) as usize);
}

/// Hangs a curtain from a hand. Tells the speed of its fastest particle beside a velocity, from 6 s on \[m/s\].
fn speed_of_curtain(app: &mut App, rate: u32, hand: Entity, velocity: Vec3) -> f32 {
    let upright = Quat::from_rotation_x(FRAC_PI_2);
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hand);
    let material = ClothMaterial { drag: 4.0, ..default() };
    let place = Transform::from_xyz(0.0, 1.5, 0.0).with_rotation(upright);
    let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(16));
    let cloth = spawn(app, (cloth, pins, material, place));
    seconds(app, rate, 6);
    let mut fastest = 0.0_f32;
    for _ in 0..rate {
        app.update();
        let cloth = simulation(app, cloth);
        let speeds = (0..cloth.particle_count()).filter_map(|particle| cloth.velocity(particle));
        fastest = speeds.map(|its| its.distance(velocity)).fold(fastest, f32::max);
    }
    fastest
}

#[test]
fn a_curtain_hangs_still_from_what_goes_evenly_at_any_frame_rate() {
    for rate in RATES {
        let mut app = app_of_frames(rate);
        let goes = Vec3::new(2.0, 0.0, 0.5);
        let hand = spawn(&mut app, (Transform::from_xyz(0.0, 2.0, 0.0), Goes(goes)));
        let fastest = speed_of_curtain(&mut app, rate, hand, goes);
        println!("{rate} frames a second: {fastest} m/s");
        assert!(fastest < 0.02, "{rate} frames a second: {fastest} m/s beside the hand");
    }
}

#[test]
fn a_cloth_lies_still_on_what_goes_evenly_at_any_frame_rate() {
    for rate in RATES {
        let mut app = app_of_frames(rate);
        let plank = Transform::from_xyz(0.0, -0.1, 0.0);
        let solid = SdfCollider::from(Cuboid::new(4.0, 0.2, 4.0));
        let plank = spawn(&mut app, (plank, solid, Goes(2.0 * Vec3::X)));
        let cloth = spawn(&mut app, (sheet(), Transform::from_xyz(-1.0, 0.02, 0.0)));
        let on_plank = |app: &App| {
            let place = app.world().get::<Transform>(plank).unwrap().translation;
            simulation(app, cloth).positions().sum::<Vec3>() / 64.0 - place
        };
        seconds(&mut app, rate, 2);
        let before = on_plank(&app);
        seconds(&mut app, rate, 4);
        let slid = on_plank(&app).distance(before);
        println!("{rate} frames a second: {slid} m");
        assert!(slid < 0.01, "{rate} frames a second: it has slid by {slid} m in 4 s");
    }
}

/// How a character is moved.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Walk {
    /// In its ticks.
    Ticks,
    /// In its ticks, and shown between the last two of them, as engines do.
    Shown,
}

/// Where a character is by its last two ticks.
#[derive(Component, Default)]
struct Body([Vec3; 2]);

fn walk(mut bodies: Query<(&mut Body, &mut Transform)>, time: Res<Time>) {
    for (mut body, mut transform) in &mut bodies {
        let next = body.0[1] + 3.0 * Vec3::X * time.delta_secs();
        body.0 = [body.0[1], next];
        transform.translation = next;
    }
}

fn show(mut bodies: Query<(&Body, &mut Transform)>, time: Res<Time<Fixed>>) {
    for (body, mut transform) in &mut bodies {
        transform.translation = body.0[0].lerp(body.0[1], time.overstep_fraction());
    }
}

#[test]
fn a_curtain_hangs_still_from_what_frames_move_on_what_ticks_move() {
    for how in [Walk::Ticks, Walk::Shown] {
        for rate in RATES {
            let mut app = app_of_frames(rate);
            app.add_systems(FixedUpdate, walk);
            if how == Walk::Shown {
                let after = RunFixedMainLoopSystems::AfterFixedMainLoop;
                app.add_systems(RunFixedMainLoop, show.in_set(after));
            }
            let character = spawn(&mut app, (Transform::default(), Body::default()));
            let goes = Vec3::new(0.0, 0.2, 1.0);
            let hand = (Transform::from_xyz(0.0, 2.0, 0.0), Goes(goes), ChildOf(character));
            let hand = spawn(&mut app, hand);
            let fastest = speed_of_curtain(&mut app, rate, hand, goes + 3.0 * Vec3::X);
            println!("{how:?}, {rate} frames a second: {fastest} m/s");
            assert!(fastest < 0.03, "{how:?}, {rate} frames a second: {fastest} m/s");
        }
    }
}

/// A cape on the back of a hero with a body and arms.
fn hero(app: &mut App) -> (Entity, Entity) {
    let hero = spawn(app, Transform::default());
    for (x, from, to, radius) in
        [(0.0, 0.1, 1.35, 0.16), (-0.32, 0.7, 1.3, 0.06), (0.32, 0.7, 1.3, 0.06)]
    {
        let ends = [from, to].map(|y| Vec3::new(x, y, 0.0));
        spawn(app, (ChildOf(hero), SdfCollider::capsule_between(ends[0], ends[1], radius)));
    }
    let back = Transform::from_xyz(0.0, 0.95, 0.19).with_rotation(Quat::from_rotation_x(FRAC_PI_2));
    let cloth = Cloth::sheet(Vec2::new(0.6, 1.0), UVec2::new(10, 16));
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hero);
    let cape = spawn(app, (cloth, pins, ClothSleepThreshold::NEVER, back));
    (hero, cape)
}

/// How far the cape is at most, within a second, from where a jump carries it \[m\]. The jump is in a frame with so many ticks.
fn off_after(rate: u32, ticks: u64, to: Transform, is_asked: bool) -> f32 {
    let mut app = app_of_frames(rate);
    let (hero, cape) = hero(&mut app);
    seconds(&mut app, rate, 4);
    let frame = Duration::from_secs_f64(1.0 / f64::from(rate));
    let ticks_to_come = |app: &App| {
        let left = app.world().resource::<Time<Fixed>>().overstep();
        (left + frame).as_nanos() / TICK.as_nanos()
    };
    while ticks_to_come(&app) != u128::from(ticks) {
        app.update();
    }
    let (before, since) = (positions(&app, cape), simulation(&app, cape).tick_count());
    *transform(&mut app, hero) = to;
    if is_asked {
        app.world_mut().trigger(TeleportCloth { entity: cape });
    }
    app.update();
    assert_eq!(simulation(&app, cape).tick_count() - since, ticks);
    let mut most = 0.0_f32;
    for _ in 0..rate {
        let carried = before.iter().map(|place| to.transform_point(*place));
        let all = positions(&app, cape).into_iter().zip(carried);
        most = all.map(|(is, was)| is.distance(was)).fold(most, f32::max);
        app.update();
    }
    most
}

#[test]
fn what_comes_along_with_a_teleport_sweeps_through_no_cloth() {
    let back = |way: f32| Transform::from_xyz(0.0, 0.0, -way);
    let turned = Transform::from_rotation(Quat::from_rotation_y(PI));
    let cases = [
        ("half a metre, asked for", back(0.5), true),
        ("1.5 m, asked for", back(1.5), true),
        ("9 m, asked for", back(9.0), true),
        ("9 m", back(9.0), false),
        ("15 m", back(15.0), false),
        ("a half turn", turned, false),
    ];
    for (name, to, is_asked) in cases {
        for (rate, ticks) in [(60, 1), (60, 2), (30, 2), (30, 3)] {
            let off = off_after(rate, ticks, to, is_asked);
            assert!(off < 2e-3, "{name}, {ticks} ticks in a frame of 1/{rate} s: {off} m off");
        }
    }
}

/// Where the first corner of a cape is drawn beside its hero, who has gone on meanwhile \[m\].
fn corner_beside(app: &App, cape: Entity, hero: Entity) -> Vec3 {
    drawn_positions(app, cape)[0] - app.world().get::<Transform>(hero).unwrap().translation
}

#[test]
fn a_cape_that_is_put_on_in_a_run_is_where_it_was_put_on() {
    for rate in RATES {
        for frames_before in 0..4 {
            let mut app = app_of_frames(rate);
            let hero = spawn(&mut app, (Transform::default(), Goes(6.0 * Vec3::X)));
            let put_on = move |heroes: Query<&Transform, With<Goes>>, mut commands: Commands| {
                let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hero);
                commands.spawn((sheet(), pins, *heroes.get(hero).unwrap()));
            };
            let is_time = move |mut frames: Local<u32>| {
                *frames += 1;
                *frames == 10 + frames_before
            };
            app.add_systems(Update, put_on.after(go).run_if(is_time));
            updates(&mut app, (10 + frames_before) as usize);
            let mut capes = app.world_mut().query_filtered::<Entity, With<Cloth>>();
            let cape = capes.single(app.world()).unwrap();
            for _ in 0..rate {
                let corner = corner_beside(&app, cape, hero);
                let off = corner.distance(Vec3::new(-0.5, 0.0, -0.5));
                assert!(off < 1e-3, "{rate} frames a second: the collar is off by {off} m");
                app.update();
            }
        }
    }
}

#[test]
fn a_cape_that_is_put_on_in_a_pause_goes_along_in_the_pause() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    let hero = spawn(&mut app, Transform::default());
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hero);
    let cape = spawn(&mut app, (sheet(), pins));
    updates(&mut app, 2);
    let corner = corner_beside(&app, cape, hero);
    for way in [1.0, 3.0, 30.0] {
        transform(&mut app, hero).translation.x = way;
        updates(&mut app, 3);
    }
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    updates(&mut app, 20);
    let off = corner_beside(&app, cape, hero).distance(corner);
    assert!(off < 1e-4, "the collar is off by {off} m");
}

#[test]
fn a_coat_that_is_put_on_in_a_pause_goes_along_in_the_pause() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    let of = dressed(&mut app, usual());
    updates(&mut app, 2);
    for way in [0.5, 1.0, 4.0] {
        transform(&mut app, of.root).translation.x = way;
        updates(&mut app, 3);
    }
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.update();
    assert_eq!(simulation(&app, of.coat).tick_count(), 1);
    let places: Vec<_> = skinned(&mut app, &of).into_iter().map(|(place, _)| place).collect();
    let off = farthest(&positions(&app, of.coat), &places);
    assert!(off < 5e-3, "after a tick it is {off} m from its skin");
}

#[test]
fn what_is_scaled_once_a_frame_is_pinned_where_it_is_by_then() {
    for rate in RATES {
        let mut app = app_of_frames(rate);
        let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::FirstRow)));
        let grow = move |mut places: Query<&mut Transform>, mut frames: Local<u32>| {
            *frames += 1;
            if *frames == rate {
                places.get_mut(cloth).unwrap().scale = Vec3::splat(2.0);
            }
        };
        app.add_systems(Update, grow);
        seconds(&mut app, rate, 1);
        for frame in 0..rate {
            let corner = position(&app, cloth, 0);
            let off = corner.distance(Vec3::new(-1.0, 0.0, -1.0));
            assert!(off < 1e-5, "{rate} frames a second, frame {frame}: at {corner}");
            app.update();
        }
    }
}

#[test]
fn a_reset_is_where_the_entity_is() {
    for rate in RATES {
        let mut app = app_of_frames(rate);
        let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::FirstRow)));
        let pinned_at = |app: &App| position(app, cloth, 0) - Vec3::new(-0.5, 0.0, -0.5);
        for frames in 1..8 {
            seconds(&mut app, rate, 1);
            updates(&mut app, frames);
            let place = Vec3::X * (frames % 2) as f32;
            transform(&mut app, cloth).translation = place;
            app.world_mut().trigger(ResetCloth { entity: cloth });
            let since = simulation(&app, cloth).tick_count();
            while simulation(&app, cloth).tick_count() == since {
                app.update();
            }
            let off = pinned_at(&app).distance(place);
            assert!(off < 1e-5, "{rate} frames a second: the pins are {off} m off");
        }
    }
}
