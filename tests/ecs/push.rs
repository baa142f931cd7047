//! Pushes from a game, held to closed forms (`v = J / m`, `v = F t / m`), to momentum, and to bit equality
//! between frame rates and forms; and that what cannot be pushed is told to its own entity alone.

use std::sync::atomic::Ordering;

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    ClothError, ClothErrorKind, ClothExecution, ClothForce, ClothForces, ClothGravityOverride,
    ClothInertia, ClothPaused, ClothSleepThreshold, PushCloth,
    prelude::*,
    solver::{PushOn, PushWith, SolverError},
};

/// Nothing but what pushes it moves it.
fn adrift() -> impl Bundle {
    let material = ClothMaterial { drag: 0.0, ..default() };
    (sheet(), material, ClothGravityOverride(Vec3::ZERO), ClothSleepThreshold::NEVER)
}

fn mass(cloth: &ClothSimulation) -> f32 {
    (0..cloth.particle_count()).filter_map(|i| cloth.mass(i)).sum()
}

fn momentum(app: &App, cloth: Entity) -> Vec3 {
    let cloth = simulation(app, cloth);
    let of = |i| Some(cloth.velocity(i)? * cloth.mass(i)?);
    (0..cloth.particle_count()).filter_map(of).sum()
}

fn push(app: &mut App, cloth: Entity, on: PushOn, with: PushWith) -> Result<(), SolverError> {
    app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap().push(on, with)
}

#[test]
fn a_push_acts_in_the_next_tick_exactly_once() {
    let impulse = Vec3::new(0.01, 0.02, -0.01);
    for with in [PushWith::Impulse(impulse), PushWith::Force(impulse / TICK.as_secs_f32())] {
        // One frame a tick, many, and many ticks a frame.
        for strategy in [
            TimeUpdateStrategy::FixedTimesteps(1),
            TimeUpdateStrategy::FixedTimesteps(3),
            TimeUpdateStrategy::ManualDuration(TICK / 5),
        ] {
            let mut app = app();
            let cloth = spawn(&mut app, adrift());
            updates(&mut app, 2);
            app.insert_resource(strategy);
            push(&mut app, cloth, PushOn::All, with).unwrap();
            assert!(momentum(&app, cloth).length() < 1e-9, "not before the tick");
            let ticks = simulation(&app, cloth).tick_count();
            while simulation(&app, cloth).tick_count() < ticks + 4 {
                app.update();
            }
            let error = momentum(&app, cloth).distance(impulse);
            assert!(error < 1e-6, "{with:?}: {error}");
        }
    }
}

#[test]
fn particles_and_balls_are_pushed_by_name_and_by_place() {
    let mut app = app();
    let cloth = spawn(&mut app, (adrift(), Transform::from_xyz(5.0, 1.0, 0.0)));
    updates(&mut app, 2);
    push(&mut app, cloth, PushOn::Particle(9), PushWith::Velocity(Vec3::Y)).unwrap();
    let corner = position(&app, cloth, 63);
    let ball = PushOn::Within { centre: corner, radius: 0.01, falloff: 0.0 };
    push(&mut app, cloth, ball, PushWith::Velocity(Vec3::NEG_Y)).unwrap();
    let before = positions(&app, cloth);
    app.update();
    for (i, (now, before)) in positions(&app, cloth).iter().zip(&before).enumerate() {
        let up = now.y - before.y;
        assert_eq!((up > 1e-3, up < -1e-3), (i == 9, i == 63), "{i}: {up}");
    }
}

#[test]
fn forces_that_go_on_are_the_same_at_any_frame_rate_and_in_both_forms() {
    let run = |strategy: TimeUpdateStrategy, execution| {
        let mut app = app();
        app.insert_resource(execution);
        let all = ClothForce { on: PushOn::All, force: Vec3::new(0.1, 0.2, 0.0) };
        let ball = PushOn::Within { centre: Vec3::X * 0.3, radius: 0.4, falloff: 0.2 };
        let forces = vec![all, ClothForce { on: ball, force: Vec3::Z * 0.02 }];
        let cloth = spawn(&mut app, (adrift(), ClothForces { forces }));
        app.update();
        app.insert_resource(strategy);
        while simulation(&app, cloth).tick_count() < 30 {
            app.update();
        }
        assert_eq!(simulation(&app, cloth).tick_count(), 30);
        bits(&app, cloth)
    };
    let reference = run(TimeUpdateStrategy::FixedTimesteps(1), ClothExecution::Fused);
    let every = [
        (TimeUpdateStrategy::FixedTimesteps(1), ClothExecution::Staged),
        (TimeUpdateStrategy::ManualDuration(TICK / 5 * 2), ClothExecution::Fused),
    ];
    for (strategy, execution) in every {
        assert_eq!(run(strategy, execution), reference, "{execution:?}");
    }
}

