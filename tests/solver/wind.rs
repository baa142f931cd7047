//! The wind at a place: gusts are bounded, smooth and even-handed, today and after days of play, here
//! and far away; zones blow what they say where they say it.

use bevy::math::{
    Quat, Vec3,
    primitives::{Cone, Cuboid, Sphere},
};
use bevy_drape::solver::{Gusts, Pose, Wind, WindFlow, WindShape, Zone};

use crate::support::solver::*;

const GUSTS: Gusts = Gusts { strength: 3.0, scale: 2.0, period: 0.5, seed: 11 };

fn gust(gusts: Gusts, time: f64, place: Vec3) -> Vec3 {
    Wind { gusts, time, ..Wind::default() }.at(place)
}

#[test]
fn gusts_are_bounded_and_even_handed() {
    let mut dice = Dice(1);
    let (mut sum, mut squares, mut most) = ([0.0_f64; 3], [0.0_f64; 3], 0.0_f32);
    let count = 20_000;
    for i in 0..count {
        let g = gust(GUSTS, f64::from(i) * 0.37, dice.vector() * 500.0).to_array();
        for axis in 0..3 {
            most = most.max(g[axis].abs());
            sum[axis] += f64::from(g[axis]);
            squares[axis] += f64::from(g[axis]).powi(2);
        }
    }
    check_at_most("strongest gust [m/s]", f64::from(most), 3.0 + 1e-5);
    // The variance of a blend of even numbers from -1 to 1: 1/3 of the mean of the squared weights,
    // which is 181/231 along each axis of space and time.
    let rms = 3.0 * ((181.0_f64 / 231.0).powi(4) / 3.0).sqrt();
    for axis in 0..3 {
        check("mean [m/s]", sum[axis] / f64::from(count), 0.0, 0.04);
        check("rms [m/s]", (squares[axis] / f64::from(count)).sqrt(), rms, 0.03);
    }
}

#[test]
fn gusts_are_smooth_in_time_and_space_for_days_and_far_away() {
    // The blend's steepest slope is 15/8 a cell, between numbers that are 2 apart.
    let steepest = 15.0 / 8.0 * 2.0 * 3.0;
    for start in [0.0, 3600.0 * 24.0 * 30.0 + 0.123] {
        for far in [0.0, 30_000.0, -1e6] {
            let place = Vec3::new(0.3, far, -2.0);
            let mut moved = 0.0_f64;
            for tick in 0..640 {
                let time = start + f64::from(tick) / 64.0;
                let (a, b) = (gust(GUSTS, time, place), gust(GUSTS, time + 1.0 / 64.0, place));
                let step = f64::from((b - a).abs().max_element());
                assert!(
                    step <= steepest / 64.0 / 0.5 * 1.01,
                    "{start} s, {far} m: {step} in a tick"
                );
                moved += step;
                let beside = gust(GUSTS, time, place + Vec3::X * 0.0625);
                let step = f64::from((beside - a).abs().max_element());
                assert!(
                    step <= steepest * 0.0625 / 2.0 * 1.01,
                    "{start} s, {far} m: {step} beside"
                );
            }
            assert!(moved > 10.0, "{start} s, {far} m: they stand still");
        }
    }
}

#[test]
fn a_seed_is_its_own_weather() {
    let at = |seed: u64| {
        (0..50)
            .map(|i| gust(Gusts { seed, ..GUSTS }, 0.1 * f64::from(i), Vec3::ONE))
            .collect::<Vec<_>>()
    };
    assert_eq!(at(5), at(5));
    for other in [0, 6, 5 << 32, u64::MAX] {
        let apart = farthest(&at(5), &at(other));
        assert!(apart > 1.0, "seed {other}: {apart}");
    }
    assert_eq!(gust(Gusts { strength: 0.0, ..GUSTS }, 1.0, Vec3::ONE), Vec3::ZERO);
}

#[test]
fn gusts_have_the_size_and_the_duration_asked_for() {
    // Far within a cell two places feel the same; some cells apart they have nothing in common.
    let likeness = |distance: f32, later: f64| {
        let (mut both, mut each) = (0.0, 0.0);
        let mut dice = Dice(2);
        for i in 0..4000 {
            let (time, place) = (f64::from(i) * 1.7, dice.vector() * 300.0);
            let a = gust(GUSTS, time, place);
            both += f64::from(a.dot(gust(GUSTS, time + later, place + Vec3::Z * distance)));
            each += f64::from(a.length_squared());
        }
        both / each
    };
    assert!(likeness(0.1, 0.0) > 0.95 && likeness(0.0, 0.025) > 0.95);
    assert!(likeness(4.0, 0.0).abs() < 0.05 && likeness(0.0, 1.0).abs() < 0.05);
}

