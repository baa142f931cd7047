//! Cloths of 64 x 64 in an app that have been dropped on solids fall asleep, and so do those that hang and swing. Truth: within fifteen
//! seconds, by default and at the quality of games, and from then on they sleep.

use std::time::Duration;

use crate::support::app::{app_with, simulation, spawn};
use crate::support::solver::check_at_most;
use bevy::{
    math::primitives::{Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere},
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_drape::{ClothInterCollision, ClothSelfCollision, prelude::*};

const FRAME: Duration = Duration::from_nanos(16_666_667);
const FRAMES: u32 = 20 * 60;

/// Drops a cloth on a solid whose middle is so high, and tells since when it sleeps \[s\].
fn asleep_since(solid: impl Into<SdfShape>, middle: f32, settings: ClothSettings) -> f64 {
    let mut app = app_with(ClothPlugin::default());
    spawn(&mut app, SdfCollider::from(InfinitePlane3d::new(Vec3::Y)));
    spawn(&mut app, (SdfCollider::new(solid), Transform::from_xyz(0.0, middle, 0.0)));
    let sheet = Cloth::sheet(Vec2::splat(1.6), UVec2::splat(64));
    let cloth = spawn(&mut app, (sheet, settings, Transform::from_xyz(0.0, 1.3, 0.0)));
    sleeps_since(&mut app, cloth)
}

/// Runs an app for twenty seconds, and tells since when a cloth sleeps \[s\].
fn sleeps_since(app: &mut App, cloth: Entity) -> f64 {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    let mut since = None;
    for done in 0..FRAMES {
        app.update();
        let sleeps = simulation(app, cloth).is_asleep();
        since = sleeps.then(|| since.unwrap_or(done));
    }
    since.map_or(f64::INFINITY, |frames| f64::from(frames) * FRAME.as_secs_f64())
}

fn check(solid: impl Into<SdfShape>, middle: f32) {
    let solid = solid.into();
    for (name, settings) in [("default", ClothSettings::default()), ("game", ClothSettings::GAME)] {
        let since = asleep_since(solid.clone(), middle, settings);
        check_at_most(&format!("{name}: asleep after [s]"), since, 15.0);
    }
}

#[test]
fn on_a_ball_and_the_ground() {
    check(Sphere::new(0.05), 0.05);
}

#[test]
fn on_a_cube() {
    check(Cuboid::new(0.8, 0.8, 0.8), 0.4);
}

#[test]
fn on_a_cylinder() {
    check(Cylinder::new(0.5, 0.8), 0.4);
}

#[test]
fn on_a_cone() {
    check(Cone { radius: 0.5, height: 0.8 }, 0.4);
}

/// Let go flat, it swings through more than a right angle: by two corners, or by all of its first row.
#[test]
fn what_hangs_and_swings() {
    for pins in [ClothPins::vertices([0, 63]), ClothPins::from(PinSelection::FirstRow)] {
        let mut app = app_with(ClothPlugin::default());
        let sheet = Cloth::sheet(Vec2::ONE, UVec2::splat(64));
        let cloth = spawn(&mut app, (sheet, pins, Transform::default()));
        check_at_most("asleep after [s]", sleeps_since(&mut app, cloth), 15.0);
    }
}

/// Four towels on a bench that is smaller than they are, as in the example `pile`. Truth: none of them slides off, and they sleep.
#[test]
fn towels_on_a_bench() {
    let mut app = app_with(ClothPlugin::default());
    app.insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    spawn(&mut app, SdfCollider::from(InfinitePlane3d::new(Vec3::Y)));
    let seat = SdfCollider::from(Cuboid::new(0.6, 0.04, 0.34));
    spawn(&mut app, (seat, Transform::from_xyz(0.0, 0.3, 0.0)));
    let terry = ClothMaterial { area_density: 0.4, friction: 0.9, ..ClothMaterial::COTTON };
    let towels = [0.0, 1.0, 2.0, 3.0].map(|layer: f32| {
        let place = Transform::from_xyz(0.02 * layer, 0.38 + 0.13 * layer, 0.015 * layer)
            .with_rotation(Quat::from_rotation_y(0.25 + 0.45 * layer));
        let meets = (
            ClothInterCollision { friction: 0.9, ..default() },
            ClothSelfCollision { friction: 0.9, ..default() },
        );
        let sheet = Cloth::sheet(Vec2::splat(0.7), UVec2::splat(64));
        spawn(&mut app, (sheet, terry, meets, place))
    });
    let centre = |app: &App, towel| {
        let positions = simulation(app, towel).positions();
        let count = positions.len() as f32;
        positions.sum::<Vec3>() / count
    };
    let mut early = [Vec3::ZERO; 4];
    let mut since = None;
    for frame in 0..30 * 60 {
        app.update();
        if frame == 4 * 60 {
            early = towels.map(|towel| centre(&app, towel));
        }
        let sleep = towels.iter().all(|&towel| simulation(&app, towel).is_asleep());
        since = sleep.then(|| since.unwrap_or(frame));
    }
    for (towel, early) in towels.into_iter().zip(early) {
        let slid = centre(&app, towel).distance(early);
        check_at_most("slid since the fourth second [m]", slid.into(), 0.02);
    }
    let since = since.map_or(f64::INFINITY, |frame| f64::from(frame) * FRAME.as_secs_f64());
    check_at_most("all asleep after [s]", since, 25.0);
}
