//! Cloths that do less where less is seen. Truths: levels by counted metres, with their two borders; substeps of the plan; bit equality
//! between frame rates where a game gives the levels, and with plain cloths where nothing is asked for; that a change of level
//! moves nothing; and that what is refused is told.

use crate::support::app::*;
use bevy::{camera::CameraPlugin, prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    ClothBudget, ClothComponent, ClothErrorKind, ClothLevel, ClothLod, ClothProxy, ClothSettings,
    ClothSleepThreshold, PinSelection, prelude::*, solver::Substeps,
};
use std::time::Duration;

fn level(app: &App, cloth: Entity) -> usize {
    simulation(app, cloth).level()
}

fn substeps(app: &App, cloth: Entity) -> u32 {
    simulation(app, cloth).plan().substeps
}

/// Level 1 from 4 m on, level 2, which is coarser as well, from 8 m on.
fn levels() -> ClothLod {
    let coarse = ClothLevel::at(8.0).substeps(4).proxy(ClothProxy::grid(4, 4));
    ClothLod { levels: vec![ClothLevel::at(4.0).substeps(10), coarse], given: None }
}

fn pins() -> ClothPins {
    ClothPins::from(PinSelection::FirstRow)
}

/// An app with a camera, and a cloth at the origin.
fn seen_from(distance: f32) -> (App, Entity, Entity) {
    let mut app = app_with((ClothPlugin::default(), CameraPlugin));
    let place = Transform::from_xyz(0.0, 0.0, distance);
    let camera = spawn(&mut app, (Camera3d::default(), place));
    let cloth = spawn(&mut app, (sheet(), levels(), pins(), Transform::default()));
    updates(&mut app, 2);
    (app, camera, cloth)
}

#[test]
fn levels_go_by_the_distance_of_the_nearest_camera() {
    let (mut app, camera, cloth) = seen_from(2.0);
    let full = substeps(&app, cloth);
    assert!(full > 15);
    let half = 10;
    for (distance, expected, count) in [
        (3.9, 0, full),
        (4.1, 1, half),
        // Back at 85 % of it.
        (3.9, 1, half),
        (3.5, 1, half),
        (3.3, 0, full),
        (9.0, 2, 4),
        (7.0, 2, 4),
        (6.7, 1, half),
        (1.0, 0, full),
    ] {
        transform(&mut app, camera).translation = Vec3::new(0.0, 0.0, distance);
        updates(&mut app, 3);
        assert_eq!(level(&app, cloth), expected, "{distance}");
        let found = substeps(&app, cloth);
        // In 1/64 s, which is shorter than 1/60 s.
        assert!(found == count || found + 1 == count, "{distance}: {found} of {count}");
        let particles = if expected == 2 { 16 } else { 64 };
        assert_eq!(simulation(&app, cloth).particle_count(), particles);
    }
    // Another camera is nearer, or not active.
    transform(&mut app, camera).translation = Vec3::Z * 100.0;
    let second = spawn(&mut app, (Camera3d::default(), Transform::from_xyz(3.0, 0.0, 0.0)));
    updates(&mut app, 3);
    assert_eq!(level(&app, cloth), 0);
    app.world_mut().get_mut::<Camera>(second).unwrap().is_active = false;
    updates(&mut app, 3);
    assert_eq!(level(&app, cloth), 2);
    // Taken away, all is as the components say.
    app.world_mut().entity_mut(cloth).remove::<ClothLod>();
    updates(&mut app, 2);
    assert_eq!((level(&app, cloth), substeps(&app, cloth)), (0, full));
    assert_eq!(simulation(&app, cloth).particle_count(), 64);
    assert_eq!(failure(&app, cloth), None);
}

#[test]
fn settings_that_are_changed_meanwhile_are_in_force_below() {
    let (mut app, camera, cloth) = seen_from(5.0);
    assert_eq!(level(&app, cloth), 1);
    let before = substeps(&app, cloth);
    let fixed = ClothSettings { substeps: Substeps::Fixed(7), tethers: false, ..default() };
    app.world_mut().entity_mut(cloth).insert(fixed);
    updates(&mut app, 2);
    assert_eq!(substeps(&app, cloth), before, "the level's");
    transform(&mut app, camera).translation = Vec3::Z;
    updates(&mut app, 3);
    assert_eq!(substeps(&app, cloth), 7);
}

