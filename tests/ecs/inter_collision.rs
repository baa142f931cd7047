//! Cloths that collide with each other, or not. Truths: no edge of one pierces a face of another; bit equality (forms, threads, saved
//! and loaded, what meets nobody); that what moves wakes what it touches, and what lies on each other falls asleep together;
//! that what is refused is told to its own entity alone.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothComponent, ClothError, ClothErrorKind, ClothExecution, ClothInertia, ClothInterCollision,
    ClothLayers, ClothPaused, ClothSleepThreshold, ClothSnapshot, SdfColliderSnapshot,
    TeleportCloth, prelude::*,
};

/// A square towel, level, at some height.
fn towel(side: f32, height: f32) -> impl Bundle {
    let soon = ClothSleepThreshold { time: 0.3, ..default() };
    (
        Cloth::sheet(Vec2::splat(side), UVec2::splat(16)),
        ClothInterCollision::default(),
        soon,
        Transform::from_xyz(0.0, height, 0.0),
    )
}

/// An app with a floor, and towels that are to lie on each other there.
fn pile(count: usize) -> (App, Vec<Entity>) {
    let mut app = app();
    floor(&mut app);
    let place = |k: usize| towel(0.5 - 0.05 * k as f32, 0.02 + 0.05 * k as f32);
    let towels = (0..count).map(|k| spawn(&mut app, place(k))).collect();
    (app, towels)
}

fn floor(app: &mut App) -> Entity {
    spawn(app, SdfCollider::from(InfinitePlane3d::default()).with_friction(0.8))
}

fn touching(app: &App, cloth: Entity) -> u32 {
    simulation(app, cloth).last_tick().map_or(0, |tick| tick.inter_contact_count)
}

fn asleep(app: &App, cloths: &[Entity]) -> Vec<bool> {
    cloths.iter().map(|&cloth| simulation(app, cloth).is_asleep()).collect()
}

#[track_caller]
fn until_all_sleep(app: &mut App, cloths: &[Entity]) {
    let sleep = (0..900).any(|_| {
        app.update();
        !asleep(app, cloths).contains(&false)
    });
    assert!(sleep, "{:?}", asleep(app, cloths));
}

fn height(app: &App, cloth: Entity) -> f32 {
    let places = simulation(app, cloth).positions();
    let count = places.len() as f32;
    places.map(|p| p.y).sum::<f32>() / count
}

#[test]
fn towels_lie_on_each_other_and_pass_through_those_that_do_not_collide() {
    let (mut app, towels) = pile(3);
    let without = spawn(&mut app, towel(0.4, 0.3));
    app.world_mut().entity_mut(without).remove::<ClothInterCollision>();
    let other_layer = spawn(&mut app, towel(0.4, 0.4));
    for &towel in &towels {
        let layers = ClothLayers(2);
        app.world_mut().entity_mut(towel).insert(ClothInterCollision { layers, ..default() });
    }
    app.world_mut()
        .entity_mut(other_layer)
        .insert(ClothInterCollision { layers: ClothLayers(4), ..default() });
    updates(&mut app, 120);
    let heights: Vec<_> = towels.iter().map(|&towel| height(&app, towel)).collect();
    assert!(heights.is_sorted_by(|a, b| a + 0.01 < *b), "{heights:?}");
    for through in [without, other_layer] {
        assert!(height(&app, through) < 0.01, "{}", height(&app, through));
        assert_eq!(touching(&app, through), 0);
    }
    assert!(towels.iter().all(|&towel| touching(&app, towel) > 0));
}

#[test]
fn what_meets_nobody_is_as_without_it() {
    let run = |with: bool| {
        let mut app = app();
        floor(&mut app);
        let towels = [0.0, 3.0].map(|x| {
            let towel = spawn(&mut app, towel(0.5, 0.3));
            transform(&mut app, towel).translation.x = x;
            towel
        });
        if !with {
            for towel in towels {
                app.world_mut().entity_mut(towel).remove::<ClothInterCollision>();
            }
        }
        updates(&mut app, 60);
        towels.map(|towel| bits(&app, towel))
    };
    assert!(run(true) == run(false));
}

