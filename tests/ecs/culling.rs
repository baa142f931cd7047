//! Cloths that no view sees. Truths: counted ticks; the rigid motion of what leads a cloth, for what is drawn in the frame in which it
//! turns up; bounds of worn cloths; bit equality where nothing tells what is seen.

use crate::{
    skin::{CLOSE, beyond, dressed, skinned, usual, walk},
    support::app::*,
};
use bevy::{
    camera::{CameraPlugin, primitives::Aabb, visibility::VisibilityClass},
    prelude::*,
};
use bevy_drape::{ClothCulling, ClothPaused, ClothSleepThreshold, prelude::*};
use std::{any::TypeId, f32::consts::PI, time::Duration};

/// An app with a camera 5 m before the origin, that looks at it.
fn app_with_view() -> (App, Entity) {
    let mut app = app_with((ClothPlugin::default(), CameraPlugin));
    let camera = spawn(&mut app, (Camera3d::default(), looking_at(Vec3::ZERO)));
    (app, camera)
}

fn looking_at(place: Vec3) -> Transform {
    Transform::from_translation(place + Vec3::new(0.0, 1.0, 5.0)).looking_at(place, Vec3::Y)
}

fn look(app: &mut App, camera: Entity, place: Vec3) {
    *app.world_mut().get_mut::<Transform>(camera).unwrap() = looking_at(place);
}

fn ticks(app: &App, cloth: Entity) -> u64 {
    simulation(app, cloth).tick_count()
}

/// A sheet that hangs from a hand by its first row, 0.4 s after its start.
fn held(app: &mut App) -> [Entity; 2] {
    let hand = spawn(app, (Transform::default(), Visibility::default()));
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hand);
    let cloth = spawn(app, (sheet(), pins, ClothCulling::default(), Transform::default()));
    updates(app, 26);
    assert!(app.world().get::<VisibilityClass>(cloth).unwrap().contains(&TypeId::of::<Mesh3d>()));
    [hand, cloth]
}

const AWAY: Vec3 = Vec3::new(300.0, 0.0, 0.0);

#[test]
fn what_is_not_seen_takes_no_ticks_and_turns_up_where_its_anchor_is() {
    let rates = [64.0, 144.0, 30.0].map(|rate| Duration::from_secs_f32(1.0 / rate));
    // A short way as well, which a cloth that ticks would be dragged along.
    let ways = [(Vec3::new(-40.0, 2.0, 7.0), PI), (Vec3::new(1.2, 0.3, -0.8), 0.8)];
    for (frame, (place, angle)) in rates.into_iter().flat_map(|rate| ways.map(|way| (rate, way))) {
        let (mut app, camera) = app_with_view();
        let [hand, cloth] = held(&mut app);
        set_frame(&mut app, frame);
        let start = ticks(&app, cloth);
        updates(&mut app, 100);
        assert!(ticks(&app, cloth) > start + 40 && !simulation(&app, cloth).is_culled());
        look(&mut app, camera, AWAY);
        let (start, count) = (ticks(&app, cloth), (2.0 / frame.as_secs_f32()) as usize);
        updates(&mut app, count);
        // Half a second, and the frames that it takes to be known.
        let on = ticks(&app, cloth) - start;
        assert!((30..=36).contains(&on) && simulation(&app, cloth).is_culled(), "{on}");
        let before = positions(&app, cloth);
        // It goes on a way, and turns about.
        let to = Transform::from_translation(place).with_rotation(Quat::from_rotation_y(angle));
        for part in 1..=20 {
            let here = app.world().get::<Transform>(hand).unwrap().translation;
            let to = to.with_translation(here.lerp(place, part as f32 / 20.0));
            *app.world_mut().get_mut::<Transform>(hand).unwrap() = to;
            app.update();
        }
        assert_eq!(ticks(&app, cloth), start + on);
        assert_eq!(positions(&app, cloth), before);
        // Its bounds went along.
        let bounds = app.world().get::<Aabb>(cloth).unwrap();
        assert!(Vec3::from(bounds.center).distance(place) < 1.5, "{bounds:?}");

        look(&mut app, camera, place);
        app.update();
        // It is drawn in the same frame.
        let carried: Vec<_> = before.iter().map(|at| to.transform_point(*at)).collect();
        let off = |places: &[Vec3]| {
            places.iter().zip(&carried).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
        };
        assert!(
            off(&drawn_positions(&app, cloth)) < 1e-4,
            "{}",
            off(&drawn_positions(&app, cloth))
        );
        // And goes on from there, no faster than a sheet of a metre swings.
        let (mut last, mut count) = (carried.clone(), start + on);
        while count < start + on + 12 {
            app.update();
            let passed = ticks(&app, cloth) - count;
            if passed > 0 {
                let now = positions(&app, cloth);
                let far = now.iter().zip(&last).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
                assert!(far < 0.1 * passed as f32, "{passed}: {far}");
                (last, count) = (now, count + passed);
            }
        }
        let tick = simulation(&app, cloth).last_tick().unwrap();
        assert!(tick.max_strain <= 0.11, "{}", tick.max_strain);
        assert!(off(&last) < 0.8, "{}", off(&last));
    }
}

