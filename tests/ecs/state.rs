//! States of cloths, taken out and put back, held to bit equality with a game that was never saved; and what
//! is another cloth's is refused.

use crate::support::app::{
    saved_scene::{Case, Scene, goes_on},
    *,
};
use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_drape::{
    ClothError, ClothErrorKind, ClothSnapshot, SdfColliderSnapshot,
    prelude::*,
    sdf::{SdfSample, SignedDistance},
    solver::StateError,
};

#[test]
fn a_scene_saved_in_mid_fall_goes_on_with_the_same_bits() {
    for case in Case::ALL {
        for ticks in [2, 30] {
            goes_on(case, ticks, |state| state, |state| state);
        }
    }
}

#[test]
fn a_running_cloth_is_rewound() {
    for case in Case::ALL {
        let mut scene = Scene::new(case, 0);
        updates(&mut scene.app, 20);
        let state = simulation(&scene.app, scene.cloth).save();
        let at = scene.bits();
        assert_eq!((state.particle_count(), state.tick_count()), (64, 20));
        updates(&mut scene.app, 10);
        assert_ne!(scene.bits(), at);
        scene.app.world_mut().entity_mut(scene.cloth).insert(state.clone());
        // No tick in this frame: it is put back all the same, and can be taken out again.
        scene.app.world_mut().resource_mut::<Time<Virtual>>().pause();
        scene.app.update();
        assert_eq!(scene.bits(), at, "{case:?}");
        assert_eq!(simulation(&scene.app, scene.cloth).save(), state, "{case:?}");
        assert!(scene.app.world().get::<ClothSnapshot>(scene.cloth).is_none(), "it is used up");
    }
}

#[test]
fn sleep_goes_on_and_nothing_wakes_by_being_loaded() {
    let build = |others: usize| {
        let mut app = app();
        for _ in 0..others {
            spawn(&mut app, Name::new("another"));
        }
        let ball = spawn(&mut app, SdfCollider::from(Sphere::new(0.3)).with_friction(0.9));
        let thick = ClothMaterial { drag: 12.0, ..default() };
        let cloth = spawn(&mut app, (sheet(), thick, Transform::from_xyz(0.0, 0.32, 0.0)));
        (app, ball, cloth)
    };
    let (mut one, ball, cloth) = build(0);
    let asleep = |app: &App, cloth| simulation(app, cloth).is_asleep();
    let ticks = (0..2000).find(|_| {
        one.update();
        asleep(&one, cloth)
    });
    let ticks = ticks.expect("it falls asleep") + 1;
    let load = |one: &App, remembers: bool| {
        let (mut other, other_ball, other_cloth) = build(3);
        let state = ClothSnapshot::of(one.world().entity(cloth)).unwrap();
        other.world_mut().entity_mut(other_cloth).insert(state);
        if remembers {
            let state = SdfColliderSnapshot::of(one.world().entity(ball)).unwrap();
            other.world_mut().entity_mut(other_ball).insert(state);
        }
        (other, other_ball, other_cloth)
    };
    // Saved in its sleep it sleeps on, until something wakes it.
    let (mut other, other_ball, other_cloth) = load(&one, true);
    let count = simulation(&one, cloth).tick_count();
    for _ in 0..10 {
        other.update();
        assert!(asleep(&other, other_cloth));
    }
    assert_eq!(simulation(&other, other_cloth).tick_count(), count);
    assert_eq!(bits(&other, other_cloth), bits(&one, cloth));
    assert!(other.world().get::<SdfColliderSnapshot>(other_ball).is_none(), "it is used up");
    transform(&mut other, other_ball).translation.y -= 0.01;
    other.update();
    assert!(!asleep(&other, other_cloth));
    let (mut other, _, other_cloth) = load(&one, false);
    other.update();
    assert!(!asleep(&other, other_cloth), "a collider that was not there before");
    // Saved on the way to sleep, it falls asleep in the same tick.
    let (mut one, ball, cloth) = build(0);
    updates(&mut one, ticks - 20);
    assert!(!asleep(&one, cloth));
    let state = ClothSnapshot::of(one.world().entity(cloth)).unwrap();
    let (mut other, other_ball, other_cloth) = build(1);
    other.world_mut().entity_mut(other_cloth).insert(state);
    let state = SdfColliderSnapshot::of(one.world().entity(ball)).unwrap();
    other.world_mut().entity_mut(other_ball).insert(state);
    for _ in 0..25 {
        one.update();
        other.update();
        assert_eq!(asleep(&one, cloth), asleep(&other, other_cloth));
    }
    assert!(asleep(&one, cloth));
}