#[test]
fn a_change_of_level_is_not_seen() {
    let (mut app, camera, cloth) = seen_from(2.0);
    updates(&mut app, 30);
    for (turn, distance) in [5.0, 2.0, 5.0, 10.0, 1.0, 10.0].into_iter().enumerate() {
        transform(&mut app, camera).translation = Vec3::Z * distance;
        set_frame(&mut app, Duration::ZERO);
        app.update();
        let (before, handle) =
            (drawn_positions(&app, cloth), app.world().get::<Mesh3d>(cloth).cloned());
        let at = level(&app, cloth);
        updates(&mut app, 2);
        let off = farthest(&drawn_positions(&app, cloth), &before);
        // 4 x 4 cannot tell all folds of 8 x 8, and the other way round they can.
        let most = match (at, level(&app, cloth)) {
            (2, _) => 0.01,
            (_, 2) => 0.1,
            _ => 0.0,
        };
        assert!(off <= most, "{turn}: {off}");
        assert_eq!(app.world().get::<Mesh3d>(cloth).cloned(), handle);
        let tick = simulation(&app, cloth).tick_count();
        set_frame(&mut app, Duration::from_secs_f32(1.0 / 64.0));
        updates(&mut app, 10);
        assert!(simulation(&app, cloth).tick_count() >= tick + 9);
        assert_eq!(failure(&app, cloth), None);
        // The first row stays where it is held.
        let drawn = drawn_positions(&app, cloth);
        assert!(farthest(&drawn[..8], &before[..8]) < 1e-5);
    }
}

#[test]
fn a_given_level_is_in_force_from_the_first_tick_on() {
    let first_tick = |frames_before: usize| {
        let mut app = app();
        let lod = ClothLod { given: Some(2), ..levels() };
        let cloth = spawn(&mut app, (sheet(), lod, pins(), Transform::default()));
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
        updates(&mut app, frames_before);
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        app.update();
        assert_eq!((level(&app, cloth), substeps(&app, cloth)), (2, 4));
        assert_eq!(simulation(&app, cloth).tick_count(), 1);
        bits(&app, cloth)
    };
    // Without a frame before, it is set up in the tick itself.
    assert_eq!(first_tick(0), first_tick(2));
}

#[test]
fn a_refused_level_is_tried_again_when_it_is_another() {
    let mut app = app();
    let level = |columns| ClothLevel::at(1.0).proxy(ClothProxy::grid(columns, 4));
    let lod = |columns| ClothLod { levels: vec![level(columns)], given: Some(1) };
    let cloth = spawn(&mut app, (sheet(), lod(0), Transform::default()));
    updates(&mut app, 2);
    assert!(failure(&app, cloth).is_some());
    app.world_mut().entity_mut(cloth).insert(lod(4));
    updates(&mut app, 2);
    assert_eq!(failure(&app, cloth), None);
    assert_eq!(simulation(&app, cloth).particle_count(), 16);
}

#[test]
fn given_levels_have_the_same_bits_at_every_frame_rate() {
    #[derive(Resource)]
    struct Rule(Entity);
    fn rule(of: Res<Rule>, mut cloths: Query<(&mut ClothLod, &ClothSimulation)>) {
        if let Ok((mut lod, cloth)) = cloths.get_mut(of.0) {
            lod.given = Some((cloth.tick_count() / 9 % 4) as u32);
        }
    }
    let run = |rate: f32, camera: bool| {
        let mut app = app_with((ClothPlugin::default(), CameraPlugin));
        if camera {
            spawn(&mut app, (Camera3d::default(), Transform::from_xyz(0.0, 0.0, 6.0)));
            app.insert_resource(ClothBudget::new(1e-6));
        }
        let lod = ClothLod { given: Some(0), ..levels() };
        let cloth = spawn(&mut app, (sheet(), lod, pins(), Transform::default()));
        app.insert_resource(Rule(cloth)).add_systems(FixedUpdate, rule);
        set_frame(&mut app, Duration::from_secs_f32(1.0 / rate));
        let ticks = |app: &App| {
            app.world().get::<ClothSimulation>(cloth).map_or(0, ClothSimulation::tick_count)
        };
        let mut seen = Vec::new();
        while ticks(&app) < 72 {
            app.update();
            seen.extend(app.world().get::<ClothSimulation>(cloth).map(ClothSimulation::level));
        }
        assert_eq!(ticks(&app), 72);
        (0..3).for_each(|level| assert!(seen.contains(&level)));
        bits(&app, cloth)
    };
    let once = run(64.0, false);
    assert_eq!(once, run(32.0, false));
    assert_eq!(once, run(128.0, true), "cameras and budgets have no say");
}

