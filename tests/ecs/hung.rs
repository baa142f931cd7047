//! Cloths that start hung: held to how little they move once they start, to exact places of what holds
//! them, and to the same bits however long the background task takes.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    ClothComponent, ClothError, ClothErrorKind, ClothGravityOverride, ClothSleepThreshold,
    HangProblem, HangingPlaces, hang::HangError, prelude::*,
};
use std::{thread, time::Duration};

fn anchor(app: &mut App, at: Vec3) -> Entity {
    spawn(app, Transform::from_translation(at))
}

/// A metre of cloth, 16 x 16, from two anchors.
fn curtain(left: Entity, right: Entity) -> impl Bundle {
    (
        Cloth::sheet(Vec2::ONE, UVec2::splat(16)),
        ClothPins::vertices([0])
            .anchored_to(left)
            .and(ClothPins::vertices([15]).anchored_to(right)),
        HangOnStart::default(),
        ClothSleepThreshold::NEVER,
        Transform::from_xyz(5.0, 5.0, 5.0),
    )
}

fn spawn_curtain(app: &mut App, left: Vec3, right: Vec3) -> Entity {
    let (left, right) = (anchor(app, left), anchor(app, right));
    spawn(app, curtain(left, right))
}

const LEFT: Vec3 = Vec3::new(-0.35, 2.0, 0.0);
const RIGHT: Vec3 = Vec3::new(0.35, 2.0, 0.0);

fn wait_for(app: &mut App, entity: Entity) {
    app.update();
    wait(app, |app| simulation(app, entity).tick_count() > 0);
}

#[test]
fn a_hung_cloth_starts_at_rest() {
    let mut app = app();
    let entity = spawn_curtain(&mut app, LEFT, RIGHT);
    app.update();
    // Held, in Weil's shape, until the task is done; drawn so.
    let cloth = simulation(&app, entity);
    assert!(cloth.is_hanging() || cloth.hung().is_some());
    assert_eq!((position(&app, entity, 0), position(&app, entity, 15)), (LEFT, RIGHT));
    let lowest = |places: &[Vec3]| places.iter().map(|place| place.y).fold(f32::MAX, f32::min);
    assert!(lowest(&positions(&app, entity)) < 0.75, "it hangs");
    assert!(lowest(&drawn_positions(&app, entity)) < 0.75, "it is drawn so");
    wait_for(&mut app, entity);
    let report = simulation(&app, entity).hung().expect("it was hung");
    assert!(report.at_rest && report.ticks > 0, "{report:?}");
    let before = positions(&app, entity);
    let mut most = 0.0_f32;
    for _ in 0..64 {
        app.update();
        most = most.max(farthest(&before, &positions(&app, entity)));
    }
    assert!(most < 0.02, "it moves by {most} m");
    assert_eq!((position(&app, entity, 0), position(&app, entity, 15)), (LEFT, RIGHT));
    assert_eq!(failure(&app, entity), None);
}

#[test]
fn however_long_it_takes_it_starts_alike() {
    let run = |patience: Duration, frames: usize| {
        let mut app = app();
        let entity = spawn_curtain(&mut app, LEFT, RIGHT);
        updates(&mut app, frames);
        thread::sleep(patience);
        wait_for(&mut app, entity);
        // More than there can have been of while it was waited for.
        while simulation(&app, entity).tick_count() < 64 {
            app.update();
        }
        (bits(&app, entity), *simulation(&app, entity).hung().unwrap())
    };
    let soon = run(Duration::ZERO, 1);
    assert_eq!(soon, run(Duration::from_secs(2), 1));
    assert_eq!(soon, run(Duration::ZERO, 30));
}

#[test]
fn nothing_is_hung_that_is_not_asked_to_be() {
    let mut app = app();
    let entity = spawn(&mut app, (sheet(), ClothPins::vertices([0, 7])));
    app.update();
    let cloth = simulation(&app, entity);
    assert_eq!((cloth.is_hanging(), cloth.hung(), cloth.tick_count()), (false, None, 1));
    // Nor what runs already.
    let before = positions(&app, entity);
    app.world_mut().entity_mut(entity).insert(HangOnStart::default());
    app.update();
    assert_eq!(simulation(&app, entity).tick_count(), 2);
    assert!(farthest(&before, &positions(&app, entity)) < 0.05);
}

