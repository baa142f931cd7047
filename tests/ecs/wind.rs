//! Air and wind in an app: which cloths feel what, and where. Truths: bit equality (seeds, frame rates, forms,
//! what is out of reach), and the speed of a light cloth, which is soon the wind's.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothExecution, ClothGravityOverride, ClothWindOverride,
    prelude::*,
    solver::{Gusts, WindFlow},
};
use std::{f32::consts::FRAC_PI_2, time::Duration};

/// A film so light that it goes with the wind, and nothing else acts.
fn film() -> impl Bundle {
    let material = ClothMaterial { area_density: 1e-3, ..default() };
    (sheet(), material, ClothGravityOverride(Vec3::ZERO), ClothAir::default())
}

#[track_caller]
fn check_goes_with(app: &App, entity: Entity, wind: Vec3) {
    let velocity = mean_velocity(app, entity);
    let apart = velocity.distance(wind);
    assert!(apart <= 0.1 * (1.0 + wind.length()), "{velocity} in a wind of {wind}");
}

/// It does not move, but for the rounding of its rest shape.
#[track_caller]
fn check_is_still(app: &App, entity: Entity) {
    let cloth = simulation(app, entity);
    let fastest = (0..cloth.particle_count()).filter_map(|i| cloth.velocity(i)).map(Vec3::length);
    let fastest = fastest.fold(0.0, f32::max);
    assert!(fastest < 1e-6, "{fastest} m/s");
}

fn set_wind(app: &mut App, wind: ClothWind) {
    app.insert_resource(wind);
}

#[test]
fn only_a_cloth_with_air_feels_the_wind() {
    let mut app = app();
    let wind = Vec3::new(0.5, 3.0, 0.0);
    set_wind(&mut app, ClothWind::steady(wind));
    let feels = spawn(&mut app, film());
    let material = ClothMaterial { area_density: 1e-3, ..default() };
    let does_not = spawn(&mut app, (sheet(), material, ClothGravityOverride(Vec3::ZERO)));
    updates(&mut app, 20);
    check_goes_with(&app, feels, wind);
    check_is_still(&app, does_not);
    // Air comes and goes with its component.
    app.world_mut().entity_mut(does_not).insert(ClothAir::default());
    app.world_mut().entity_mut(feels).remove::<ClothAir>();
    updates(&mut app, 20);
    check_goes_with(&app, does_not, wind);
    set_wind(&mut app, ClothWind::default());
    updates(&mut app, 20);
    check_goes_with(&app, does_not, Vec3::ZERO);
    let last = mean_velocity(&app, feels).y;
    assert!(last > 0.1, "nothing but its own drag slows it: {last}");
}

#[test]
fn a_cloth_can_have_a_wind_of_its_own() {
    let mut app = app();
    set_wind(&mut app, ClothWind::steady(Vec3::Y * 2.0));
    let own = ClothWindOverride(ClothWind::steady(Vec3::NEG_Y * 4.0));
    let with = spawn(&mut app, (film(), own));
    let without = spawn(&mut app, film());
    updates(&mut app, 30);
    check_goes_with(&app, with, Vec3::NEG_Y * 4.0);
    check_goes_with(&app, without, Vec3::Y * 2.0);
    app.world_mut().entity_mut(with).remove::<ClothWindOverride>();
    updates(&mut app, 30);
    check_goes_with(&app, with, Vec3::Y * 2.0);
}

#[test]
fn a_default_cloth_falls_at_its_terminal_speed() {
    let mut app = app();
    let material = ClothMaterial { drag: 50.0, ..default() };
    let cloth = spawn(&mut app, (sheet(), material, ClothAir::default()));
    updates(&mut app, 150);
    let exact = (2.0_f32 * 0.2 * 9.81 / (1.225 * 1.2)).sqrt();
    let speed = -mean_velocity(&app, cloth).y;
    assert!((speed - exact).abs() < 0.01 * exact, "{speed}, not {exact}: the other drag is off");
}

fn gusts(seed: u64) -> Gusts {
    Gusts { strength: 4.0, scale: 0.5, period: 0.2, seed }
}