#[test]
fn fused_and_staged_are_the_same() {
    let run = |execution| {
        let (mut app, mut towels) = pile(3);
        app.insert_resource(execution);
        // A second island.
        for height in [0.1, 0.2] {
            let towel = spawn(&mut app, towel(0.4, height));
            transform(&mut app, towel).translation.x = 2.0;
            towels.push(towel);
        }
        updates(&mut app, 50);
        assert!(towels.iter().all(|&towel| touching(&app, towel) > 0));
        towels.iter().map(|&towel| bits(&app, towel)).collect::<Vec<_>>()
    };
    assert!(run(ClothExecution::Fused) == run(ClothExecution::Staged));
}

#[test]
fn towels_that_lie_on_each_other_sleep_and_wake_together() {
    let (mut app, towels) = pile(3);
    let mut fell = None;
    for tick in 0..900 {
        app.update();
        let asleep = asleep(&app, &towels);
        if asleep.contains(&true) {
            fell.get_or_insert(tick);
            assert!(!asleep.contains(&false), "{asleep:?} in tick {tick}");
            break;
        }
    }
    assert!(fell.is_some(), "they fall asleep");
    // Far away, something moves, and nobody notices.
    let far = spawn(&mut app, towel(0.3, 1.0));
    transform(&mut app, far).translation.x = 5.0;
    updates(&mut app, 10);
    assert_eq!(asleep(&app, &towels), [true; 3]);
    // Another one falls onto them.
    let falls = spawn(&mut app, towel(0.3, 0.5));
    let before = bits(&app, towels[2]);
    let touched = (0..60).find(|_| {
        app.update();
        touching(&app, falls) > 0
    });
    assert!(touched.is_some(), "it comes down on them");
    updates(&mut app, 10);
    assert_eq!(asleep(&app, &towels), [false; 3]);
    assert!(before != bits(&app, towels[2]));
    let all = [&towels[..], &[falls]].concat();
    until_all_sleep(&mut app, &all);
    let heights: Vec<_> = all.iter().map(|&towel| height(&app, towel)).collect();
    assert!(heights.is_sorted_by(|a, b| a + 0.01 < *b), "{heights:?}");
}

#[test]
fn who_lay_on_what_has_gone_wakes() {
    type Change = fn(&mut App, Entity);
    let changes: [(&str, Change); 4] = [
        ("despawned", |app, cloth| _ = app.world_mut().despawn(cloth)),
        ("removed", |app, cloth| {
            app.world_mut().entity_mut(cloth).remove::<ClothInterCollision>();
        }),
        ("another layer", |app, cloth| {
            let layers = ClothLayers(8);
            app.world_mut().entity_mut(cloth).insert(ClothInterCollision { layers, ..default() });
        }),
        ("teleported", |app, cloth| {
            transform(app, cloth).translation.x += 3.0;
            app.world_mut().trigger(TeleportCloth { entity: cloth });
        }),
    ];
    for (what, change) in changes {
        let (mut app, towels) = pile(2);
        // Of the upper one's layers, one is that of the lower one alone.
        let layers = ClothLayers(1);
        for &towel in &towels {
            app.world_mut().entity_mut(towel).insert(ClothInterCollision { layers, ..default() });
        }
        until_all_sleep(&mut app, &towels);
        let before = height(&app, towels[1]);
        change(&mut app, towels[0]);
        updates(&mut app, 60);
        let after = height(&app, towels[1]);
        assert!(after < before - 0.01, "{what}: it falls from {before} to {after}");
    }
}

#[test]
fn a_paused_cloth_is_a_wall() {
    let mut app = app();
    let wall = spawn(&mut app, (towel(0.6, 0.0), ClothPaused::default()));
    let falls = spawn(&mut app, towel(0.4, 0.1));
    updates(&mut app, 2);
    let before = bits(&app, wall);
    until_all_sleep(&mut app, &[falls]);
    assert!(bits(&app, wall) == before);
    assert!(height(&app, falls) > 0.01);
    // Let go, both fall.
    app.world_mut().entity_mut(wall).remove::<ClothPaused>();
    updates(&mut app, 40);
    assert!(height(&app, falls) < -0.1, "{}", height(&app, falls));
}