#[test]
fn what_cannot_be_hung_is_told_and_starts_in_its_rest_shape() {
    let far = [LEFT, LEFT + 1.2 * Vec3::X];
    let same = [LEFT, LEFT];
    for (places, is_expected) in [
        (
            far,
            (|e| matches!(e, HangError::TooFar { first: 0, second: 15, .. }))
                as fn(&HangError) -> bool,
        ),
        (same, |e| matches!(e, HangError::Coincident { first: 0, second: 15 })),
    ] {
        let mut app = app();
        let entity = spawn_curtain(&mut app, places[0], places[1]);
        let usual = spawn_curtain(&mut app, places[0], places[1]);
        app.world_mut().entity_mut(usual).remove::<HangOnStart>();
        updates(&mut app, 3);
        let error = failure(&app, entity).expect("it is refused");
        assert!(error.to_string().contains(&entity.to_string()), "{error}");
        let ClothError { kind: ClothErrorKind::Hang(HangProblem::Places(problem)), .. } = &error
        else {
            panic!("{error}");
        };
        assert!(is_expected(problem), "{problem}");
        assert_eq!(simulation(&app, entity).tick_count(), 3);
        assert_eq!(bits(&app, entity), bits(&app, usual), "as if nothing had been asked");
        assert_eq!(failure(&app, usual), None);
        app.world_mut().entity_mut(entity).remove::<HangOnStart>();
        app.update();
        assert_eq!(failure(&app, entity), None);
    }
    let mut app = app();
    let one = spawn(&mut app, (sheet(), ClothPins::vertices([3]), HangOnStart::default()));
    let bad = HangOnStart { longest: f32::NAN, ..default() };
    let number = spawn(&mut app, (sheet(), ClothPins::vertices([0, 7]), bad));
    let weightless = (sheet(), ClothPins::vertices([0, 7]), HangOnStart::default());
    let weightless = spawn(&mut app, (weightless, ClothGravityOverride(Vec3::ZERO)));
    updates(&mut app, 2);
    let problem = |problem| ClothError {
        entity: one,
        kind: ClothErrorKind::Hang(HangProblem::Places(problem)),
    };
    assert_eq!(failure(&app, one), Some(problem(HangError::TooFewPoints(1))));
    let told = failure(&app, number).expect("it is refused");
    assert!(
        matches!(
            told,
            ClothError {
                kind: ClothErrorKind::Parameter { component: ClothComponent::HangOnStart, .. },
                ..
            }
        ),
        "{told}"
    );
    let told = failure(&app, weightless).expect("it is refused").to_string();
    assert!(told.contains("gravity"), "{told}");
    for entity in [one, number, weightless] {
        assert_eq!(simulation(&app, entity).tick_count(), 2);
    }
}

#[test]
fn it_is_carried_along_while_it_waits() {
    let run = |shift: Vec3| {
        let mut app = app();
        let (left, right) = (anchor(&mut app, LEFT), anchor(&mut app, RIGHT));
        let entity = spawn(&mut app, curtain(left, right));
        // Enough of it that the task is not done within the ten ticks to come.
        *app.world_mut().get_mut(entity).unwrap() = Cloth::sheet(Vec2::ONE, UVec2::splat(48));
        let pins = ClothPins::vertices([0]).anchored_to(left);
        let pins = pins.and(ClothPins::vertices([47]).anchored_to(right));
        app.world_mut().entity_mut(entity).insert(pins);
        for _ in 0..10 {
            app.update();
            transform(&mut app, left).translation += shift;
            transform(&mut app, right).translation += shift;
        }
        app.update();
        assert!(simulation(&app, entity).is_hanging());
        assert_eq!(position(&app, entity, 0), LEFT + 10.0 * shift);
        wait_for(&mut app, entity);
        updates(&mut app, 10);
        assert_eq!(position(&app, entity, 47), RIGHT + 10.0 * shift);
        positions(&app, entity)
    };
    let still = run(Vec3::ZERO);
    // By steps that are exact: to the bit, but for the rounding of the places that are read.
    let shift = Vec3::new(0.0, 0.0, 0.25);
    let there: Vec<_> = still.iter().map(|place| *place + 10.0 * shift).collect();
    let off = farthest(&run(shift), &there);
    assert!(off < 1e-4, "it is {off} m from where it was carried to");
}

#[test]
fn what_moves_before_the_first_tick_is_hung_there() {
    let mut app = app();
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    let (left, right) = (anchor(&mut app, LEFT), anchor(&mut app, RIGHT));
    let entity = spawn(&mut app, curtain(left, right));
    updates(&mut app, 2);
    assert_eq!(position(&app, entity, 15), RIGHT);
    transform(&mut app, right).translation = RIGHT + 0.2 * Vec3::X;
    updates(&mut app, 2);
    assert_eq!(position(&app, entity, 15), RIGHT + 0.2 * Vec3::X);
    // Out of reach it lies in its rest shape, and hangs again once it can.
    transform(&mut app, right).translation = RIGHT + Vec3::X;
    updates(&mut app, 2);
    assert!(matches!(
        failure(&app, entity),
        Some(ClothError { kind: ClothErrorKind::Hang(_), .. })
    ));
    assert!(position(&app, entity, 15).distance(Vec3::new(5.5, 5.0, 4.5)) < 1e-6);
    transform(&mut app, right).translation = RIGHT + 0.2 * Vec3::X;
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    wait_for(&mut app, entity);
    updates(&mut app, 20);
    assert_eq!(position(&app, entity, 0), LEFT);
    assert_eq!(position(&app, entity, 15), RIGHT + 0.2 * Vec3::X);
}