/// A flag in gusts: its bits after some ticks, in frames of this length.
fn flag(seed: u64, frame: Duration, frames: usize) -> Vec<[u32; 3]> {
    let mut app = app();
    set_frame(&mut app, frame);
    set_wind(&mut app, ClothWind::steady(Vec3::new(4.0, 0.0, 1.0)).with_gusts(gusts(seed)));
    let pins = ClothPins::from(PinSelection::FirstColumn);
    let flag = spawn(&mut app, (sheet(), pins, ClothAir::default()));
    updates(&mut app, frames);
    assert_eq!(simulation(&app, flag).tick_count(), 48);
    bits(&app, flag)
}

#[test]
fn the_same_seed_is_the_same_weather_at_any_frame_rate() {
    let first = flag(1, TICK, 48);
    assert_eq!(first, flag(1, TICK, 48));
    assert_eq!(first, flag(1, TICK / 4, 4 * 48));
    assert_eq!(first, flag(1, TICK * 4, 12));
    assert!(first != flag(2, TICK, 48), "another seed");
}

/// Where a film goes in a zone.
fn goes(zone: WindZone, place: Transform, film_at: Vec3) -> Vec3 {
    let mut app = app();
    spawn(&mut app, (zone, place));
    let cloth = spawn(&mut app, (film(), Transform::from_translation(film_at)));
    updates(&mut app, 12);
    assert_eq!(failure(&app, cloth), None);
    mean_velocity(&app, cloth)
}

#[test]
fn zones_of_each_shape_blow_inside_and_nowhere_else() {
    let up = Vec3::Y * 2.0;
    let cone = Cone { radius: 3.0, height: 4.0 };
    for zone in [
        WindZone::directional(Cuboid::new(4.0, 4.0, 4.0), up),
        WindZone::directional(Sphere::new(3.0), up),
        WindZone::directional(cone, up),
    ] {
        let place = Transform::from_xyz(5.0, 1.0, -2.0);
        let inside = goes(zone, place, place.translation - Vec3::Y);
        assert!(inside.distance(up) < 0.2, "{zone:?}: {inside}");
        for away in [Vec3::X, Vec3::NEG_Z, Vec3::Y, Vec3::NEG_Y] {
            let outside = goes(zone, place, place.translation + away * 4.5);
            // Threads round a little, away from the origin.
            assert!(outside.length() < 1e-3, "{zone:?}: {outside}");
        }
        // Scaled, it reaches further.
        let reach =
            goes(zone, place.with_scale(Vec3::splat(4.0)), place.translation - Vec3::Y * 4.5);
        assert!(reach.distance(up) < 0.2, "{zone:?}: {reach}");
        // Turned, so is the wind.
        let turned = place.with_rotation(Quat::from_rotation_z(std::f32::consts::PI));
        let down = goes(zone, turned, place.translation + Vec3::Y);
        assert!(down.distance(-up) < 0.2, "{zone:?}: {down}");
    }
}

#[test]
fn radial_zones_blow_away_from_their_middle_or_tip() {
    let ball = WindZone::radial(Sphere::new(4.0), 3.0);
    assert!(goes(ball, Transform::default(), Vec3::Y * 2.0).y > 1.5);
    assert!(goes(ball, Transform::default(), Vec3::NEG_Y * 2.0).y < -1.5);
    let sucks = WindZone { flow: WindFlow::Radial(-3.0), ..ball };
    assert!(goes(sucks, Transform::default(), Vec3::Y * 2.0).y < -1.5);
    // The tip of a cone is on top: within, all blows down, above the middle too.
    let cone = WindZone::radial(Cone { radius: 4.0, height: 4.0 }, 3.0);
    assert!(goes(cone, Transform::default(), Vec3::Y * 0.5).y < -1.5);
}

