//! Cloths that collide with themselves, or not. Truths: no edge pierces a face; bit equality (forms, saved and loaded, what
//! was switched off in time); that what is refused is told to its own entity alone, until it is mended.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothComponent, ClothError, ClothErrorKind, ClothExecution, ClothSelfCollision,
    ClothSleepThreshold, ClothSnapshot, SdfColliderSnapshot, prelude::*,
};

const PARTICLES: u32 = 20;

/// A towel that comes down on its edge, slightly askew, and falls in folds.
fn towel() -> impl Bundle {
    let turned = Quat::from_euler(EulerRot::XYZ, 1.45, 0.1, 0.05);
    (
        Cloth::sheet(Vec2::splat(0.6), UVec2::splat(PARTICLES)),
        Transform::from_xyz(0.0, 0.34, 0.0).with_rotation(turned),
    )
}

fn floor(app: &mut App) -> Entity {
    spawn(app, SdfCollider::from(InfinitePlane3d::default()).with_friction(0.8))
}

/// An app with a floor and a towel that collides with itself.
fn heap() -> (App, Entity) {
    let mut app = app();
    floor(&mut app);
    let towel = spawn(&mut app, (towel(), ClothSelfCollision::default()));
    (app, towel)
}

fn layers(app: &App, cloth: Entity) -> u32 {
    simulation(app, cloth).plan().layers
}

fn touching(app: &App, cloth: Entity) -> u32 {
    simulation(app, cloth).last_tick().map_or(0, |tick| tick.self_contact_count)
}

/// A cloth at rest on a floor is asleep.
#[track_caller]
fn until_asleep(app: &mut App, cloth: Entity, most: usize) {
    let sleeps = (0..most).any(|_| {
        app.update();
        simulation(app, cloth).is_asleep()
    });
    assert!(sleeps, "awake after {most} ticks");
}

#[test]
fn only_a_cloth_that_is_to_collide_with_itself_does() {
    let (mut app, with) = heap();
    // Another floor does not matter: cloths do not meet each other.
    let without = spawn(&mut app, towel());
    let (mut most, mut passed) = (0, 0);
    for _ in 0..100 {
        app.update();
        most = most.max(touching(&app, with));
        assert_eq!(simulation(&app, with).crossings(), 0);
        passed = passed.max(simulation(&app, without).crossings());
        assert_eq!(touching(&app, without), 0);
    }
    assert!(most > 20, "{most} pairs touch");
    assert!(passed > 50, "without it, {passed} crossings");
    assert!(layers(&app, with) >= 12, "{}", simulation(&app, with).plan());
    assert_eq!(layers(&app, without), 0);
}

#[test]
fn it_comes_and_goes_with_its_component() {
    let (mut app, towel_) = heap();
    let never = spawn(&mut app, towel());
    updates(&mut app, 5);
    // Nothing has touched yet: as if it had never been there.
    app.world_mut().entity_mut(towel_).remove::<ClothSelfCollision>();
    updates(&mut app, 65);
    assert_eq!(bits(&app, towel_), bits(&app, never));
    assert_eq!(layers(&app, towel_), 0);
    assert!(simulation(&app, never).crossings() > 0);
    // A running cloth is given it.
    app.world_mut().entity_mut(never).insert(ClothSelfCollision::default());
    updates(&mut app, 5);
    assert!(layers(&app, never) > 0 && touching(&app, never) > 0);
    assert_ne!(bits(&app, towel_), bits(&app, never));
    // Its numbers are live.
    let before = layers(&app, never);
    let thin = ClothSelfCollision { distance: Some(0.012), ..default() };
    app.world_mut().entity_mut(never).insert(thin);
    updates(&mut app, 2);
    assert!(layers(&app, never) > before, "thinner layers need more substeps");
    assert_eq!((failure(&app, towel_), failure(&app, never)), (None, None));
    // Other weights or masses make a solver anew.
    app.world_mut().entity_mut(never).insert(ClothSettings::REFERENCE);
    app.update();
    assert!(layers(&app, never) > 0);
}

#[test]
fn a_change_wakes_a_cloth() {
    let mut app = app();
    floor(&mut app);
    let level = Transform::from_xyz(0.0, 0.006, 0.0);
    let soon = ClothSleepThreshold { time: 0.2, ..default() };
    let cloth = spawn(&mut app, (sheet(), soon, level));
    let own = ClothSelfCollision::default();
    type Change = fn(&mut EntityWorldMut, ClothSelfCollision);
    let changes: [(&str, Change); 3] = [
        ("added", |cloth, own| _ = cloth.insert(own)),
        ("changed", |cloth, own| _ = cloth.insert(ClothSelfCollision { friction: 0.1, ..own })),
        ("removed", |cloth, _| _ = cloth.remove::<ClothSelfCollision>()),
    ];
    for (what, change) in changes {
        until_asleep(&mut app, cloth, 400);
        change(&mut app.world_mut().entity_mut(cloth), own);
        app.update();
        assert!(!simulation(&app, cloth).is_asleep(), "{what}");
    }
    // The same again is no change.
    until_asleep(&mut app, cloth, 400);
    app.world_mut().entity_mut(cloth).remove::<ClothSelfCollision>();
    app.update();
    assert!(simulation(&app, cloth).is_asleep());
}

