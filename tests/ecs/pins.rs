//! Pins follow what holds them, and let go when told to.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{ClothError, ClothErrorKind, PinProblem, prelude::*};

/// Moves the entities that carry it, each time it runs.
#[derive(Component, Clone, Copy)]
struct Moves(Vec3);

fn move_all(mut moving: Query<(&mut Transform, &Moves)>) {
    for (mut transform, moves) in &mut moving {
        transform.translation += moves.0;
        transform.rotate_y(0.05);
    }
}

/// Where a particle is after each tick.
#[derive(Resource, Default)]
struct Track(Vec<Vec3>);

fn track(cloths: Query<&ClothSimulation>, mut track: ResMut<Track>) {
    track.0.extend(cloths.iter().filter_map(|cloth| cloth.position(0)));
}

#[test]
fn pins_without_anchor_follow_the_cloths_entity() {
    let mut app = app();
    app.add_systems(FixedUpdate, move_all);
    let pinned = [0, 7];
    let entity = (sheet(), ClothPins::vertices(pinned), Moves(Vec3::new(0.01, 0.0, 0.02)));
    let entity = spawn(&mut app, entity);
    updates(&mut app, 40);
    assert_eq!(simulation(&app, entity).pinned(), &pinned);
    let place = *transform(&mut app, entity);
    assert!((place.translation.x - 0.4).abs() < 1e-5);
    for (particle, x) in [(0, -0.5), (7, 0.5)] {
        let expected = place.transform_point(Vec3::new(x, 0.0, -0.5));
        assert!(position(&app, entity, particle).distance(expected) < 1e-5);
        assert!(drawn_positions(&app, entity)[particle].distance(expected) < 1e-5);
        let local = attribute(drawn(&app, entity), Mesh::ATTRIBUTE_POSITION)[particle];
        assert!(local.distance(Vec3::new(x, 0.0, -0.5)) < 1e-6);
    }
    assert!(position(&app, entity, 60).y < -0.3);
}

#[test]
fn anchored_pins_keep_their_place_in_the_anchors_frame() {
    let mut app = app();
    app.add_systems(FixedUpdate, move_all);
    let turned = Transform::from_xyz(1.0, 2.0, 0.0).with_rotation(Quat::from_rotation_y(0.7));
    let parent = spawn(&mut app, (turned, Moves(Vec3::new(0.0, 0.01, 0.0))));
    let anchor = spawn(&mut app, (Transform::from_xyz(0.3, 0.0, 0.0), ChildOf(parent)));
    let pins = ClothPins::from(PinSelection::FirstRow).anchored_to(anchor);
    let entity = spawn(&mut app, (sheet(), pins));
    app.update();
    // The anchor's place when it took hold.
    let before = turned * Transform::from_xyz(0.3, 0.0, 0.0);
    let moved = |app: &App| {
        let parent = app.world().get::<Transform>(parent).unwrap();
        *parent * Transform::from_xyz(0.3, 0.0, 0.0)
    };
    let first = moved(&app);
    let place = first.compute_affine().inverse().transform_point3(position(&app, entity, 3));
    assert!(first.translation.distance(before.translation) > 0.005);
    updates(&mut app, 30);
    let expected = moved(&app).transform_point(place);
    assert!(position(&app, entity, 3).distance(expected) < 1e-4);
    assert!(drawn_positions(&app, entity)[3].distance(expected) < 1e-4);
}