#[test]
fn a_zone_fades_towards_its_border() {
    let zone =
        |falloff| WindZone::directional(Cuboid::new(8.0, 2.0, 8.0), Vec3::Y).with_falloff(falloff);
    let after_a_tick = |falloff, y| {
        let mut app = app();
        spawn(&mut app, zone(falloff));
        let cloth = spawn(&mut app, (film(), Transform::from_xyz(0.0, y, 0.0)));
        updates(&mut app, 1);
        mean_velocity(&app, cloth).y
    };
    let speeds = [0.0, 0.25, 0.5, 0.75, 0.95].map(|y| after_a_tick(1.0, y));
    assert!(speeds.windows(2).all(|pair| pair[0] > pair[1] && pair[1] > 0.0), "{speeds:?}");
    assert!(speeds[4] < 0.05 * speeds[0]);
    assert_eq!(after_a_tick(0.0, 0.95), after_a_tick(0.0, 0.0), "a hard border");
    assert_eq!(after_a_tick(0.0, 1.05), 0.0);
}

#[test]
fn zones_add_up_follow_their_entity_and_end_with_it() {
    let mut app = app();
    let wind = Vec3::Y * 1.0;
    set_wind(&mut app, ClothWind::steady(wind));
    // The parent carries the zone, and is moved in the fixed loop: no propagation in between.
    let mast = spawn(&mut app, Transform::from_xyz(100.0, 0.0, 0.0));
    let zone = WindZone::directional(Sphere::new(30.0), Vec3::X * 2.0);
    let turned = Transform::from_rotation(Quat::from_rotation_z(FRAC_PI_2));
    let one = spawn(&mut app, (zone, turned, ChildOf(mast)));
    let two = spawn(&mut app, WindZone::directional(Sphere::new(50.0), Vec3::Y * 0.5));
    let cloth = spawn(&mut app, film());
    updates(&mut app, 20);
    check_goes_with(&app, cloth, wind + Vec3::Y * 0.5);
    app.add_systems(FixedUpdate, move |mut masts: Query<&mut Transform>| {
        if let Ok(mut mast) = masts.get_mut(mast) {
            mast.translation.x = 0.0;
        }
    });
    updates(&mut app, 30);
    check_goes_with(&app, cloth, wind + Vec3::Y * 2.5);
    app.world_mut().despawn(two);
    updates(&mut app, 30);
    check_goes_with(&app, cloth, wind + Vec3::Y * 2.0);
    app.world_mut().despawn(one);
    updates(&mut app, 30);
    check_goes_with(&app, cloth, wind);
}

#[test]
fn a_zone_out_of_reach_changes_no_bit_and_their_order_none() {
    let run = |zones: &[(f32, f32)], marked: bool| {
        let mut app = app();
        let pins = ClothPins::from(PinSelection::FirstColumn);
        for (i, &(x, speed)) in zones.iter().enumerate() {
            let zone = WindZone::radial(Sphere::new(0.9), speed);
            let entity = spawn(&mut app, (zone, Transform::from_xyz(x, 0.2, 0.1)));
            if marked && i == 0 {
                app.world_mut().entity_mut(entity).insert(Name::new("another archetype"));
            }
        }
        let cloth = spawn(&mut app, (sheet(), pins, ClothAir::default()));
        updates(&mut app, 30);
        bits(&app, cloth)
    };
    let alone = run(&[(0.1, 3.0)], false);
    assert_eq!(alone, run(&[(0.1, 3.0), (20.0, 5.0)], false));
    assert!(alone != run(&[(0.1, 3.0), (0.4, 5.0)], false));
    let three = [(0.1, 3.0), (0.4, 5.1), (-0.3, 7.7)];
    assert_eq!(run(&three, false), run(&three, true));
}

#[test]
fn fused_and_staged_are_the_same() {
    let run = |execution: ClothExecution| {
        let mut app = app();
        app.insert_resource(execution);
        set_wind(&mut app, ClothWind::steady(Vec3::new(3.0, 0.5, 1.0)).with_gusts(gusts(3)));
        spawn(&mut app, WindZone::radial(Sphere::new(0.8), 6.0));
        let pins = ClothPins::from(PinSelection::FirstColumn);
        let cloths = [0.0, 0.3, 9.0].map(|x| {
            let place = Transform::from_xyz(x, 0.1, 0.0);
            spawn(&mut app, (sheet(), pins.clone(), ClothAir::default(), place))
        });
        updates(&mut app, 30);
        cloths.map(|cloth| bits(&app, cloth))
    };
    assert_eq!(run(ClothExecution::Fused), run(ClothExecution::Staged));
}