#[test]
fn what_is_refused_is_told_until_it_is_mended() {
    let (mut app, good) = heap();
    let cloth = spawn(&mut app, (towel(), ClothSelfCollision::default()));
    updates(&mut app, 3);
    let is_told = |app: &App| match failure(app, cloth) {
        None => None,
        Some(ClothError { entity, kind: ClothErrorKind::Parameter { component, problem } }) => {
            assert_eq!((entity, component), (cloth, ClothComponent::ClothSelfCollision));
            Some(problem.name)
        }
        Some(other) => panic!("{other}"),
    };
    let spacing = 0.6 / (PARTICLES - 1) as f32;
    let wide = ClothSelfCollision { distance: Some(1.2 * spacing), ..default() };
    app.world_mut().entity_mut(cloth).insert(wide);
    updates(&mut app, 30);
    assert_eq!(is_told(&app), Some("distance"));
    // The last good numbers stay, and the other cloth has not noticed.
    assert_eq!(bits(&app, cloth), bits(&app, good));
    app.world_mut()
        .entity_mut(cloth)
        .insert(ClothSelfCollision { friction: f32::NAN, ..default() });
    updates(&mut app, 2);
    assert_eq!(is_told(&app), Some("friction"));
    app.world_mut().entity_mut(cloth).insert(ClothSelfCollision::default());
    app.update();
    assert_eq!(is_told(&app), None);
    assert_eq!(bits(&app, cloth), bits(&app, good));
    // A coarser cloth allows more.
    app.world_mut().entity_mut(cloth).insert(wide);
    app.update();
    assert_eq!(is_told(&app), Some("distance"));
    app.world_mut()
        .entity_mut(cloth)
        .insert(Cloth::sheet(Vec2::splat(0.6), UVec2::splat(PARTICLES / 2)));
    updates(&mut app, 2);
    assert_eq!(is_told(&app), None);
    assert!(layers(&app, cloth) > 0);
    // What is bad from the start is left out alone, and its error goes with it.
    let early = spawn(&mut app, (towel(), wide));
    updates(&mut app, 5);
    assert!(failure(&app, early).is_some());
    assert_eq!((simulation(&app, early).tick_count(), layers(&app, early)), (5, 0));
    app.world_mut().entity_mut(early).remove::<ClothSelfCollision>();
    app.update();
    assert_eq!(failure(&app, early), None);
}

#[test]
fn a_heap_that_is_saved_goes_on_with_the_same_bits() {
    // Also into a cloth of another size, which becomes that of the one that was saved.
    for (mesh, scale) in [(false, 1.0), (true, 1.0), (false, 0.7)] {
        let what = format!("mesh {mesh}, scale {scale}");
        let build = |others: usize, scale: f32| {
            let mut app = app();
            for _ in 0..others {
                spawn(&mut app, Name::new("another"));
            }
            let floor = floor(&mut app);
            let cloth = spawn(&mut app, (towel(), ClothSelfCollision::default()));
            if mesh {
                let mesh = Mesh3d(add_mesh(&mut app, mesh_without(PARTICLES, [4, 7])));
                app.world_mut().entity_mut(cloth).insert((Cloth::of_mesh3d(), mesh));
            }
            transform(&mut app, cloth).scale = Vec3::splat(scale);
            transform(&mut app, cloth).translation.y *= if mesh { 1.6 } else { 1.0 };
            (app, floor, cloth)
        };
        let (mut one, floor, cloth) = build(0, scale);
        let ticks = (0..150).find(|_| {
            one.update();
            touching(&one, cloth) > 20
        });
        assert!(ticks.is_some(), "{what}: layers touch");
        let (mut other, other_floor, other_cloth) = build(3, 1.0);
        if scale != 1.0 {
            // It is set up in another size.
            other.update();
        }
        let state = ClothSnapshot::of(one.world().entity(cloth)).unwrap();
        other.world_mut().entity_mut(other_cloth).insert(state);
        let state = SdfColliderSnapshot::of(one.world().entity(floor)).unwrap();
        other.world_mut().entity_mut(other_floor).insert(state);
        *transform(&mut other, other_cloth) = *transform(&mut one, cloth);
        for tick in 0..30 {
            one.update();
            other.update();
            assert!(bits(&one, cloth) == bits(&other, other_cloth), "{what}, after {tick}");
            assert_eq!(touching(&one, cloth), touching(&other, other_cloth), "{what}");
        }
        assert!(touching(&one, cloth) > 0, "{what}");
        assert_eq!((failure(&one, cloth), failure(&other, other_cloth)), (None, None));
    }
}

#[test]
fn fused_and_staged_are_the_same() {
    let run = |execution| {
        let (mut app, cloth) = heap();
        app.insert_resource(execution);
        updates(&mut app, 60);
        assert!(touching(&app, cloth) > 20);
        bits(&app, cloth)
    };
    assert!(run(ClothExecution::Fused) == run(ClothExecution::Staged));
}

#[test]
fn a_heap_falls_asleep() {
    let (mut app, cloth) = heap();
    until_asleep(&mut app, cloth, 1500);
    assert!(touching(&app, cloth) > 20, "it lies in folds");
    assert_eq!(simulation(&app, cloth).crossings(), 0);
}
