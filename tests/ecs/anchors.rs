//! Anchors: joints of characters, many on one cloth, hard and soft. Truths: exact places, the parabola
//! of what is let go, and `m g / k`.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    ClothError, ClothErrorKind, ClothExecution, ClothInertia, ClothInterpolation,
    ClothSleepThreshold, prelude::*,
};

/// Turns once a frame, as an animated joint does.
#[derive(Component, Clone, Copy)]
struct Joint(f32);

fn animate(mut joints: Query<(&mut Transform, &Joint)>, mut frame: Local<f32>) {
    *frame += 1.0;
    for (mut transform, joint) in &mut joints {
        transform.rotation = Quat::from_rotation_z(joint.0 * (*frame * 0.1).sin())
            * Quat::from_rotation_y(joint.0 * *frame * 0.03);
    }
}

/// Hips, spine, and two shoulders, which hold half of a cape's upper edge each; all turn.
fn character(app: &mut App, interpolation: ClothInterpolation) -> (Entity, [Entity; 2]) {
    let hips = spawn(app, (Transform::from_xyz(0.3, 1.0, 0.0), Joint(0.2)));
    let spine = spawn(app, (Transform::from_xyz(0.0, 0.5, 0.0), Joint(0.1), ChildOf(hips)));
    let shoulders = [-0.25, 0.25].map(|x| {
        let place = Transform::from_xyz(x, 0.1, 0.0).with_scale(Vec3::splat(1.3));
        spawn(app, (place, Joint(0.05), ChildOf(spine)))
    });
    let pins = ClothPins::vertices([0, 1, 2, 3]).anchored_to(shoulders[0]);
    let pins = pins.and(ClothPins::vertices([4, 5, 6, 7]).anchored_to(shoulders[1]));
    let cape = Cloth::sheet(Vec2::new(0.5, 0.8), UVec2::splat(8));
    let place = Transform::from_xyz(0.3, 1.6, 0.5);
    (spawn(app, (cape, pins, place, interpolation)), shoulders)
}

/// The places of the pinned particles in their shoulders' frames.
fn in_frames(app: &App, shoulders: [Entity; 2], places: &[Vec3]) -> Vec<Vec3> {
    (0..8)
        .map(|i| {
            let frame = app.world().get::<GlobalTransform>(shoulders[i / 4]).unwrap();
            frame.affine().inverse().transform_point3(places[i])
        })
        .collect()
}

#[test]
fn a_cape_is_drawn_at_its_shoulders_at_any_frame_rate() {
    for interpolation in [ClothInterpolation::Blend, ClothInterpolation::LastTick] {
        for frame in [TICK / 3, TICK, TICK * 5 / 2] {
            let mut app = app();
            app.add_systems(Update, animate);
            let (cape, shoulders) = character(&mut app, interpolation);
            set_frame(&mut app, frame);
            updates(&mut app, 12);
            let first = in_frames(&app, shoulders, &drawn_positions(&app, cape));
            for _ in 0..40 {
                app.update();
                let now = in_frames(&app, shoulders, &drawn_positions(&app, cape));
                for (a, b) in first.iter().zip(&now) {
                    assert!(a.distance(*b) < 2e-6, "{interpolation:?} {frame:?}: {a} {b}");
                }
            }
            assert!(positions(&app, cape).iter().all(|p| p.is_finite()));
        }
    }
}