/// A cloth on a cart that rides along, and one that lies on it.
#[test]
fn cloths_that_ride_along_keep_what_they_carry() {
    let mut app = app();
    let lower = spawn(
        &mut app,
        (towel(0.5, 0.0), ClothInertia::new(0.0), ClothPins::vertices([0, 15, 240, 255])),
    );
    let upper = spawn(&mut app, towel(0.3, 0.06));
    updates(&mut app, 30);
    assert!(touching(&app, upper) > 0);
    for _ in 0..60 {
        // Upwards, 1 m in a second: what was taken to be at rest would be left behind, and come through.
        transform(&mut app, lower).translation.y += 1.0 / 64.0;
        app.update();
        let middle = |cloth: Entity| simulation(&app, cloth).position(8 * 16 + 8).unwrap().y;
        let [one, other] = [lower, upper].map(middle);
        assert!(other > one + 0.01, "{other} above {one}");
    }
}

#[test]
fn a_pile_that_is_saved_goes_on_with_the_same_bits() {
    let build = |others: usize| {
        let mut app = app();
        for _ in 0..others {
            spawn(&mut app, Name::new("another"));
        }
        let floor = floor(&mut app);
        let place = |k: usize| towel(0.5 - 0.05 * k as f32, 0.02 + 0.05 * k as f32);
        let towels: Vec<_> = (0..3).map(|k| spawn(&mut app, place(k))).collect();
        (app, floor, towels)
    };
    let (mut one, floor, towels) = build(0);
    updates(&mut one, 12);
    let (mut other, other_floor, others) = build(3);
    let state = SdfColliderSnapshot::of(one.world().entity(floor)).unwrap();
    other.world_mut().entity_mut(other_floor).insert(state);
    for (&towel, &other_towel) in towels.iter().zip(&others) {
        let state = ClothSnapshot::of(one.world().entity(towel)).unwrap();
        other.world_mut().entity_mut(other_towel).insert(state);
    }
    for tick in 0..200 {
        one.update();
        other.update();
        for (&towel, &other_towel) in towels.iter().zip(&others) {
            assert!(bits(&one, towel) == bits(&other, other_towel), "after {tick}");
        }
        assert_eq!(asleep(&one, &towels), asleep(&other, &others), "after {tick}");
    }
    assert!(towels.iter().all(|&towel| touching(&one, towel) > 0));
}

#[test]
fn what_is_refused_is_told_until_it_is_mended() {
    let (mut app, towels) = pile(2);
    let is_told = |app: &App| match failure(app, towels[0]) {
        None => None,
        Some(ClothError { entity, kind: ClothErrorKind::Parameter { component, problem } }) => {
            assert_eq!((entity, component), (towels[0], ClothComponent::ClothInterCollision));
            Some(problem.name)
        }
        Some(other) => panic!("{other}"),
    };
    let good = ClothInterCollision::default();
    for (name, bad) in [
        ("distance", ClothInterCollision { distance: Some(0.05), ..good }),
        ("friction", ClothInterCollision { friction: f32::NAN, ..good }),
    ] {
        app.world_mut().entity_mut(towels[0]).insert(bad);
        updates(&mut app, 2);
        assert_eq!((is_told(&app), failure(&app, towels[1])), (Some(name), None));
    }
    app.world_mut().entity_mut(towels[0]).insert(good);
    app.update();
    assert_eq!(is_told(&app), None);
    updates(&mut app, 40);
    assert!(touching(&app, towels[0]) > 0);
}

#[test]
fn what_has_no_layers_meets_nobody() {
    let (mut app, towels) = pile(2);
    updates(&mut app, 40);
    assert!(touching(&app, towels[0]) > 0);
    let none = ClothInterCollision { layers: ClothLayers::NONE, ..default() };
    app.world_mut().entity_mut(towels[1]).insert(none);
    updates(&mut app, 40);
    assert_eq!((failure(&app, towels[1]), touching(&app, towels[0])), (None, 0));
    assert!((height(&app, towels[1]) - height(&app, towels[0])).abs() < 1e-3);
}