#[test]
fn a_move_once_a_frame_is_spread_evenly_over_its_ticks() {
    let mut app = app();
    app.init_resource::<Track>().add_systems(FixedLast, track);
    app.add_systems(Update, |mut anchors: Query<&mut Transform, With<Moves>>| {
        for mut transform in &mut anchors {
            transform.translation.x += 0.04;
        }
    });
    let anchor = spawn(&mut app, (Transform::default(), Moves(Vec3::ZERO)));
    let pins = ClothPins::vertices([0]).anchored_to(anchor);
    let entity = spawn(&mut app, (sheet(), pins, Transform::from_xyz(0.5, 0.0, 0.5)));
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(4));
    updates(&mut app, 3);
    app.world_mut().resource_mut::<Track>().0.clear();
    updates(&mut app, 5);
    let track = &app.world().resource::<Track>().0;
    assert_eq!(track.len(), 20);
    for pair in track.windows(2) {
        assert!((pair[1].x - pair[0].x - 0.01).abs() < 1e-5, "{track:?}");
    }
    // The simulation is a frame behind what was moved after it; the picture is not.
    let anchor = app.world().get::<Transform>(anchor).unwrap().translation;
    let simulated = position(&app, entity, 0).x;
    let shown = drawn_positions(&app, entity)[0].x;
    let offset = shown - anchor.x;
    assert!((shown - simulated - 0.04).abs() < 1e-5);
    app.update();
    let anchor = app
        .world()
        .get::<Transform>(app.world().get::<ClothPins>(entity).unwrap().pins[0].anchor.unwrap());
    assert!(
        (drawn_positions(&app, entity)[0].x - anchor.unwrap().translation.x - offset).abs() < 1e-5
    );
}

#[test]
fn frames_shorter_than_a_tick_lose_no_motion() {
    let mut app = app();
    app.init_resource::<Track>().add_systems(FixedLast, track);
    app.add_systems(Update, |mut anchors: Query<&mut Transform, With<Moves>>| {
        for mut transform in &mut anchors {
            transform.translation.x += 0.01;
        }
    });
    let moving = (sheet(), ClothPins::vertices([0]), Moves(Vec3::ZERO));
    let entity = spawn(&mut app, moving);
    set_frame(&mut app, TICK / 4);
    updates(&mut app, 8);
    app.world_mut().resource_mut::<Track>().0.clear();
    updates(&mut app, 40);
    let track = &app.world().resource::<Track>().0;
    assert_eq!(track.len(), 10);
    for pair in track.windows(2) {
        assert!((pair[1].x - pair[0].x - 0.04).abs() < 1e-5, "{track:?}");
    }
    let expected = app.world().get::<Transform>(entity).unwrap().translation.x - 0.5;
    assert!((drawn_positions(&app, entity)[0].x - expected).abs() < 1e-5);
}

/// 24 ticks of a swinging cloth, in frames of `frame` ticks.
fn swing(strategy: TimeUpdateStrategy) -> Vec<[u32; 3]> {
    let mut app = app();
    app.add_systems(FixedUpdate, move_all);
    app.insert_resource(strategy);
    let moves = Moves(Vec3::new(0.02, 0.005, 0.0));
    let entity = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::FirstRow), moves));
    spawn(&mut app, (SdfCollider::from(Sphere::new(0.2)), Moves(Vec3::NEG_Y * 0.01)));
    while app.world().get::<ClothSimulation>(entity).is_none_or(|cloth| cloth.tick_count() < 24) {
        app.update();
    }
    assert_eq!(simulation(&app, entity).tick_count(), 24);
    bits(&app, entity)
}

#[test]
fn what_moves_in_the_fixed_schedule_does_not_depend_on_the_frame_rate() {
    let one = swing(TimeUpdateStrategy::FixedTimesteps(1));
    assert_eq!(one, swing(TimeUpdateStrategy::FixedTimesteps(3)));
    assert_eq!(one, swing(TimeUpdateStrategy::FixedTimesteps(8)));
    assert_eq!(one, swing(TimeUpdateStrategy::ManualDuration(TICK / 5 * 2)));
}

#[test]
fn pins_are_edited_live() {
    let mut app = app();
    let entity = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::FirstRow)));
    updates(&mut app, 30);
    assert_eq!(position(&app, entity, 7).y, 0.0);
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = ClothPins::vertices([0]);
    updates(&mut app, 20);
    assert_eq!(position(&app, entity, 0), Vec3::new(-0.5, 0.0, -0.5));
    assert!(position(&app, entity, 7).y < -0.1);
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = ClothPins::none();
    updates(&mut app, 20);
    assert!(position(&app, entity, 0).y < -0.1);
    // Held again, it goes back to its place.
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = ClothPins::vertices([0]);
    app.update();
    assert_eq!(position(&app, entity, 0), Vec3::new(-0.5, 0.0, -0.5));
}