#[test]
fn a_cape_is_drawn_along_with_a_runner_between_ticks() {
    // The whole cloth, in the runner's frame, as drawn in the frames of a steady run: what is far from
    // the shoulders keeps its distance to them as well.
    for interpolation in [ClothInterpolation::Blend, ClothInterpolation::LastTick] {
        let mut app = app();
        app.add_systems(Update, |mut runners: Query<(&mut Transform, &Joint)>, time: Res<Time>| {
            for (mut transform, runs) in &mut runners {
                transform.translation.x += runs.0 * time.delta_secs();
            }
        });
        let runner = spawn(&mut app, (Transform::default(), Joint(6.0)));
        let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(runner);
        let material = ClothMaterial { drag: 8.0, ..default() };
        let cape =
            spawn(&mut app, (sheet(), pins, material, ClothInertia::new(0.0), interpolation));
        updates(&mut app, 200);
        set_frame(&mut app, TICK / 5 * 2);
        let in_frame = |app: &App| {
            let x = app.world().get::<Transform>(runner).unwrap().translation.x;
            drawn_positions(app, cape)[60] - Vec3::X * x
        };
        updates(&mut app, 10);
        let first = in_frame(&app);
        for _ in 0..20 {
            app.update();
            // A tick of the run is nine centimetres.
            assert!(in_frame(&app).distance(first) < 0.01, "{interpolation:?}");
        }
    }
}

#[test]
fn an_anchor_that_moves_in_the_first_tick_leaves_no_offset() {
    let mut app = app();
    app.add_systems(FixedUpdate, animate);
    let (cape, shoulders) = character(&mut app, ClothInterpolation::LastTick);
    app.update();
    let lattice = simulation(&app, cape).lattice().unwrap().clone();
    let expected: Vec<_> =
        lattice.rest_positions().iter().map(|p| *p + Vec3::new(0.3, 1.6, 0.5)).collect();
    // Where the shoulders held the rest shape in that tick is where they hold it for good.
    let first = in_frames(&app, shoulders, &expected);
    for _ in 0..30 {
        app.update();
        let now = in_frames(&app, shoulders, &positions(&app, cape));
        for (a, b) in first.iter().zip(&now) {
            assert!(a.distance(*b) < 2e-6, "{a} {b}");
        }
    }
}

#[test]
fn what_is_let_go_keeps_the_anchors_velocity() {
    let mut app = app();
    app.add_systems(FixedUpdate, |mut anchors: Query<&mut Transform, With<Joint>>| {
        for mut transform in &mut anchors {
            transform.translation += Vec3::new(1.5, 0.5, 0.0) * TICK.as_secs_f32();
        }
    });
    let anchor = spawn(&mut app, (Transform::default(), Joint(0.0)));
    let pins = ClothPins::from(PinSelection::All).anchored_to(anchor);
    let material = ClothMaterial { drag: 0.0, ..default() };
    let cloth = spawn(&mut app, (sheet(), pins, material));
    updates(&mut app, 20);
    let before = positions(&app, cloth);
    let step = simulation(&app, cloth).plan().step;
    *app.world_mut().get_mut::<ClothPins>(cloth).unwrap() = ClothPins::none();
    for tick in 1..40 {
        app.update();
        let t = tick as f32 * TICK.as_secs_f32();
        let way = Vec3::new(1.5, 0.5, 0.0) * t + Vec3::NEG_Y * (0.5 * 9.81 * t * t);
        // Velocities are those of the last substep's middle, so that gravity acts from there.
        let early = 9.81 * t * 0.5 * step;
        for (p, start) in positions(&app, cloth).iter().zip(&before) {
            assert!(p.distance(*start + way) < early + 1e-4, "{tick}: {p} {start}");
        }
    }
}

