//! Diagnostics: numbers are those that the cloths themselves tell, times are those of a clock around them,
//! and the bits are the same with them and without.

use crate::support::app::*;
use bevy::{
    diagnostic::{DiagnosticPath, DiagnosticsStore},
    prelude::*,
};
use bevy_drape::{
    ClothDiagnosticsPlugin, ClothExecution, ClothGravityOverride, ClothSelfCollision,
    ClothSleepThreshold, prelude::*, solver::Substeps,
};
use std::time::Duration;

type It = ClothDiagnosticsPlugin;

const TIMES: [DiagnosticPath; 8] = [
    It::TICK,
    It::GATHER,
    It::SOLVE,
    It::DRAW,
    It::FORCES,
    It::INTEGRATE,
    It::CORRECT,
    It::COLLIDE,
];

fn measured() -> App {
    // Before the plugin that it measures: the order does not matter.
    app_with((ClothDiagnosticsPlugin, ClothPlugin::default()))
}

#[track_caller]
fn value(app: &App, path: &DiagnosticPath) -> f64 {
    let store = app.world().resource::<DiagnosticsStore>();
    let diagnostic = store.get(path).unwrap_or_else(|| panic!("{path} is registered"));
    diagnostic.value().unwrap_or_else(|| panic!("{path} is measured"))
}

/// Two cloths of different weaves over a ball, one of which feels the air, and one that sleeps.
fn scene(app: &mut App) -> [Entity; 3] {
    spawn(app, SdfCollider::from(Sphere::new(0.3)));
    // On the first: not what is looked at last.
    let substeps = ClothSettings { substeps: Substeps::Fixed(31), ..default() };
    let high = Transform::from_xyz(0.0, 0.31, 0.0);
    let falling = spawn(app, (sheet(), ClothAir::default(), substeps, high));
    let soft = ClothMaterial { thread_stiffness: 5.0, drag: 0.0, ..default() };
    let hanging = spawn(app, (sheet(), soft, ClothPins::vertices([0]), Transform::default()));
    let weightless = (
        sheet(),
        ClothGravityOverride(Vec3::ZERO),
        ClothSleepThreshold { time: 0.1, ..default() },
        Transform::from_xyz(50.0, 0.0, 0.0),
    );
    [falling, hanging, spawn(app, weightless)]
}

#[test]
fn numbers_are_what_the_cloths_tell() {
    let mut app = measured();
    let cloths = scene(&mut app);
    updates(&mut app, 30);
    assert_eq!((value(&app, &It::AWAKE), value(&app, &It::ASLEEP)), (2.0, 1.0));
    let awake = [cloths[0], cloths[1]].map(|cloth| simulation(&app, cloth));
    let ticks = awake.map(|cloth| *cloth.last_tick().unwrap());
    let contacts = ticks.iter().map(|tick| tick.contact_count).sum::<u32>();
    assert!(contacts >= 4, "it lies on the ball");
    assert_eq!(value(&app, &It::CONTACTS), f64::from(contacts));
    assert_eq!(value(&app, &It::SUBSTEPS), 31.0);
    assert_ne!(ticks[1].substeps, 31);
    let strain = awake.map(ClothSimulation::strain);
    let largest = strain[0].max.max(strain[1].max);
    assert!((value(&app, &It::STRAIN_MAX) - f64::from(largest)).abs() < 1e-5);
    // Both have as many threads.
    let mean = f64::from(strain[0].mean + strain[1].mean) / 2.0;
    assert!((value(&app, &It::STRAIN_MEAN) - mean).abs() < 1e-6);
    assert!(mean > 1e-4 && f64::from(largest) > 2.0 * mean);
}