fn zone(shape: impl Into<WindShape>, flow: WindFlow) -> Zone {
    Zone { shape: shape.into(), flow, falloff: 0.5, pose: Pose::IDENTITY }
}

fn in_zone(zone: Zone, place: Vec3) -> Vec3 {
    Wind { zones: &[zone], ..Wind::default() }.at(place)
}

#[test]
fn a_zone_has_its_full_wind_below_the_falloff_and_none_outside() {
    let flow = WindFlow::Directional(Vec3::new(1.0, 2.0, 3.0));
    let turn = Quat::from_euler(bevy::math::EulerRot::YXZ, 0.7, -0.4, 2.0);
    let pose = Pose { translation: Vec3::new(7.0, -3.0, 2.0), rotation: turn, scale: 2.0 };
    let velocity = turn * Vec3::new(1.0, 2.0, 3.0);
    // Places of each shape's own frame: full, half way into the falloff, outside.
    for (shape, full, half, outside) in [
        (
            WindShape::from(Cuboid::new(4.0, 6.0, 8.0)),
            Vec3::new(1.4, 2.4, 3.4),
            Vec3::new(-1.75, 0.0, 1.0),
            Vec3::new(2.01, 0.0, 0.0),
        ),
        (
            WindShape::from(Sphere::new(2.0)),
            Vec3::new(0.0, -1.4, 0.0),
            Vec3::new(0.0, 0.0, 1.75),
            Vec3::new(1.5, 1.5, 0.0),
        ),
        // A cone of 4 by 3: its side leans by 3 in 5.
        (
            WindShape::from(Cone { radius: 3.0, height: 4.0 }),
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(0.5, -1.75, 0.0),
            Vec3::new(1.51, 0.01, 0.0),
        ),
    ] {
        let zone = Zone { shape, flow, falloff: 0.5, pose };
        assert!(zone.is_valid());
        let world = |own: Vec3| pose.translation + turn * (own * 2.0);
        let at = |own: Vec3| in_zone(zone, world(own));
        let error = |own: Vec3, expected: Vec3| f64::from(at(own).distance(expected));
        check_at_most(&format!("{shape:?}, inside [m/s]"), error(full, velocity), 1e-5);
        check_at_most(&format!("{shape:?}, half way [m/s]"), error(half, velocity * 0.5), 1e-5);
        check_at_most(&format!("{shape:?}, outside [m/s]"), error(outside, Vec3::ZERO), 0.0);
    }
}

#[test]
fn a_radial_zone_blows_away_from_its_source() {
    let mut dice = Dice(4);
    let ball = zone(Sphere::new(3.0), WindFlow::Radial(5.0));
    let cone = zone(Cone { radius: 3.0, height: 4.0 }, WindFlow::Radial(-5.0));
    for _ in 0..100 {
        let place = dice.vector();
        let away = in_zone(ball, place);
        assert!(away.distance(place.normalize() * 5.0) < 1e-4, "{place}: {away}");
        let deep = place * 0.4 - Vec3::Y * 0.8;
        let towards = in_zone(cone, deep);
        let tip = Vec3::Y * 2.0;
        assert!(towards.distance((tip - deep).normalize() * 5.0) < 1e-4, "{deep}: {towards}");
    }
    assert_eq!(in_zone(ball, Vec3::ZERO), Vec3::ZERO, "no direction, but a number");
}

#[test]
fn everything_adds_up() {
    let zones = [
        zone(Sphere::new(3.0), WindFlow::Directional(Vec3::X)),
        zone(Cuboid::new(4.0, 4.0, 4.0), WindFlow::Directional(Vec3::Z * 2.0)),
    ];
    let wind = Wind { velocity: Vec3::Y, gusts: GUSTS, time: 3.3, zones: &zones };
    let sum = Vec3::Y + gust(GUSTS, 3.3, Vec3::ZERO) + Vec3::X + Vec3::Z * 2.0;
    check_at_most("apart [m/s]", f64::from(wind.at(Vec3::ZERO).distance(sum)), 1e-6);
}