#[test]
fn a_worn_cloth_turns_up_within_its_bounds() {
    let (mut app, camera) = app_with_view();
    let of = dressed(&mut app, usual());
    app.world_mut().entity_mut(of.coat).insert(ClothCulling { after: 0.0 });
    let time = |tick: u32| tick as f32 / 64.0;
    for tick in 0..30 {
        walk(&mut app, &of, time(tick));
        app.update();
    }
    assert!(!simulation(&app, of.coat).is_culled());
    look(&mut app, camera, AWAY);
    // It stands as it is culled, so that it is known where it was.
    updates(&mut app, 5);
    let culled_at = ticks(&app, of.coat);
    assert!(simulation(&app, of.coat).is_culled());
    let skin = skinned(&mut app, &of);
    let places = positions(&app, of.coat).into_iter().zip(skin);
    let beside: Vec<_> = places.map(|(at, (place, normal))| (at - place, normal)).collect();
    let before = app.world().get::<Transform>(of.root).unwrap().rotation;
    // Then it dashes.
    for tick in 30..110 {
        walk(&mut app, &of, time(tick));
        app.update();
    }
    let root = *app.world().get::<Transform>(of.root).unwrap();
    look(&mut app, camera, root.translation);
    app.update();
    // Drawn where the skin is, as much beside it as it was, and turned with it.
    let skin = skinned(&mut app, &of);
    let drawn = drawn_positions(&app, of.coat);
    let off = drawn.iter().zip(&skin).zip(&beside);
    let off = off.map(|((at, (place, normal)), (beside, before))| {
        let lengths = at.distance(*place) - beside.length();
        lengths.abs().max(((at - place).dot(*normal) - beside.dot(*before)).abs())
    });
    assert!(off.fold(0.0, f32::max) < CLOSE);
    let furthest = beside.iter().map(|(beside, _)| beside.length()).fold(0.0, f32::max);
    let turn = root.rotation.angle_between(before);
    assert!(furthest > 0.05 && turn > 0.3, "{furthest} {turn}");
    // And that is where it is, as one that is paused shows.
    app.world_mut().entity_mut(of.coat).insert(ClothPaused::default());
    app.update();
    let mut last = positions(&app, of.coat);
    let off = last.iter().zip(&drawn).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(off < CLOSE && !simulation(&app, of.coat).is_culled(), "{off}");
    app.world_mut().entity_mut(of.coat).remove::<ClothPaused>();
    for tick in 110..140 {
        walk(&mut app, &of, time(tick));
        let skin = skinned(&mut app, &of);
        app.update();
        let now = positions(&app, of.coat);
        // Poses are those of the frame's start.
        let out = beyond(&app, &of, &skin, 1.0);
        assert!(out < CLOSE, "{tick}: {out}");
        let far = now.iter().zip(&last).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        // Legs swing by a tenth of a metre in a tick.
        assert!(far < 0.2, "{tick}: {far}");
        last = now;
    }
    assert_eq!(ticks(&app, of.coat), culled_at + 30);
}