#[test]
fn adding_a_pin_moves_no_other() {
    let mut app = app();
    let anchor = spawn(&mut app, Transform::default());
    let entity = spawn(&mut app, (sheet(), ClothPins::vertices([0]).anchored_to(anchor)));
    updates(&mut app, 10);
    transform(&mut app, anchor).translation.y = 1.0;
    updates(&mut app, 10);
    let place = position(&app, entity, 63);
    let more = ClothPins::vertices([0, 63]).anchored_to(anchor);
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = more;
    updates(&mut app, 10);
    assert!(position(&app, entity, 0).distance(Vec3::new(-0.5, 1.0, -0.5)) < 1e-6);
    assert!(position(&app, entity, 63).distance(place) < 1e-6);
}

#[test]
fn a_box_chooses_in_the_cloths_own_frame() {
    let mut app = app();
    let pins = ClothPins::within(Vec3::new(-0.6, -0.1, -0.6), Vec3::new(0.6, 0.1, -0.45));
    let place = Transform::from_xyz(5.0, 1.0, 0.0).with_scale(Vec3::splat(3.0));
    let entity = spawn(&mut app, (sheet(), pins, place));
    app.update();
    assert_eq!(simulation(&app, entity).pinned(), &[0, 1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn sheets_have_edges_and_corners() {
    let mut app = app();
    let cloth = Cloth::sheet(Vec2::ONE, UVec2::new(4, 3));
    for (selection, expected) in [
        (PinSelection::Corners, vec![0, 3, 8, 11]),
        (PinSelection::FirstRow, vec![0, 1, 2, 3]),
        (PinSelection::LastRow, vec![8, 9, 10, 11]),
        (PinSelection::FirstColumn, vec![0, 4, 8]),
        (PinSelection::LastColumn, vec![3, 7, 11]),
        (PinSelection::All, (0..12).collect()),
    ] {
        let entity = spawn(&mut app, (cloth, ClothPins::from(selection)));
        app.update();
        assert_eq!(simulation(&app, entity).pinned(), expected);
    }
}

#[test]
fn pins_that_cannot_be_used_hold_nothing_and_the_others_stay() {
    let mut app = app();
    let nowhere = ClothPins::within(Vec3::splat(5.0), Vec3::splat(6.0));
    let pins = ClothPins::vertices([0]).and(nowhere).and(ClothPins::vertices([1, 64]));
    let entity = spawn(&mut app, (sheet(), pins));
    updates(&mut app, 3);
    assert_eq!(simulation(&app, entity).pinned(), &[0]);
    let error = failure(&app, entity).unwrap();
    assert!(
        matches!(
            error,
            ClothError { kind: ClothErrorKind::Pin { pin: 1, problem: PinProblem::Empty }, .. }
        ),
        "{error}"
    );
    let pins = ClothPins::vertices([0]).and(ClothPins::vertices([1, 64]));
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = pins;
    updates(&mut app, 2);
    let error = failure(&app, entity).unwrap();
    let expected = PinProblem::NoSuchVertex { vertex: 64, count: 64 };
    assert_eq!(
        error,
        ClothError { entity, kind: ClothErrorKind::Pin { pin: 1, problem: expected } }
    );
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = ClothPins::vertices([0, 1]);
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    assert_eq!(simulation(&app, entity).pinned(), &[0, 1]);
}

#[test]
fn a_despawned_anchor_lets_go_of_its_pins_alone() {
    let mut app = app();
    let anchors = [0.0, 1.0].map(|x| spawn(&mut app, Transform::from_xyz(x, 0.0, 0.0)));
    let pins = ClothPins::vertices([0]).anchored_to(anchors[0]);
    let pins = pins.and(ClothPins::vertices([7]).anchored_to(anchors[1]));
    let entity = spawn(&mut app, (sheet(), pins));
    updates(&mut app, 10);
    app.world_mut().despawn(anchors[0]);
    updates(&mut app, 20);
    assert_eq!(simulation(&app, entity).pinned(), &[7]);
    assert!(position(&app, entity, 0).y < -0.05);
    assert_eq!(position(&app, entity, 7), Vec3::new(0.5, 0.0, -0.5));
    let expected = PinProblem::NoAnchor(anchors[0]);
    assert_eq!(
        failure(&app, entity),
        Some(ClothError { entity, kind: ClothErrorKind::Pin { pin: 0, problem: expected } })
    );
    let pins = ClothPins::vertices([7]).anchored_to(anchors[1]);
    *app.world_mut().get_mut::<ClothPins>(entity).unwrap() = pins;
    app.update();
    assert_eq!(failure(&app, entity), None);
}

#[test]
fn an_anchor_with_an_uneven_scale_holds_still_until_it_is_even() {
    let mut app = app();
    let anchor = spawn(&mut app, Transform::default());
    let entity = spawn(&mut app, (sheet(), ClothPins::vertices([0]).anchored_to(anchor)));
    updates(&mut app, 3);
    transform(&mut app, anchor).scale = Vec3::new(1.0, 2.0, 1.0);
    updates(&mut app, 3);
    let error = failure(&app, entity).unwrap();
    assert!(
        matches!(
            error,
            ClothError {
                kind: ClothErrorKind::Pin { problem: PinProblem::AnchorScale { .. }, .. },
                ..
            }
        ),
        "{error}"
    );
    assert_eq!(position(&app, entity, 0), Vec3::new(-0.5, 0.0, -0.5));
    transform(&mut app, anchor).scale = Vec3::ONE;
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
    // One that is nowhere is told of as what it is.
    transform(&mut app, anchor).translation.x = f32::NAN;
    updates(&mut app, 2);
    let error = failure(&app, entity).unwrap().to_string();
    assert!(error.contains(&format!("of its anchor {anchor}: its transform")), "{error}");
    assert!(error.contains("is not finite"), "{error}");
    transform(&mut app, anchor).translation.x = 0.0;
    updates(&mut app, 2);
    assert_eq!(failure(&app, entity), None);
}

/// Whatever takes an anchor away, and however late it comes: its pins take hold where their particles are by then.
#[test]
fn an_anchor_that_comes_back_holds_again() {
    type Change = fn(&mut EntityWorldMut);
    let ways: [(&str, Change, Change); 3] = [
        (
            "without a `Transform`",
            |anchor| _ = anchor.remove::<Transform>(),
            |anchor| _ = anchor.insert(Transform::from_xyz(0.0, 0.5, 0.0)),
        ),
        (
            "disabled",
            |anchor| _ = anchor.insert(bevy::ecs::entity_disabling::Disabled),
            |anchor| _ = anchor.remove::<bevy::ecs::entity_disabling::Disabled>(),
        ),
        (
            "below a parent without one",
            |anchor| {
                let parent = anchor.world_scope(|world| world.spawn_empty().id());
                anchor.insert(ChildOf(parent));
            },
            |anchor| {
                let parent = anchor.get::<ChildOf>().unwrap().parent();
                anchor.world_scope(|world| {
                    world.entity_mut(parent).insert(Transform::default()).id()
                });
            },
        ),
    ];
    for (what, leave, come) in ways {
        for is_late in [false, true] {
            let mut app = app();
            let [anchor, other] =
                [0.4, -0.4].map(|x| spawn(&mut app, Transform::from_xyz(x, 0.5, 0.0)));
            let change = |app: &mut App, it: Change| it(&mut app.world_mut().entity_mut(anchor));
            if is_late {
                change(&mut app, leave);
            }
            let pins = ClothPins::vertices([0]).anchored_to(anchor);
            let pins = pins.and(ClothPins::vertices([7]).anchored_to(other));
            let cloth = spawn(&mut app, (sheet(), pins, Transform::from_xyz(0.0, 0.5, 0.0)));
            updates(&mut app, 10);
            if !is_late {
                assert_eq!(failure(&app, cloth), None, "{what}");
                change(&mut app, leave);
                updates(&mut app, 10);
            }
            let error = failure(&app, cloth).unwrap();
            let lost = PinProblem::NoAnchor(anchor);
            assert_eq!(error.kind, ClothErrorKind::Pin { pin: 0, problem: lost }, "{what}");
            // The other one goes on.
            assert!(position(&app, cloth, 7).distance(Vec3::new(0.5, 0.5, -0.5)) < 1e-5, "{what}");
            change(&mut app, come);
            updates(&mut app, 3);
            assert_eq!(failure(&app, cloth), None, "{what}, late {is_late}");
            let held = position(&app, cloth, 0);
            updates(&mut app, 20);
            assert!(held.distance(position(&app, cloth, 0)) < 1e-5, "{what}, late {is_late}");
        }
    }
}