#[test]
fn forces_that_go_on_end_when_they_are_taken_away() {
    let mut app = app();
    let force = Vec3::new(0.1, 0.3, -0.2);
    let forces = ClothForces::from(ClothForce { on: PushOn::All, force });
    let cloth = spawn(&mut app, (adrift(), forces));
    updates(&mut app, 21);
    let ticks = simulation(&app, cloth).tick_count() as f32;
    let expected = force * ticks * TICK.as_secs_f32();
    assert!(momentum(&app, cloth).distance(expected) < 1e-5);
    app.world_mut().entity_mut(cloth).remove::<ClothForces>();
    updates(&mut app, 10);
    assert!(momentum(&app, cloth).distance(expected) < 1e-5);
    let v = expected / mass(simulation(&app, cloth));
    assert!(simulation(&app, cloth).velocity(20).unwrap().distance(v) < 1e-3);
}

#[test]
fn pushes_wake_and_pins_hold() {
    type Act = fn(&mut App, Entity);
    let acts: [(&str, Act); 3] = [
        ("push", |app, cloth| {
            push(app, cloth, PushOn::All, PushWith::Velocity(Vec3::X * 0.1)).unwrap();
        }),
        ("event", |app, entity| {
            let (on, with) = (PushOn::Particle(60), PushWith::Impulse(Vec3::X * 0.001));
            app.world_mut().trigger(PushCloth { entity, on, with });
        }),
        ("forces", |app, cloth| {
            let forces = ClothForces::from(ClothForce { on: PushOn::All, force: Vec3::X });
            app.world_mut().entity_mut(cloth).insert(forces);
        }),
    ];
    for (what, act) in acts {
        let mut app = app();
        let still = (sheet(), ClothGravityOverride(Vec3::ZERO), ClothPins::vertices([0, 7]));
        let cloth = spawn(&mut app, (still, ClothSleepThreshold { time: 0.1, ..default() }));
        updates(&mut app, 20);
        assert!(simulation(&app, cloth).is_asleep());
        let (before, ticks) = (positions(&app, cloth), simulation(&app, cloth).tick_count());
        act(&mut app, cloth);
        app.update();
        assert_eq!(simulation(&app, cloth).tick_count(), ticks + 1, "{what}");
        let now = positions(&app, cloth);
        assert_eq!((now[0], now[7]), (before[0], before[7]), "{what}");
        assert!(now[60].x > before[60].x + 1e-4, "{what}");
    }
}

#[test]
fn a_force_that_stays_lets_a_cloth_sleep_and_one_that_changes_wakes_it() {
    let mut app = app();
    let pins = ClothPins::from(PinSelection::FirstRow);
    let material = ClothMaterial { drag: 12.0, ..default() };
    let forces = ClothForces::from(ClothForce { on: PushOn::All, force: Vec3::X });
    let cloth = spawn(&mut app, (sheet(), pins, material, forces));
    let asleep = |app: &App| simulation(app, cloth).is_asleep();
    (0..1500).find(|_| {
        app.update();
        asleep(&app)
    });
    assert!(asleep(&app));
    app.world_mut().get_mut::<ClothForces>(cloth).unwrap().forces[0].force.x = 2.0;
    app.update();
    assert!(!asleep(&app));
    (0..1500).find(|_| {
        app.update();
        asleep(&app)
    });
    app.world_mut().entity_mut(cloth).remove::<ClothForces>();
    app.update();
    assert!(!asleep(&app));
}

#[test]
fn what_stands_is_not_pushed_nor_later() {
    let mut app = app();
    let cloth = spawn(&mut app, adrift());
    let twin = spawn(&mut app, adrift());
    updates(&mut app, 3);
    app.world_mut().entity_mut(cloth).insert(ClothPaused::default());
    app.world_mut().entity_mut(twin).insert(ClothPaused::default());
    for _ in 0..10 {
        push(&mut app, cloth, PushOn::All, PushWith::Velocity(Vec3::X)).unwrap();
        push(&mut app, cloth, PushOn::All, PushWith::Force(Vec3::X)).unwrap();
        app.update();
    }
    app.world_mut().entity_mut(cloth).remove::<ClothPaused>();
    app.world_mut().entity_mut(twin).remove::<ClothPaused>();
    updates(&mut app, 5);
    assert_eq!(bits(&app, cloth), bits(&app, twin));
}