#[test]
fn one_that_was_never_seen_goes_along_from_where_it_was_spawned() {
    let (mut app, camera) = app_with_view();
    look(&mut app, camera, AWAY);
    let hand = spawn(&mut app, (Transform::from_xyz(0.0, 0.0, 0.2), Visibility::default()));
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hand);
    let culling = ClothCulling { after: 0.0 };
    let held = spawn(&mut app, (sheet(), pins, culling, Transform::default()));
    // One that only its own entity leads.
    let pins = ClothPins::from(PinSelection::Corners);
    let own = spawn(&mut app, (sheet(), pins, culling, Transform::default()));
    // A frame without a tick, as many are.
    set_frame(&mut app, Duration::ZERO);
    app.update();
    set_frame(&mut app, Duration::from_secs_f32(1.0 / 64.0));
    updates(&mut app, 3);
    let before = positions(&app, held);
    assert_eq!([held, own].map(|cloth| ticks(&app, cloth)), [0; 2]);
    let to = |step: u32| {
        Transform::from_xyz(-0.3 * step as f32, 0.0, 0.2)
            .with_rotation(Quat::from_rotation_y(0.1 * step as f32))
    };
    for step in 1..=30 {
        *transform(&mut app, hand) = to(step);
        *transform(&mut app, own) = to(step);
        app.update();
    }
    look(&mut app, camera, to(30).translation);
    app.update();
    assert_eq!([held, own].map(|cloth| simulation(&app, cloth).is_culled()), [true; 2]);
    let way =
        to(30).compute_affine() * Transform::from_xyz(0.0, 0.0, 0.2).compute_affine().inverse();
    let carried = |way: &bevy::math::Affine3A| -> Vec<_> {
        before.iter().map(|at| way.transform_point3(*at)).collect()
    };
    let ways = [(held, way), (own, to(30).compute_affine())];
    for (cloth, way) in &ways {
        let off = farthest(&drawn_positions(&app, *cloth), &carried(way));
        assert!(off < 2e-5, "{cloth}: {off}");
    }
    updates(&mut app, 3);
    for (cloth, way) in &ways {
        assert!(!simulation(&app, *cloth).is_culled() && ticks(&app, *cloth) > 0);
        // It has fallen for a few ticks.
        assert!(farthest(&positions(&app, *cloth), &carried(way)) < 0.05);
        let tick = simulation(&app, *cloth).last_tick().unwrap();
        assert!(tick.max_strain < 0.11, "{}", tick.max_strain);
    }
}

#[test]
fn where_nothing_tells_what_is_seen_all_go_on() {
    let mut app = app();
    let plain = spawn(&mut app, (sheet(), Transform::default()));
    let culling = spawn(&mut app, (sheet(), ClothCulling { after: 0.0 }, Transform::default()));
    updates(&mut app, 30);
    assert_eq!(bits(&app, plain), bits(&app, culling));
    assert_eq!(ticks(&app, culling), 30);
    // With views, what has no mesh is not looked at.
    let (mut app, camera) = app_with_view();
    look(&mut app, camera, AWAY);
    let seen = spawn(&mut app, (sheet(), Transform::default()));
    updates(&mut app, 30);
    assert_eq!(ticks(&app, seen), 30, "it has no `ClothCulling`");
}

#[test]
fn it_goes_on_as_it_is_shown_or_asked_to() {
    let (mut app, _) = app_with_view();
    let [_, cloth] = held(&mut app);
    let is_culled = |app: &App| simulation(app, cloth).is_culled();
    app.world_mut().entity_mut(cloth).insert(Visibility::Hidden);
    updates(&mut app, 40);
    assert!(is_culled(&app));
    app.world_mut().entity_mut(cloth).insert(Visibility::Visible);
    updates(&mut app, 2);
    assert!(!is_culled(&app));
    app.world_mut().entity_mut(cloth).insert(Visibility::Hidden);
    updates(&mut app, 40);
    assert!(is_culled(&app));
    app.world_mut().entity_mut(cloth).remove::<ClothCulling>();
    let count = ticks(&app, cloth);
    updates(&mut app, 5);
    assert_eq!(ticks(&app, cloth), count + 5);
    // One that is paused as well stays so.
    app.world_mut().entity_mut(cloth).insert((ClothCulling::default(), ClothPaused::default()));
    updates(&mut app, 40);
    app.world_mut().entity_mut(cloth).insert(Visibility::Visible);
    updates(&mut app, 5);
    assert!(!is_culled(&app));
    assert_eq!(ticks(&app, cloth), count + 5);
}

#[test]
fn bad_numbers_are_told_and_the_last_good_ones_stay() {
    let (mut app, camera) = app_with_view();
    let [_, cloth] = held(&mut app);
    for after in [-1.0, f32::NAN, f32::INFINITY] {
        app.world_mut().entity_mut(cloth).insert(ClothCulling { after });
        app.update();
        let error = failure(&app, cloth).unwrap().to_string();
        assert!(error.contains("ClothCulling") && error.contains("after"), "{error}");
    }
    look(&mut app, camera, AWAY);
    updates(&mut app, 40);
    assert!(simulation(&app, cloth).is_culled());
    app.world_mut().entity_mut(cloth).insert(ClothCulling { after: 1.0 });
    app.update();
    assert_eq!(failure(&app, cloth), None);
}