#[test]
fn what_one_anchor_holds_keeps_its_arrangement() {
    let mut app = app();
    let (left, right) = (anchor(&mut app, LEFT), anchor(&mut app, RIGHT));
    let pins = ClothPins::vertices([0, 1, 2]).anchored_to(left);
    let pins = pins.and(ClothPins::vertices([15]).anchored_to(right));
    let entity = spawn(&mut app, curtain(left, right));
    app.world_mut().entity_mut(entity).insert(pins.clone());
    // Where they are at rest, asked for by name.
    let at_rest = HangOnStart { places: HangingPlaces::Rest, ..default() };
    let other = spawn(&mut app, curtain(left, right));
    app.world_mut().entity_mut(other).insert((pins, at_rest));
    wait_for(&mut app, entity);
    wait_for(&mut app, other);
    updates(&mut app, 3);
    for i in 0..3 {
        let place = LEFT + (i as f32 - 1.0) / 15.0 * Vec3::X;
        assert!(position(&app, entity, i).distance(place) < 1e-6);
        let place = Vec3::new(4.5 + i as f32 / 15.0, 5.0, 4.5);
        assert!(position(&app, other, i).distance(place) < 1e-6);
    }
    assert_eq!(position(&app, entity, 15), RIGHT);
    assert!(position(&app, other, 15).distance(Vec3::new(5.5, 5.0, 4.5)) < 1e-6);
}

#[test]
fn removed_while_it_waits_it_starts_from_where_it_is() {
    let mut app = app();
    let entity = spawn_curtain(&mut app, LEFT, RIGHT);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    app.update();
    let hung = positions(&app, entity);
    app.world_mut().entity_mut(entity).remove::<HangOnStart>();
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.update();
    assert_eq!(simulation(&app, entity).tick_count(), 1);
    // Not yet at rest, but not where it lay flat either.
    assert!(hung != positions(&app, entity));
    assert!(positions(&app, entity).iter().any(|place| place.y < 1.2));
    assert_eq!(position(&app, entity, 15), RIGHT);
}

#[test]
fn other_pins_hang_it_anew() {
    let mut app = app();
    let entity = spawn_curtain(&mut app, LEFT, RIGHT);
    let middle = anchor(&mut app, Vec3::new(0.0, 1.9, 0.0));
    app.update();
    if simulation(&app, entity).is_hanging() {
        let more = ClothPins::vertices([7]).anchored_to(middle);
        let pins = app.world().get::<ClothPins>(entity).unwrap().clone();
        app.world_mut().entity_mut(entity).insert(pins.and(more));
        app.update();
        assert_eq!(position(&app, entity, 7), Vec3::new(0.0, 1.9, 0.0));
        wait_for(&mut app, entity);
        updates(&mut app, 5);
        assert_eq!(position(&app, entity, 7), Vec3::new(0.0, 1.9, 0.0));
        assert_eq!(position(&app, entity, 15), RIGHT);
    }
}

#[test]
fn soft_pins_and_meshes_and_scales_hang_as_well() {
    let mut app = app();
    let (left, right) = (anchor(&mut app, LEFT), anchor(&mut app, RIGHT));
    let soft = ClothPins::vertices([0]).anchored_to(left);
    let soft = soft.and(ClothPins::vertices([15]).anchored_to(right)).softly(2000.0, 1.0);
    let pins = soft;
    let soft = spawn(&mut app, curtain(left, right));
    app.world_mut().entity_mut(soft).insert(pins);
    let place = |r: u32, c: u32| Vec3::new(c as f32 / 8.0, 0.0, r as f32 / 8.0);
    let mesh = Mesh3d(add_mesh(&mut app, grid_mesh(9, 9, |v| v, place)));
    let pins = ClothPins::vertices([0]).anchored_to(left);
    let pins = pins.and(ClothPins::vertices([8]).anchored_to(right));
    let scaled = Transform::from_scale(Vec3::splat(0.8));
    let scaled = spawn(&mut app, (Cloth::of_mesh3d(), mesh, pins, HangOnStart::default(), scaled));
    wait_for(&mut app, soft);
    wait_for(&mut app, scaled);
    updates(&mut app, 10);
    assert!(position(&app, soft, 15).distance(RIGHT) < 0.01);
    assert_eq!(position(&app, scaled, 8), RIGHT);
    assert!(position(&app, scaled, 40).y < 1.8);
    for entity in [soft, scaled] {
        assert_eq!(failure(&app, entity), None);
        assert!(simulation(&app, entity).hung().is_some_and(|report| report.at_rest));
    }
}

#[test]
fn bare_minimal_plugins_will_do() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, ClothPlugin::default()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.finish();
    app.cleanup();
    let entity = spawn_curtain(&mut app, LEFT, RIGHT);
    app.update();
    wait_for(&mut app, entity);
    assert!(simulation(&app, entity).hung().is_some());
}
