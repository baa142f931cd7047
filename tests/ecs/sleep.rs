//! Sleep and freezing: a cloth that cannot be moved by anything keeps its bits, and every cause that
//! could move it wakes it.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    ClothAir, ClothGravityOverride, ClothPaused, ClothSleepThreshold, SdfColliderDisabled,
    prelude::*,
};

/// Air so thick that a cloth is soon at rest.
fn thick() -> ClothMaterial {
    ClothMaterial { drag: 12.0, ..default() }
}

fn asleep(app: &App, cloth: Entity) -> bool {
    simulation(app, cloth).is_asleep()
}

#[track_caller]
fn until_asleep(app: &mut App, cloth: Entity, most: usize) -> usize {
    for tick in 0..most {
        app.update();
        if asleep(app, cloth) {
            return tick;
        }
    }
    panic!("awake after {most} ticks: {:?} m", simulation(app, cloth).last_tick());
}

/// A cloth over a ball, with one more ball far away, one switched off, and an anchor.
struct Scene {
    app: App,
    cloth: Entity,
    ball: Entity,
    far: Entity,
    off: Entity,
    anchor: Entity,
}

fn scene() -> Scene {
    let mut app = app();
    let ball = spawn(&mut app, SdfCollider::from(Sphere::new(0.3)).with_friction(0.9));
    let far = (SdfCollider::from(Sphere::new(0.3)), Transform::from_xyz(9.0, 0.0, 0.0));
    let far = spawn(&mut app, far);
    let off = (SdfCollider::from(Sphere::new(0.3)), Transform::from_xyz(0.4, 0.0, 0.0));
    let off = spawn(&mut app, (off, SdfColliderDisabled));
    let anchor = spawn(&mut app, Transform::from_xyz(0.0, 0.6, 0.0));
    let pins = ClothPins::vertices([0]).and(ClothPins::vertices([7]).anchored_to(anchor));
    let cloth = (sheet(), thick(), pins, Transform::from_xyz(0.0, 0.32, 0.0));
    let cloth = spawn(&mut app, cloth);
    Scene { app, cloth, ball, far, off, anchor }
}

#[test]
fn a_draped_cloth_goes_to_sleep_and_keeps_its_bits() {
    let mut scene = scene();
    let ticks = until_asleep(&mut scene.app, scene.cloth, 1500);
    assert!(ticks > 64, "not before the time is up");
    scene.app.update();
    let count = simulation(&scene.app, scene.cloth).tick_count();
    let (at_rest, drawn) =
        (bits(&scene.app, scene.cloth), drawn_positions(&scene.app, scene.cloth));
    let mesh = scene.app.world().get::<Mesh3d>(scene.cloth).unwrap().id();
    scene.app.world_mut().resource_mut::<Messages<AssetEvent<Mesh>>>().clear();
    for _ in 0..50 {
        scene.app.update();
        let events = scene.app.world().resource::<Messages<AssetEvent<Mesh>>>();
        let written = |event: &&AssetEvent<Mesh>| event.is_modified(mesh);
        assert_eq!(events.iter_current_update_messages().filter(written).count(), 0);
    }
    assert_eq!(simulation(&scene.app, scene.cloth).tick_count(), count);
    assert_eq!(bits(&scene.app, scene.cloth), at_rest);
    assert_eq!(drawn_positions(&scene.app, scene.cloth), drawn);
}

#[test]
fn the_usual_cloth_sleeps_too_and_so_does_what_trembles_on_the_spot() {
    let light = ClothMaterial { damping: 0.002, drag: 1.0, ..default() };
    for (what, side, material, pins, height) in [
        ("draped", 24, ClothMaterial::default(), ClothPins::none(), 0.32),
        ("hanging", 24, light, ClothPins::from(PinSelection::FirstRow), 5.0),
        // A corner that carries a quarter of the sheet: its springs come to their limit in turns.
        ("trembling", 48, light, ClothPins::from(PinSelection::Corners), 5.0),
    ] {
        let mut app = app();
        spawn(&mut app, SdfCollider::from(Sphere::new(0.3)));
        spawn(&mut app, SdfCollider::from(InfinitePlane3d::default()));
        let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(side));
        let place = Transform::from_xyz(0.0, height, 0.0);
        let cloth = spawn(&mut app, (cloth, material, pins, place));
        let ticks = until_asleep(&mut app, cloth, 64 * 25);
        assert!(ticks > 64, "{what}: {ticks}");
    }
}