#[test]
fn a_change_of_parent_that_moves_nothing_moves_no_pin() {
    let mut app = app();
    let parents = [1.0, -2.0].map(|x| {
        let place = Transform::from_xyz(x, 0.5, 0.0).with_rotation(Quat::from_rotation_y(x));
        spawn(&mut app, place)
    });
    let anchor = spawn(&mut app, (Transform::from_xyz(0.1, 0.2, 0.3), ChildOf(parents[0])));
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(anchor);
    let cloth = spawn(&mut app, (sheet(), pins));
    updates(&mut app, 10);
    let before = positions(&app, cloth);
    let global = *app.world().get::<GlobalTransform>(anchor).unwrap();
    let parent = *app.world().get::<GlobalTransform>(parents[1]).unwrap();
    *transform(&mut app, anchor) = global.reparented_to(&parent);
    app.world_mut().entity_mut(anchor).insert(ChildOf(parents[1]));
    for _ in 0..10 {
        app.update();
        for (i, before) in before.iter().enumerate().take(8) {
            assert!(position(&app, cloth, i).distance(*before) < 2e-6);
        }
    }
    // And with none it is where its own transform says.
    *transform(&mut app, anchor) = global.compute_transform();
    app.world_mut().entity_mut(anchor).remove::<ChildOf>();
    updates(&mut app, 5);
    assert!(position(&app, cloth, 3).distance(before[3]) < 2e-6);
}

/// How far a sheet that hangs by a soft first row has come down \[m\].
fn offset(particles: u32, stiffness: f32) -> f32 {
    let mut app = app();
    let pins = ClothPins::from(PinSelection::FirstRow).softly(stiffness, 0.3 * stiffness);
    let material = ClothMaterial { drag: 4.0, ..default() };
    let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(particles));
    let hanging = Transform::from_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    let cloth = spawn(&mut app, (cloth, pins, material, hanging, ClothSleepThreshold::NEVER));
    app.world_mut().entity_mut(cloth).insert(ClothInterpolation::LastTick);
    updates(&mut app, 400);
    let columns = particles as usize;
    let lowered = positions(&app, cloth)[..columns].iter().map(|p| 0.5 - p.y).sum::<f32>();
    let drawn = drawn_positions(&app, cloth);
    for (drawn, simulated) in drawn.iter().zip(positions(&app, cloth)) {
        assert!(drawn.distance(simulated) < 1e-5, "drawn as simulated");
    }
    lowered / columns as f32
}

#[test]
fn a_soft_pin_gives_by_the_weight_over_its_stiffness_however_fine_the_cloth() {
    let weight = 0.2 * 9.81;
    for stiffness in [10.0, 200.0] {
        for particles in [6, 20] {
            let given = offset(particles, stiffness);
            let expected = weight / stiffness;
            assert!((given - expected).abs() < 0.01 * expected, "{particles}: {given} {expected}");
        }
    }
}

#[test]
fn soft_pins_follow_what_moves_and_become_hard_and_soft_while_running() {
    let mut app = app();
    let anchor = spawn(&mut app, Transform::from_xyz(0.2, 0.0, 0.0));
    let hard = ClothPins::from(PinSelection::FirstRow).anchored_to(anchor);
    let soft = hard.clone().softly(5000.0, 500.0);
    let cloth = spawn(&mut app, (sheet(), soft.clone()));
    updates(&mut app, 10);
    assert!(simulation(&app, cloth).pinned().is_empty());
    let start = position(&app, cloth, 0);
    for _ in 0..40 {
        transform(&mut app, anchor).translation.x += 0.02;
        app.update();
    }
    updates(&mut app, 60);
    assert!(position(&app, cloth, 0).distance(start + Vec3::X * 0.8) < 0.02);
    *app.world_mut().get_mut::<ClothPins>(cloth).unwrap() = hard;
    updates(&mut app, 3);
    // Its place in the anchor's frame is what it was.
    assert!(position(&app, cloth, 0).distance(Vec3::new(0.3, 0.0, -0.5)) < 1e-5);
    *app.world_mut().get_mut::<ClothPins>(cloth).unwrap() = soft;
    updates(&mut app, 3);
    assert!(simulation(&app, cloth).pinned().is_empty());
    assert!(position(&app, cloth, 0).distance(Vec3::new(0.3, 0.0, -0.5)) < 0.01);
    *app.world_mut().get_mut::<ClothPins>(cloth).unwrap() = ClothPins::none();
    updates(&mut app, 30);
    assert!(position(&app, cloth, 0).y < -0.5);
}