#[test]
fn a_budget_raises_the_furthest_first_and_tells_it() {
    let mut app = app_with((ClothPlugin::default(), CameraPlugin));
    spawn(&mut app, (Camera3d::default(), Transform::default()));
    let cloths: Vec<_> = (0..12)
        .map(|i| {
            let place = Transform::from_xyz(0.0, 0.0, -0.2 * (i + 1) as f32);
            spawn(&mut app, (sheet(), levels(), pins(), place))
        })
        .collect();
    let given = ClothLod { given: Some(0), ..levels() };
    let given = spawn(&mut app, (sheet(), given, pins(), Transform::from_xyz(0.0, 0.0, -3.0)));
    let plain = spawn(&mut app, (sheet(), pins(), Transform::from_xyz(0.0, 0.0, -50.0)));
    let all = |app: &App| cloths.iter().map(|cloth| level(app, *cloth)).collect::<Vec<_>>();
    updates(&mut app, 20);
    assert_eq!(all(&app), [0; 12]);
    // What no machine can hold.
    app.insert_resource(ClothBudget::new(1e-6));
    let mut sums = vec![0];
    for _ in 0..64 * 5 {
        app.update();
        let now = all(&app);
        assert!(now.is_sorted(), "{now:?}");
        let sum = now.iter().sum::<usize>();
        assert!(sum <= sums.last().unwrap() + 2, "slowly: {sum}");
        sums.push(sum);
    }
    assert_eq!(all(&app), [2; 12]);
    assert_eq!([given, plain].map(|cloth| level(&app, cloth)), [0; 2]);
    let budget = app.world().resource::<ClothBudget>();
    assert!(budget.measured > 0.0);
    assert_eq!((budget.raised, budget.cloths.clone()), (24, vec![1, 0, 12, 0]));
    // What any machine can hold.
    app.world_mut().resource_mut::<ClothBudget>().milliseconds = 1e6;
    updates(&mut app, 64 * 5);
    assert_eq!(all(&app), [0; 12]);
    assert_eq!(app.world().resource::<ClothBudget>().cloths, [13, 0]);
    app.world_mut().remove_resource::<ClothBudget>();
    updates(&mut app, 2);
    assert_eq!(all(&app), [0; 12]);
}

#[test]
fn without_cameras_all_is_near_and_the_same_bits() {
    let mut app = app();
    let place = Transform::from_xyz(400.0, 0.0, 0.0);
    let plain = spawn(&mut app, (sheet(), pins(), place));
    let far = spawn(&mut app, (sheet(), pins(), levels(), place));
    updates(&mut app, 40);
    assert_eq!(bits(&app, plain), bits(&app, far));
}

#[test]
fn bad_levels_are_told_and_the_last_good_ones_stay() {
    let (mut app, _, cloth) = seen_from(5.0);
    let at = |distances: &[f32]| ClothLod {
        levels: distances.iter().map(|distance| ClothLevel::at(*distance)).collect(),
        given: None,
    };
    let none = ClothLod { levels: vec![ClothLevel::at(1.0).substeps(0)], given: None };
    for (bad, name) in [
        (at(&[0.0]), "distance"),
        (at(&[-1.0]), "distance"),
        (at(&[f32::NAN]), "distance"),
        (at(&[5.0, f32::INFINITY]), "distance"),
        (at(&[5.0, 5.0]), "distance"),
        (none, "substeps"),
    ] {
        app.world_mut().entity_mut(cloth).insert(bad);
        updates(&mut app, 2);
        let error = failure(&app, cloth).expect(name);
        let ClothErrorKind::Parameter { component, problem } = &error.kind else {
            panic!("{error}")
        };
        assert_eq!((*component, problem.name), (ClothComponent::ClothLod, name));
        assert_eq!(level(&app, cloth), 1);
        app.world_mut().entity_mut(cloth).insert(levels());
        updates(&mut app, 2);
        assert_eq!(failure(&app, cloth), None);
    }
    // A proxy of a level that cannot be: told as it would be in force, and the cloth goes on.
    let proxy = ClothLevel::at(1.0).proxy(ClothProxy::grid(99, 2));
    app.world_mut().entity_mut(cloth).insert(ClothLod { levels: vec![proxy], given: None });
    let before = simulation(&app, cloth).tick_count();
    updates(&mut app, 5);
    let error = failure(&app, cloth).expect("it is told");
    assert!(matches!(error.kind, ClothErrorKind::Proxy(_)), "{error}");
    assert_eq!(simulation(&app, cloth).tick_count(), before + 5);
    app.world_mut().entity_mut(cloth).remove::<ClothLod>();
    updates(&mut app, 2);
    assert_eq!(failure(&app, cloth), None);
}

#[test]
fn a_level_of_other_substeps_wakes_nothing() {
    let (mut app, camera, cloth) = seen_from(2.0);
    let at_once = ClothSleepThreshold { distance: 1.0, time: 0.5 };
    app.world_mut().entity_mut(cloth).insert(at_once);
    updates(&mut app, 64);
    let is_asleep = |app: &App| simulation(app, cloth).is_asleep();
    assert!(is_asleep(&app));
    let count = simulation(&app, cloth).tick_count();
    for distance in [5.0, 2.0, 5.0] {
        transform(&mut app, camera).translation = Vec3::new(0.0, 0.0, distance);
        updates(&mut app, 3);
        assert!(is_asleep(&app), "{distance} m");
    }
    assert_eq!((level(&app, cloth), substeps(&app, cloth)), (1, 10));
    assert_eq!(simulation(&app, cloth).tick_count(), count);
}