#[test]
fn a_pendulum_does_not_sleep_where_it_turns() {
    let mut app = app();
    let material = ClothMaterial { drag: 0.0, ..default() };
    let pins = ClothPins::from(PinSelection::FirstRow);
    let cloth = spawn(&mut app, (sheet(), material, pins));
    for _ in 0..64 * 12 {
        app.update();
        assert!(!asleep(&app, cloth));
    }
}

#[test]
fn every_cause_wakes() {
    type Act = fn(&mut Scene);
    let causes: [(&str, Act); 20] = [
        ("gravity", |s| s.app.world_mut().resource_mut::<ClothGravity>().0.x = 0.1),
        ("own gravity", |s| {
            s.app.world_mut().entity_mut(s.cloth).insert(ClothGravityOverride(Vec3::X));
        }),
        ("material", |s| {
            s.app.world_mut().get_mut::<ClothMaterial>(s.cloth).unwrap().friction = 0.1;
        }),
        ("settings", |s| {
            s.app.world_mut().get_mut::<ClothSettings>(s.cloth).unwrap().provot_passes = 3;
        }),
        ("released pins", |s| {
            *s.app.world_mut().get_mut::<ClothPins>(s.cloth).unwrap() = ClothPins::none();
        }),
        ("more pins", |s| {
            let more = ClothPins::vertices([60]);
            let pins = s.app.world().get::<ClothPins>(s.cloth).unwrap().clone();
            *s.app.world_mut().get_mut::<ClothPins>(s.cloth).unwrap() = pins.and(more);
        }),
        ("its entity moves", |s| transform(&mut s.app, s.cloth).translation.x += 0.001),
        ("an anchor moves", |s| transform(&mut s.app, s.anchor).translation.x += 0.001),
        ("an anchor goes", |s| _ = s.app.world_mut().despawn(s.anchor)),
        ("teleport", |s| transform(&mut s.app, s.cloth).translation.x += 50.0),
        ("reset", |s| {
            let entity = s.cloth;
            s.app.world_mut().trigger(ResetCloth { entity });
        }),
        ("a collider moves", |s| transform(&mut s.app, s.ball).translation.y -= 0.001),
        ("a collider goes", |s| _ = s.app.world_mut().despawn(s.ball)),
        ("a collider is no longer one", |s| {
            s.app.world_mut().entity_mut(s.ball).remove::<SdfCollider>();
        }),
        ("a collider is switched off", |s| {
            s.app.world_mut().entity_mut(s.ball).insert(SdfColliderDisabled);
        }),
        ("a collider is switched on", |s| {
            s.app.world_mut().entity_mut(s.off).remove::<SdfColliderDisabled>();
        }),
        ("a collider has another shape", |s| {
            let mut collider = s.app.world_mut().get_mut::<SdfCollider>(s.ball).unwrap();
            collider.shape = Sphere::new(0.28).into();
        }),
        ("a collider comes", |s| {
            let place = Transform::from_xyz(0.4, 0.0, 0.0);
            spawn(&mut s.app, (SdfCollider::from(Cuboid::default()), place));
        }),
        ("a distant collider comes near in one jump", |s| {
            transform(&mut s.app, s.far).translation.x = 0.5;
        }),
        ("being told", |s| {
            s.app.world_mut().get_mut::<ClothSimulation>(s.cloth).unwrap().wake();
        }),
    ];
    let mut settled = scene();
    until_asleep(&mut settled.app, settled.cloth, 1500);
    for (cause, act) in causes {
        let mut scene = scene();
        until_asleep(&mut scene.app, scene.cloth, 1500);
        updates(&mut scene.app, 5);
        let count = simulation(&scene.app, scene.cloth).tick_count();
        act(&mut scene);
        scene.app.update();
        assert_eq!(simulation(&scene.app, scene.cloth).tick_count(), count + 1, "{cause}");
        assert!(!asleep(&scene.app, scene.cloth), "{cause}");
    }
    let mut scene = scene();
    until_asleep(&mut scene.app, scene.cloth, 1500);
    let mut cloth = scene.app.world_mut().get_mut::<ClothSimulation>(scene.cloth).unwrap();
    cloth.set_velocities(|_| Vec3::Y);
    assert!(!cloth.is_asleep());
    scene.app.update();
    assert!(simulation(&scene.app, scene.cloth).velocity(60).unwrap().y > 0.3);
}