#[test]
fn anchors_that_cannot_be_used_are_told_with_their_pin() {
    type Spoil = fn(&mut App, Entity);
    let table: [(&str, Spoil); 7] = [
        ("despawned", |app, anchor| _ = app.world_mut().despawn(anchor)),
        ("no transform", |app, anchor| {
            app.world_mut().entity_mut(anchor).remove::<Transform>();
        }),
        ("NaN", |app, anchor| transform(app, anchor).translation.x = f32::NAN),
        ("infinite", |app, anchor| transform(app, anchor).translation.x = f32::INFINITY),
        ("uneven", |app, anchor| transform(app, anchor).scale = Vec3::new(1.0, 2.0, 1.0)),
        ("flat", |app, anchor| transform(app, anchor).scale = Vec3::ZERO),
        ("under an uneven parent", |app, anchor| {
            let parent = spawn(app, Transform::from_scale(Vec3::new(1.0, 3.0, 1.0)));
            app.world_mut().entity_mut(anchor).insert(ChildOf(parent));
        }),
    ];
    for soft in [false, true] {
        for (what, spoil) in table {
            for late in [false, true] {
                let mut app = app();
                let anchor = spawn(&mut app, Transform::default());
                let mut pins = ClothPins::vertices([7]).anchored_to(anchor);
                if soft {
                    pins = pins.softly(100.0, 1.0);
                }
                let pins = ClothPins::vertices([0]).and(pins);
                if !late {
                    spoil(&mut app, anchor);
                }
                let cloth = spawn(&mut app, (sheet(), pins));
                let good = spawn(&mut app, sheet());
                updates(&mut app, 4);
                if late {
                    assert_eq!(failure(&app, cloth), None);
                    spoil(&mut app, anchor);
                    updates(&mut app, 3);
                }
                let error = failure(&app, cloth).unwrap_or_else(|| panic!("{what}, late {late}"));
                assert!(
                    matches!(error, ClothError { kind: ClothErrorKind::Pin { pin: 1, .. }, .. }),
                    "{what}: {error}"
                );
                let told = error.to_string();
                assert!(told.contains(&cloth.to_string()) && told.contains(&anchor.to_string()));
                updates(&mut app, 10);
                assert!(positions(&app, cloth).iter().all(|p| p.is_finite()), "{what}");
                assert_eq!(position(&app, cloth, 0), Vec3::new(-0.5, 0.0, -0.5));
                assert_eq!(failure(&app, good), None);
            }
        }
    }
}

#[test]
fn what_moves_in_ticks_holds_soft_pins_alike_at_every_frame_rate() {
    let run = |strategy: TimeUpdateStrategy, execution: ClothExecution| {
        let mut app = app();
        app.insert_resource(execution).add_systems(FixedUpdate, animate);
        let anchor = spawn(&mut app, (Transform::from_xyz(0.1, 0.0, 0.0), Joint(0.4)));
        let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(anchor).softly(80.0, 2.0);
        let inertia = ClothInertia::new(0.4);
        let cloth = spawn(&mut app, (sheet(), pins, inertia));
        let ball = (SdfCollider::from(Sphere::new(0.3)), Transform::from_xyz(0.0, -0.35, 0.0));
        spawn(&mut app, ball);
        app.insert_resource(strategy);
        while app.world().get::<ClothSimulation>(cloth).is_none_or(|c| c.tick_count() < 24) {
            app.update();
        }
        bits(&app, cloth)
    };
    let (fused, staged) = (ClothExecution::Fused, ClothExecution::Staged);
    let one = run(TimeUpdateStrategy::FixedTimesteps(1), fused);
    assert_eq!(one, run(TimeUpdateStrategy::FixedTimesteps(1), staged));
    assert_eq!(one, run(TimeUpdateStrategy::FixedTimesteps(3), staged));
    assert_eq!(one, run(TimeUpdateStrategy::ManualDuration(TICK / 5 * 2), fused));
}