#[test]
fn a_cloth_that_rides_along_is_pushed_in_the_directions_of_the_world() {
    let mut app = app();
    // Threads that hardly pull.
    let material = ClothMaterial {
        thread_stiffness: 1e-3,
        shear_stiffness: 0.0,
        flexural_rigidity: 0.0,
        drag: 0.0,
        max_strain: 10.0,
        ..default()
    };
    let loose = (sheet(), material, ClothGravityOverride(Vec3::ZERO), ClothInertia::new(0.0));
    let cloth = spawn(&mut app, loose);
    let twin = spawn(&mut app, loose);
    updates(&mut app, 2);
    let turn = |app: &mut App| {
        for entity in [cloth, twin] {
            transform(app, entity).rotate_y(0.9);
        }
        app.update();
    };
    turn(&mut app);
    push(&mut app, cloth, PushOn::Particle(40), PushWith::Velocity(Vec3::X * 2.0)).unwrap();
    turn(&mut app);
    // The ride turns by 0.9 rad in the tick: seen from the world the push is along x at its middle.
    let pushed = position(&app, cloth, 40) - position(&app, twin, 40);
    let direction = pushed.normalize();
    let expected = Quat::from_rotation_y(0.45) * Vec3::X;
    assert!(direction.dot(expected) > 0.995, "{direction} {expected}");
}

#[test]
fn what_cannot_be_pushed_is_told_to_its_own_entity() {
    let mut app = app();
    let cloth = spawn(&mut app, adrift());
    let other = spawn(&mut app, adrift());
    let twin = spawn(&mut app, adrift());
    updates(&mut app, 2);
    let nowhere = Err(SolverError::NoSuchParticle { particle: 64, count: 64 });
    assert_eq!(push(&mut app, cloth, PushOn::Particle(64), PushWith::Force(Vec3::X)), nowhere);
    let nan = PushWith::Velocity(Vec3::NAN);
    let problem = SolverError::Push { what: "velocity" };
    assert_eq!(push(&mut app, cloth, PushOn::All, nan), Err(problem));
    assert_eq!(failure(&app, cloth), None, "who called knows already");
    app.world_mut().trigger(PushCloth { entity: cloth, on: PushOn::All, with: nan });
    app.update();
    assert_eq!(
        failure(&app, cloth),
        Some(ClothError { entity: cloth, kind: ClothErrorKind::Push(problem) })
    );
    assert_eq!(bits(&app, cloth), bits(&app, twin));
    // What is too much for the mass that it meets is only found in the tick.
    let (on, with) = (PushOn::Particle(0), PushWith::Impulse(Vec3::X * 9e6));
    push(&mut app, cloth, on, with).unwrap();
    push(&mut app, other, PushOn::All, PushWith::Velocity(Vec3::X)).unwrap();
    app.update();
    assert!(matches!(failure(&app, cloth), Some(ClothError { kind: ClothErrorKind::Push(_), .. })));
    assert_eq!(bits(&app, cloth), bits(&app, twin));
    assert!(simulation(&app, other).velocity(0).unwrap().x > 0.9);
    // A good one mends it.
    let (on, with) = (PushOn::All, PushWith::Velocity(Vec3::X));
    app.world_mut().trigger(PushCloth { entity: cloth, on, with });
    app.update();
    assert_eq!(failure(&app, cloth), None);
    assert!(simulation(&app, cloth).velocity(0).unwrap().x > 0.9);
    // Of forces that go on, the good ones act.
    let bad = ClothForce { on: PushOn::Particle(99), force: Vec3::X };
    let good = ClothForce { on: PushOn::All, force: Vec3::Y };
    app.world_mut().entity_mut(cloth).insert(ClothForces { forces: vec![bad, good] });
    updates(&mut app, 3);
    let told = failure(&app, cloth);
    assert!(
        matches!(told, Some(ClothError { kind: ClothErrorKind::Forces { force: 0, .. }, .. })),
        "{told:?}"
    );
    assert!(simulation(&app, cloth).velocity(0).unwrap().y > 0.1);
    assert_eq!(failure(&app, other), None);
    // Of several bad ones, the first is told of, and once.
    let told = count_told(&mut app);
    app.world_mut().entity_mut(cloth).insert(ClothForces { forces: vec![bad, bad, good] });
    updates(&mut app, 20);
    assert_eq!(told.load(Ordering::Relaxed), 0);
    app.world_mut().get_mut::<ClothForces>(cloth).unwrap().forces.drain(..2);
    app.update();
    assert_eq!(failure(&app, cloth), None);
    // No cloth at all is no panic.
    let (entity, on) = (spawn(&mut app, Transform::default()), PushOn::All);
    app.world_mut().trigger(PushCloth { entity, on, with });
}