#[test]
fn what_is_far_away_does_not_wake() {
    let mut scene = scene();
    until_asleep(&mut scene.app, scene.cloth, 1500);
    updates(&mut scene.app, 2);
    let count = simulation(&scene.app, scene.cloth).tick_count();
    for i in 0..20 {
        transform(&mut scene.app, scene.far).translation.y = i as f32;
        scene.app.update();
    }
    scene.app.world_mut().despawn(scene.far);
    let another = (SdfCollider::from(Cuboid::default()), Transform::from_xyz(-7.0, 0.0, 0.0));
    spawn(&mut scene.app, another);
    scene.app.update();
    assert_eq!(simulation(&scene.app, scene.cloth).tick_count(), count);
}

#[test]
fn a_cloth_falls_when_what_it_rests_on_goes() {
    for despawned in [true, false] {
        let mut app = app();
        let floor =
            (SdfCollider::from(Cuboid::new(2.0, 1.0, 2.0)), Transform::from_xyz(0.0, -0.5, 0.0));
        let floor = spawn(&mut app, floor);
        let place = Transform::from_xyz(0.0, 0.01, 0.0);
        let cloth = spawn(&mut app, (sheet(), thick(), place));
        until_asleep(&mut app, cloth, 500);
        updates(&mut app, 3);
        if despawned {
            app.world_mut().despawn(floor);
        } else {
            app.world_mut().entity_mut(floor).insert(SdfColliderDisabled);
        }
        updates(&mut app, 40);
        assert!(position(&app, cloth, 0).y < -0.1);
    }
}

#[test]
fn sleep_does_not_depend_on_the_frame_rate() {
    let run = |strategy: TimeUpdateStrategy| {
        let mut scene = scene();
        scene.app.insert_resource(strategy);
        until_asleep(&mut scene.app, scene.cloth, 4000);
        (simulation(&scene.app, scene.cloth).tick_count(), bits(&scene.app, scene.cloth))
    };
    let one = run(TimeUpdateStrategy::FixedTimesteps(1));
    assert_eq!(one, run(TimeUpdateStrategy::FixedTimesteps(3)));
    assert_eq!(one, run(TimeUpdateStrategy::ManualDuration(TICK / 5 * 2)));
}

#[test]
fn a_pin_that_holds_nothing_wakes_a_cloth_once_whatever_the_frame_rate() {
    let sleeps_after = |frames: u32| {
        let mut app = app();
        let at_once = ClothSleepThreshold { distance: 0.1, time: 0.0 };
        let cloth = (sheet(), ClothPins::vertices([]), at_once, Transform::default());
        let cloth = spawn(&mut app, cloth);
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
        updates(&mut app, frames as usize);
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        updates(&mut app, 5);
        assert!(failure(&app, cloth).is_some() && asleep(&app, cloth));
        simulation(&app, cloth).tick_count()
    };
    assert_eq!([0, 1, 2].map(sleeps_after), [1; 3]);
}

#[test]
fn a_cloth_that_is_never_to_sleep_does_not() {
    let mut scene = scene();
    scene.app.world_mut().entity_mut(scene.cloth).insert(ClothSleepThreshold::NEVER);
    updates(&mut scene.app, 600);
    assert_eq!(simulation(&scene.app, scene.cloth).tick_count(), 600);
}

fn swinging(app: &mut App) -> Entity {
    let cloth = spawn(app, (sheet(), ClothPins::from(PinSelection::FirstRow)));
    updates(app, 25);
    cloth
}

#[test]
fn a_frozen_cloth_stands_and_goes_on_as_if_nothing_had_been() {
    let (mut app, mut other) = (app(), app());
    let (cloth, twin) = (swinging(&mut app), swinging(&mut other));
    let before = bits(&app, cloth);
    assert_eq!(before, bits(&other, twin));
    app.world_mut().entity_mut(cloth).insert(ClothPaused::default());
    // Frames between ticks, so that a blend would show.
    set_frame(&mut app, TICK / 5 * 2);
    updates(&mut app, 5);
    let drawn = drawn_positions(&app, cloth);
    for _ in 0..20 {
        app.update();
        assert_eq!(bits(&app, cloth), before);
        assert_eq!(drawn_positions(&app, cloth), drawn);
    }
    app.world_mut().entity_mut(cloth).remove::<ClothPaused>();
    let count = simulation(&app, cloth).tick_count();
    while simulation(&app, cloth).tick_count() < count + 10 {
        app.update();
    }
    updates(&mut other, 10);
    assert_eq!(bits(&app, cloth), bits(&other, twin));
}

#[test]
fn a_frozen_cloth_takes_single_steps() {
    let (mut app, mut other) = (app(), app());
    let (cloth, twin) = (swinging(&mut app), swinging(&mut other));
    app.world_mut().entity_mut(cloth).insert(ClothPaused::default());
    updates(&mut app, 3);
    for steps in [1, 1, 3] {
        app.world_mut().get_mut::<ClothPaused>(cloth).unwrap().steps = steps;
        updates(&mut app, 6);
        assert_eq!(app.world().get::<ClothPaused>(cloth).unwrap().steps, 0);
    }
    updates(&mut other, 5);
    assert_eq!(bits(&app, cloth), bits(&other, twin));
}