/// The hand walks on, and what it holds is handed to another hand of the same character.
#[test]
fn pins_that_change_out_of_sight_hold_it_where_it_would_be() {
    let (mut app, camera) = app_with_view();
    let [hand, cloth] = held(&mut app);
    let other = spawn(&mut app, (Transform::from_xyz(0.5, 0.0, 0.0), ChildOf(hand)));
    updates(&mut app, 20);
    let before = positions(&app, cloth);
    look(&mut app, camera, AWAY);
    updates(&mut app, 60);
    assert!(simulation(&app, cloth).is_culled());
    let way = Vec3::new(-20.0, 1.0, 3.0);
    transform(&mut app, hand).translation = way;
    updates(&mut app, 3);
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(other);
    app.world_mut().entity_mut(cloth).insert(pins);
    updates(&mut app, 3);
    look(&mut app, camera, way);
    updates(&mut app, 2);
    assert!(!simulation(&app, cloth).is_culled());
    for (column, before) in before.iter().take(8).enumerate() {
        let off = position(&app, cloth, column).distance(*before + way);
        assert!(off < 1e-3, "{column}: {off}");
    }
    assert!(simulation(&app, cloth).strain().max < 0.02);
}

/// It is saved where its hand was, and put on another entity when that has gone on by less than a jump.
#[test]
fn one_that_is_saved_out_of_sight_goes_on_where_its_anchor_is() {
    let (mut app, camera) = app_with_view();
    let [hand, cloth] = held(&mut app);
    updates(&mut app, 200);
    look(&mut app, camera, AWAY);
    updates(&mut app, 60);
    transform(&mut app, hand).translation.x = 1.8;
    updates(&mut app, 3);
    let saved = simulation(&app, cloth).save();
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hand);
    let copy = spawn(&mut app, (sheet(), pins, saved, Transform::default()));
    for _ in 0..4 {
        app.update();
        assert!(simulation(&app, copy).strain().max < 0.02);
        assert!(mean_velocity(&app, copy).length() < 0.5);
    }
    assert!((position(&app, copy, 0).x - 1.8).abs() < 0.6);
}

/// Its limbs have moved since it was culled, and each particle goes where its own place of the skin is: in the same bits where it was
/// saved meanwhile, and with a new pin at a hand that has gone along.
#[test]
fn a_coat_that_is_saved_or_pinned_out_of_sight_goes_on_where_its_skin_is() {
    let run = |is_pinned: bool| {
        let (mut app, camera) = app_with_view();
        let of = dressed(&mut app, usual());
        app.world_mut().entity_mut(of.coat).insert(ClothCulling::default());
        updates(&mut app, 100);
        look(&mut app, camera, AWAY);
        updates(&mut app, 60);
        assert!(simulation(&app, of.coat).is_culled());
        walk(&mut app, &of, 1.5);
        updates(&mut app, 2);
        let saved = simulation(&app, of.coat).save();
        if is_pinned {
            let at = Transform::from_xyz(0.0, 1.0, -0.2);
            let hand = spawn(&mut app, (at, ChildOf(of.root)));
            let pins = ClothPins::vertices([0]).anchored_to(hand);
            app.world_mut().entity_mut(of.coat).insert(pins);
            updates(&mut app, 2);
        }
        let place = app.world().get::<Transform>(of.root).unwrap().translation;
        look(&mut app, camera, place);
        while simulation(&app, of.coat).is_culled() {
            app.update();
        }
        updates(&mut app, 4);
        let skin = skinned(&mut app, &of);
        assert!(beyond(&app, &of, &skin, 1.0) < CLOSE);
        assert!(position(&app, of.coat, 0).distance(skin[0].0) < 1e-3);
        (app, of, saved)
    };
    drop(run(true));
    let (mut app, of, saved) = run(false);
    let seen = (simulation(&app, of.coat).tick_count(), bits(&app, of.coat));
    app.world_mut().entity_mut(of.coat).remove::<ClothCulling>().insert(saved);
    app.update();
    assert!(simulation(&app, of.coat).tick_count() < seen.0);
    while simulation(&app, of.coat).tick_count() < seen.0 {
        app.update();
    }
    assert_eq!(bits(&app, of.coat), seen.1);
}

#[test]
fn one_that_sleeps_turns_up_asleep_where_nothing_has_moved() {
    let (mut app, camera) = app_with_view();
    let [hand, cloth] = held(&mut app);
    app.world_mut().entity_mut(cloth).insert(ClothSleepThreshold { distance: 1.0, time: 0.5 });
    updates(&mut app, 64);
    let is_asleep = |app: &App| simulation(app, cloth).is_asleep();
    assert!(is_asleep(&app));
    let count = ticks(&app, cloth);
    for place in [AWAY, Vec3::ZERO, AWAY] {
        look(&mut app, camera, place);
        updates(&mut app, 128);
        assert_eq!(simulation(&app, cloth).is_culled(), place == AWAY);
        assert!(is_asleep(&app));
    }
    assert_eq!(ticks(&app, cloth), count);
    // It goes along with its hand, and wakes for that.
    transform(&mut app, hand).translation.x = 0.3;
    look(&mut app, camera, Vec3::ZERO);
    updates(&mut app, 10);
    assert!(ticks(&app, cloth) > count && !is_asleep(&app));
}