#[test]
fn layers_are_counted_where_a_cloth_collides_with_itself() {
    let mut app = measured();
    app.insert_resource(ClothGravity(Vec3::ZERO));
    let tangled = |app: &mut App| {
        let mesh = Mesh3d(add_mesh(app, looped_mesh()));
        spawn(app, (Cloth::of_mesh3d(), mesh, ClothSleepThreshold::NEVER))
    };
    let with = tangled(&mut app);
    tangled(&mut app);
    updates(&mut app, 5);
    let is_measured = |app: &App, path: &DiagnosticPath| {
        app.world().resource::<DiagnosticsStore>().get(path).unwrap().history_len()
    };
    assert_eq!((is_measured(&app, &It::CROSSINGS), is_measured(&app, &It::SELF_CONTACTS)), (0, 0));
    app.world_mut().entity_mut(with).insert(ClothSelfCollision::default());
    app.update();
    let crossings = simulation(&app, with).crossings();
    assert!(crossings > 4, "{crossings}");
    assert_eq!(value(&app, &It::CROSSINGS), f64::from(crossings));
    let touching = simulation(&app, with).last_tick().unwrap().self_contact_count;
    assert_eq!(value(&app, &It::SELF_CONTACTS), f64::from(touching));
    // Once a second of the fixed clock, and not while nobody asks.
    updates(&mut app, 64);
    assert_eq!(is_measured(&app, &It::CROSSINGS), 2);
    assert_eq!(is_measured(&app, &It::SELF_CONTACTS), 65);
    let mut store = app.world_mut().resource_mut::<DiagnosticsStore>();
    store.get_mut(&It::CROSSINGS).unwrap().is_enabled = false;
    updates(&mut app, 64);
    assert_eq!(is_measured(&app, &It::CROSSINGS), 2);
}

#[test]
fn times_are_measured_and_parts_are_no_longer_than_the_whole() {
    for execution in [ClothExecution::Fused, ClothExecution::Staged] {
        let mut app = measured();
        app.insert_resource(execution);
        let cloths = scene(&mut app);
        // One cloth alone, so that no two are solved side by side.
        app.world_mut().despawn(cloths[1]);
        app.world_mut().despawn(cloths[2]);
        updates(&mut app, 10);
        let times = TIMES.map(|path| value(&app, &path));
        for (path, time) in TIMES.iter().zip(times) {
            assert!(time > 0.0 && time.is_finite(), "{path}: {time} ms");
        }
        let [tick, gather, solve, _, stages @ ..] = times;
        assert!(tick >= gather + solve, "{execution:?}: {times:?}");
        assert!(solve >= stages.iter().sum(), "{execution:?}: {times:?}");
    }
}

#[test]
fn measuring_changes_no_bit() {
    for execution in [ClothExecution::Fused, ClothExecution::Staged] {
        let mut with = measured();
        let mut without = app();
        let bits = [&mut with, &mut without].map(|app| {
            app.insert_resource(execution);
            let cloths = scene(app);
            updates(app, 40);
            cloths.map(|cloth| bits(app, cloth))
        });
        assert_eq!(bits[0], bits[1], "{execution:?}");
    }
}

#[test]
fn nothing_is_measured_without_the_plugin_or_in_a_pause() {
    let mut app = app();
    scene(&mut app);
    updates(&mut app, 5);
    let store = app.world().get_resource::<DiagnosticsStore>();
    let of_cloths = |store: &DiagnosticsStore| {
        store.iter().filter(|it| it.path().as_str().starts_with("cloth/")).count()
    };
    assert_eq!(store.map_or(0, of_cloths), 0);

    let mut app = measured();
    scene(&mut app);
    updates(&mut app, 5);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    let count = |app: &App| {
        let store = app.world().resource::<DiagnosticsStore>();
        store.get(&It::TICK).unwrap().history_len()
    };
    let before = count(&app);
    updates(&mut app, 5);
    assert_eq!(count(&app), before);

    // At a variable step no tick is taken.
    let mut app = app_with((ClothDiagnosticsPlugin, ClothPlugin::new(Update)));
    scene(&mut app);
    for frame in 5..15 {
        set_frame(&mut app, Duration::from_millis(frame));
        app.update();
    }
    assert_eq!(count(&app), 0);
}

#[test]
fn a_game_without_cloths_is_measured_as_well() {
    let mut app = measured();
    updates(&mut app, 3);
    assert_eq!(value(&app, &It::AWAKE), 0.0);
    // Nothing to compare: there is no strain of nothing.
    let store = app.world().resource::<DiagnosticsStore>();
    assert!(store.get(&It::STRAIN_MAX).unwrap().value().is_none());
}