#[test]
fn a_frozen_cloth_is_carried_by_its_entity() {
    let mut app = app();
    let cloth = swinging(&mut app);
    app.world_mut().entity_mut(cloth).insert(ClothPaused::default());
    app.update();
    let before = positions(&app, cloth);
    let pose = Transform::from_xyz(1.0, 0.0, 0.5).with_rotation(Quat::from_rotation_y(0.8));
    for part in 1..=20 {
        let part = part as f32 / 20.0;
        *transform(&mut app, cloth) = Transform::IDENTITY
            .with_translation(pose.translation * part)
            .with_rotation(Quat::from_rotation_y(0.8 * part));
        app.update();
    }
    for (a, b) in positions(&app, cloth).iter().zip(&before) {
        assert!(a.distance(pose.transform_point(*b)) < 1e-5);
    }
    for (drawn, place) in drawn_positions(&app, cloth).iter().zip(positions(&app, cloth)) {
        assert!(drawn.distance(place) < 1e-5);
    }
    app.world_mut().entity_mut(cloth).remove::<ClothPaused>();
    app.update();
    let after = simulation(&app, cloth).velocity(60).unwrap();
    // As it would have gone on.
    let mut other = self::app();
    let twin = swinging(&mut other);
    other.update();
    let expected = pose.rotation * simulation(&other, twin).velocity(60).unwrap();
    assert!(after.distance(expected) < 0.01, "{after} {expected}");
    assert!(simulation(&app, cloth).strain().max < 0.02);
}

#[test]
fn what_sleeps_has_no_velocity() {
    let mut app = app();
    let pins = ClothPins::from(PinSelection::FirstRow);
    let cloth = spawn(&mut app, (sheet(), thick(), pins));
    until_asleep(&mut app, cloth, 900);
    let count = simulation(&app, cloth).particle_count();
    for particle in 0..count {
        assert_eq!(simulation(&app, cloth).velocity(particle), Some(Vec3::ZERO));
    }
}

/// A cloth that hardly moves is braked beside one that never sleeps, and only where nothing else moves it: elsewhere both have the same
/// bits.
#[test]
fn what_hardly_moves_is_braked_unless_something_leads_it_or_it_has_no_drag() {
    let swing = |never: bool, material: ClothMaterial, air: bool, is_led: bool| {
        let mut app = app();
        let hand = spawn(&mut app, Transform::default());
        let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(hand);
        let upright = Transform::from_rotation(Quat::from_rotation_x(1.6));
        let cloth = spawn(&mut app, (sheet(), pins, material, upright));
        if never {
            app.world_mut().entity_mut(cloth).insert(ClothSleepThreshold::NEVER);
        }
        if air {
            app.world_mut().entity_mut(cloth).insert(ClothAir::default());
        }
        for tick in 0..40 {
            if is_led {
                transform(&mut app, hand).translation.x = 1e-4 * tick as f32;
            }
            app.update();
            assert!(!asleep(&app, cloth));
        }
        bits(&app, cloth)
    };
    let usual = ClothMaterial::default();
    let undamped = ClothMaterial { drag: 0.0, ..usual };
    for (what, material, air, is_led) in [
        ("without drag", undamped, false, false),
        ("in air", usual, true, false),
        ("led", usual, false, true),
    ] {
        let [braked, free] = [false, true].map(|never| swing(never, material, air, is_led));
        assert_eq!(braked, free, "{what}");
    }
    assert_ne!(swing(false, usual, false, false), swing(true, usual, false, false));
}

/// What is written anew each frame, as by an editor, and is the same.
#[test]
fn a_collider_that_is_written_anew_and_is_the_same_wakes_nothing() {
    let mut scene = scene();
    let ball = SdfCollider::from(Sphere::new(0.3)).with_friction(0.9);
    // It fills the same box.
    let cube = SdfCollider::from(Cuboid::from_length(0.6)).with_friction(0.9);
    let mut write = |solid: &SdfCollider| {
        scene.app.world_mut().entity_mut(scene.ball).insert(solid.clone());
        scene.app.update();
        asleep(&scene.app, scene.cloth)
    };
    assert!((0..1500).any(|_| write(&ball)), "awake");
    assert!(write(&ball));
    assert!(!write(&cube));
}