#[test]
fn a_state_of_another_size_takes_that_of_its_entity_at_once() {
    let mut one = app();
    let scaled = |scale: f32| Transform::from_scale(Vec3::splat(scale));
    let pins = ClothPins::vertices([0, 7]);
    let cloth = spawn(&mut one, (sheet(), pins.clone(), scaled(2.0)));
    updates(&mut one, 10);
    let state = ClothSnapshot::of(one.world().entity(cloth)).unwrap();
    *transform(&mut one, cloth) = scaled(3.0);
    let mut other = app();
    let twin = spawn(&mut other, (sheet(), pins, scaled(3.0)));
    other.world_mut().entity_mut(twin).insert(state);
    for _ in 0..30 {
        one.update();
        other.update();
        assert_eq!(bits(&one, cloth), bits(&other, twin));
    }
    let rest = simulation(&other, twin).rest_positions();
    assert_eq!(simulation(&one, cloth).rest_positions(), rest);
    assert!((rest[0].distance(rest[7]) - 3.0).abs() < 1e-5);
}

#[test]
fn a_state_of_another_cloth_is_told_and_changes_nothing() {
    let mut app = app();
    let cloth = |app: &mut App, x, y| spawn(app, Cloth::sheet(Vec2::ONE, UVec2::new(x, y)));
    let (one, twin) = (cloth(&mut app, 8, 8), cloth(&mut app, 8, 8));
    let (fewer, longer) = (cloth(&mut app, 7, 8), cloth(&mut app, 16, 4));
    let mesh = add_mesh(&mut app, holed_mesh());
    let holed = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d(mesh)));
    updates(&mut app, 5);
    for (from, expected) in [
        (fewer, StateError::WrongParticleCount { expected: 64, got: 56 }),
        (longer, StateError::OtherGrid),
        (holed, StateError::OtherGrid),
    ] {
        let state = simulation(&app, from).save();
        app.world_mut().entity_mut(one).insert(state);
        app.update();
        let told = ClothError { entity: one, kind: ClothErrorKind::Snapshot(expected) };
        assert_eq!(failure(&app, one), Some(told));
        assert!(app.world().get::<ClothSnapshot>(one).is_none());
        assert_eq!(bits(&app, one), bits(&app, twin));
        assert_eq!(failure(&app, twin), None);
    }
    let good = simulation(&app, twin).save();
    app.world_mut().entity_mut(one).insert(good);
    updates(&mut app, 3);
    assert_eq!(failure(&app, one), None);
    assert_eq!(bits(&app, one), bits(&app, twin));
}

#[test]
fn what_waits_for_its_mesh_keeps_its_state_until_then() {
    let mut one = app();
    let mesh = add_mesh(&mut one, holed_mesh());
    let cloth = spawn(&mut one, (Cloth::of_mesh3d(), Mesh3d(mesh)));
    updates(&mut one, 20);
    let state = simulation(&one, cloth).save();
    let mut other = app();
    let twin = spawn(&mut other, (Cloth::of_mesh3d(), Mesh3d::default(), state));
    updates(&mut other, 3);
    assert!(other.world().get::<ClothSnapshot>(twin).is_some());
    let mesh = add_mesh(&mut other, holed_mesh());
    other.world_mut().entity_mut(twin).insert(Mesh3d(mesh));
    for _ in 0..10 {
        one.update();
        other.update();
        assert_eq!(bits(&one, cloth), bits(&other, twin));
    }
}

/// Leads nowhere.
#[derive(Debug)]
struct Rotten;

impl SignedDistance for Rotten {
    fn sample(&self, _: Vec3) -> SdfSample {
        SdfSample { distance: -1.0, normal: Vec3::NAN }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }
}

#[test]
fn a_cloth_that_is_held_is_freed_by_an_earlier_state() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 5);
    let state = simulation(&app, cloth).save();
    let cause = spawn(&mut app, SdfCollider::custom(Rotten));
    updates(&mut app, 3);
    assert!(simulation(&app, cloth).is_quarantined());
    let held = simulation(&app, cloth).save();
    app.world_mut().despawn(cause);
    app.world_mut().entity_mut(cloth).insert(held);
    updates(&mut app, 3);
    assert!(simulation(&app, cloth).is_quarantined(), "so it was saved");
    app.world_mut().entity_mut(cloth).insert(state.clone());
    app.update();
    assert!(!simulation(&app, cloth).is_quarantined());
    assert_eq!(simulation(&app, cloth).tick_count(), state.tick_count() + 1);
    assert_eq!(failure(&app, cloth), None);
}
