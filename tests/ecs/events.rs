//! Events of a cloth: each is told on its entity, at its moment, once; and who hears of it may do anything,
//! despawning the cloth included.

use crate::support::app::*;
use bevy::{math::bounding::Aabb3d, prelude::*};
use bevy_drape::{
    ClothDiverged, ClothExecution, ClothGravityOverride, ClothSleepThreshold, ClothSlept,
    ClothWoke,
    prelude::*,
    sdf::{SdfSample, SignedDistance},
    solver::SolverError,
};

/// What was told, in order: the event, its cloth, and the ticks that the cloth had taken.
#[derive(Resource, Default)]
struct Told(Vec<(&'static str, Entity, u64)>);

impl Told {
    fn of(app: &App, cloth: Entity) -> Vec<(&'static str, u64)> {
        let told = &app.world().resource::<Self>().0;
        told.iter().filter(|(_, of, _)| *of == cloth).map(|&(what, _, at)| (what, at)).collect()
    }
}

fn note(told: &mut Told, what: &'static str, entity: Entity, cloths: &Query<&ClothSimulation>) {
    let ticks = cloths.get(entity).map(ClothSimulation::tick_count).expect("it is there");
    told.0.push((what, entity, ticks));
}

fn listening() -> App {
    let mut app = app();
    app.init_resource::<Told>()
        .add_observer(
            |it: On<ClothReady>, mut told: ResMut<Told>, cloths: Query<&ClothSimulation>| {
                note(&mut told, "ready", it.entity, &cloths);
            },
        )
        .add_observer(
            |it: On<ClothSlept>, mut told: ResMut<Told>, cloths: Query<&ClothSimulation>| {
                assert!(cloths.get(it.entity).unwrap().is_asleep());
                note(&mut told, "slept", it.entity, &cloths);
            },
        )
        .add_observer(
            |it: On<ClothWoke>, mut told: ResMut<Told>, cloths: Query<&ClothSimulation>| {
                assert!(!cloths.get(it.entity).unwrap().is_asleep());
                note(&mut told, "woke", it.entity, &cloths);
            },
        )
        .add_observer(
            |it: On<ClothDiverged>,
             mut told: ResMut<Told>,
             cloths: Query<&ClothSimulation>,
             failures: Query<&ClothFailure>| {
                assert_eq!(it.problem, SolverError::Diverged);
                assert!(failures.contains(it.entity), "the failure is there by then");
                note(&mut told, "diverged", it.entity, &cloths);
            },
        );
    app
}

#[test]
fn a_cloth_is_ready_once_and_once_more_when_it_starts_anew() {
    let mut app = listening();
    let cloth = spawn(&mut app, sheet());
    let later = spawn(&mut app, (Cloth::of_mesh3d(), Mesh3d::default()));
    app.update();
    assert_eq!(Told::of(&app, cloth), [("ready", 0)]);
    assert_eq!(Told::of(&app, later), [], "its mesh is not there yet");
    let mesh = grid_mesh(3, 3, |v| v, |r, c| Vec3::new(c as f32, 0.0, r as f32));
    let mesh = add_mesh(&mut app, mesh);
    app.world_mut().entity_mut(later).insert(Mesh3d(mesh));
    updates(&mut app, 10);
    assert_eq!(Told::of(&app, later).len(), 1);
    // Changes that a running cloth follows start nothing anew.
    app.world_mut().get_mut::<ClothMaterial>(cloth).unwrap().drag = 1.0;
    app.world_mut().trigger(ResetCloth { entity: cloth });
    updates(&mut app, 5);
    assert_eq!(Told::of(&app, cloth), [("ready", 0)]);
    *app.world_mut().get_mut::<Cloth>(cloth).unwrap() = Cloth::sheet(Vec2::ONE, UVec2::splat(5));
    updates(&mut app, 5);
    assert_eq!(Told::of(&app, cloth), [("ready", 0); 2]);
    app.world_mut().entity_mut(cloth).remove::<ClothSimulation>();
    updates(&mut app, 5);
    assert_eq!(Told::of(&app, cloth), [("ready", 0); 3]);
}

#[test]
fn what_is_moved_before_its_first_tick_is_ready_once() {
    let mut app = listening();
    let cloth = spawn(&mut app, sheet());
    // Frames without ticks, in which it is set up and seen.
    set_frame(&mut app, TICK / 8);
    for _ in 0..4 {
        transform(&mut app, cloth).translation.y += 1.0;
        app.update();
    }
    assert_eq!(simulation(&app, cloth).tick_count(), 0);
    set_frame(&mut app, TICK);
    updates(&mut app, 3);
    assert_eq!(Told::of(&app, cloth), [("ready", 0)]);
}

#[test]
fn what_is_hung_is_ready_when_it_hangs() {
    let mut app = listening();
    let mut ring = |x| spawn(&mut app, Transform::from_xyz(x, 2.0, 0.0));
    let (left, right) = (ring(-0.4), ring(0.4));
    let pins =
        ClothPins::vertices([0]).anchored_to(left).and(ClothPins::vertices([7]).anchored_to(right));
    let cloth = spawn(&mut app, (sheet(), pins, HangOnStart::default()));
    app.update();
    // As soon as it is told, it is at rest where it hangs.
    wait(&mut app, |app| !Told::of(app, cloth).is_empty());
    assert!(simulation(&app, cloth).hung().is_some());
    updates(&mut app, 20);
    assert_eq!(Told::of(&app, cloth), [("ready", 0)]);
}

#[test]
fn sleep_and_waking_are_told_in_turns() {
    let mut app = listening();
    let still =
        (sheet(), ClothGravityOverride(Vec3::ZERO), ClothSleepThreshold { time: 0.1, ..default() });
    let cloth = spawn(&mut app, still);
    let other = spawn(&mut app, sheet());
    updates(&mut app, 30);
    let ticks = simulation(&app, cloth).tick_count();
    assert_eq!(Told::of(&app, cloth), [("ready", 0), ("slept", ticks)]);
    app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap().wake();
    app.update();
    assert_eq!(Told::of(&app, cloth)[2..], [("woke", ticks)]);
    updates(&mut app, 30);
    let later = simulation(&app, cloth).tick_count();
    assert_eq!(Told::of(&app, cloth)[3..], [("slept", later)]);
    assert_eq!(Told::of(&app, other).len(), 1, "it falls and falls");
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

fn rotten(app: &mut App) -> Entity {
    spawn(app, SdfCollider::custom(Rotten))
}

#[test]
fn a_cloth_that_diverges_says_so_once_each_time() {
    let mut app = listening();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 3);
    let cause = rotten(&mut app);
    updates(&mut app, 5);
    assert!(simulation(&app, cloth).is_quarantined());
    assert_eq!(Told::of(&app, cloth), [("ready", 0), ("diverged", 3)]);
    app.world_mut().trigger(ResetCloth { entity: cloth });
    updates(&mut app, 5);
    assert_eq!(Told::of(&app, cloth)[2..], [("diverged", 3)], "once more, as nothing is mended");
    app.world_mut().despawn(cause);
    app.world_mut().trigger(ResetCloth { entity: cloth });
    updates(&mut app, 5);
    assert_eq!(Told::of(&app, cloth).len(), 3);
    assert_eq!(simulation(&app, cloth).tick_count(), 8);
}

#[test]
fn who_hears_of_it_may_despawn_the_cloth() {
    fn despawn<E: EntityEvent>(it: On<E>, mut commands: Commands) {
        commands.entity(it.event_target()).despawn();
    }
    for staged in [ClothExecution::Fused, ClothExecution::Staged] {
        let mut app = app();
        app.insert_resource(staged);
        let other = spawn(&mut app, (sheet(), ClothSettings { layers: 0.into(), ..default() }));
        let still = (
            sheet(),
            ClothGravityOverride(Vec3::ZERO),
            ClothSleepThreshold { time: 0.1, ..default() },
        );
        let cloth = |app: &mut App| spawn(app, still);
        let ready = cloth(&mut app);
        app.world_mut().entity_mut(ready).observe(despawn::<ClothReady>);
        let slept = cloth(&mut app);
        app.world_mut().entity_mut(slept).observe(despawn::<ClothSlept>);
        let woke = cloth(&mut app);
        app.world_mut().entity_mut(woke).observe(despawn::<ClothWoke>);
        let diverged = spawn(&mut app, sheet());
        app.world_mut().entity_mut(diverged).observe(despawn::<ClothDiverged>);
        updates(&mut app, 30);
        let is_there = |app: &App, entity| app.world().get_entity(entity).is_ok();
        assert!(!is_there(&app, ready) && !is_there(&app, slept));
        assert!(is_there(&app, woke) && is_there(&app, diverged));
        app.world_mut().get_mut::<ClothSimulation>(woke).unwrap().wake();
        app.update();
        assert!(!is_there(&app, woke));
        rotten(&mut app);
        updates(&mut app, 2);
        assert!(!is_there(&app, diverged));
        assert_eq!(simulation(&app, other).tick_count(), 33, "it goes on");
    }
}
