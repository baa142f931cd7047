//! Grabs, held to statics (`m g / k` below the target, no more than the limit), to places, and to bit
//! equality where nothing is grabbed.

use crate::support::app::*;
use bevy::prelude::*;
use bevy_drape::{
    ClothError, ClothErrorKind, ClothExecution, ClothGrab, ClothGravityOverride, ClothProxy,
    ClothSleepThreshold, GrabProblem, prelude::*, solver::MassLumping,
};

fn slow() -> ClothMaterial {
    ClothMaterial { drag: 3.0, ..default() }
}

/// The weight of [`sheet`] \[N\].
const WEIGHT: f32 = 0.2 * 9.81;

fn grab(app: &mut App, cloth: Entity, grab: ClothGrab) {
    app.world_mut().entity_mut(cloth).insert(grab);
}

#[test]
fn one_particle_is_drawn_to_the_target_and_hangs_by_the_weight() {
    let mut app = app();
    let cloth = spawn(&mut app, (sheet(), slow()));
    updates(&mut app, 2);
    let target = Vec3::new(0.2, 1.5, 0.1);
    grab(&mut app, cloth, ClothGrab::particle(0, target));
    updates(&mut app, 64 * 12);
    let held = position(&app, cloth, 0);
    assert!(held.distance(target + Vec3::NEG_Y * WEIGHT / 200.0) < 2e-3, "{held}");
    app.world_mut().entity_mut(cloth).remove::<ClothGrab>();
    updates(&mut app, 20);
    assert!(position(&app, cloth, 0).y < target.y - 0.1, "let go, it falls");
}

#[test]
fn a_ball_grabs_what_is_in_it_and_keeps_it_apart() {
    let mut app = app();
    let material = ClothMaterial { thread_stiffness: 20.0, ..slow() };
    let cloth = spawn(&mut app, (sheet(), material, ClothGravityOverride(Vec3::ZERO)));
    updates(&mut app, 2);
    let before = positions(&app, cloth);
    let centre = before[27];
    let near: Vec<_> = (0..64).filter(|&i| before[i].distance(centre) < 0.2).collect();
    assert!((4..20).contains(&near.len()));
    let middle = near.iter().map(|&i| before[i]).sum::<Vec3>() / near.len() as f32;
    let target = middle + Vec3::Y * 0.7;
    grab(&mut app, cloth, ClothGrab::within(centre, 0.2, target));
    updates(&mut app, 64 * 12);
    for i in near {
        let expected = before[i] + (target - middle);
        assert!(position(&app, cloth, i).distance(expected) < 5e-3);
    }
}

#[test]
fn no_more_force_than_the_limit() {
    for (share, held) in [(0.8, false), (1.2, true)] {
        let mut app = app();
        let cloth = spawn(&mut app, (sheet(), slow()));
        updates(&mut app, 2);
        let middle = positions(&app, cloth).iter().sum::<Vec3>() / 64.0;
        let max_force = share * WEIGHT;
        let all = ClothGrab { max_force, ..ClothGrab::within(middle, 5.0, middle) };
        grab(&mut app, cloth, all);
        updates(&mut app, 64 * 4);
        let below = middle.y - position(&app, cloth, 30).y;
        assert_eq!(below < 0.1, held, "{share}: {below}");
    }
}

#[test]
fn a_target_is_followed_in_update_and_in_the_fixed_schedule() {
    #[derive(Resource)]
    struct Speed(f32);
    fn drag(mut grabs: Query<&mut ClothGrab>, time: Res<Time>, speed: Res<Speed>) {
        for mut grab in &mut grabs {
            grab.target.x += speed.0 * time.delta_secs();
        }
    }
    for fixed in [true, false] {
        let mut app = app();
        app.insert_resource(Speed(0.5));
        if fixed {
            app.add_systems(FixedUpdate, drag);
        } else {
            app.add_systems(Update, drag);
        }
        let pins = ClothPins::vertices([63]);
        let cloth =
            spawn(&mut app, (sheet(), slow(), ClothSleepThreshold { time: 0.2, ..default() }));
        updates(&mut app, 2);
        let start = position(&app, cloth, 0);
        grab(&mut app, cloth, ClothGrab::particle(0, start));
        app.world_mut().entity_mut(cloth).insert(pins);
        updates(&mut app, 64);
        let target = app.world().get::<ClothGrab>(cloth).unwrap().target;
        let away = position(&app, cloth, 0) - target;
        assert!(target.x > start.x + 0.4 && away.length() < 0.05, "fixed {fixed}: {away}");
        assert!(!simulation(&app, cloth).is_asleep());
    }
}

#[test]
fn what_pins_hold_they_keep_hard_and_soft() {
    let mut app = app();
    let pins = ClothPins::vertices([0]).and(ClothPins::vertices([3]).softly(5000.0, 5.0));
    let cloth = spawn(&mut app, (sheet(), slow(), pins.clone()));
    updates(&mut app, 2);
    let (pinned, soft) = (position(&app, cloth, 0), position(&app, cloth, 3));
    // More particles of which the middle ones are pinned already.
    let all = ClothGrab::within(pinned, 0.6, pinned + Vec3::new(0.2, 0.4, 0.3));
    grab(&mut app, cloth, all);
    updates(&mut app, 200);
    assert_eq!(position(&app, cloth, 0), pinned);
    assert!(position(&app, cloth, 3).distance(soft) < 0.02);
    assert_eq!(failure(&app, cloth), None);
    assert!(position(&app, cloth, 1).y > pinned.y + 0.02, "and the hand pulls");
    // Pins that come and go while it is grabbed.
    *app.world_mut().get_mut::<ClothPins>(cloth).unwrap() =
        pins.clone().and(ClothPins::vertices([1, 2]));
    updates(&mut app, 20);
    assert_eq!(simulation(&app, cloth).pinned(), [0, 1, 2]);
    *app.world_mut().get_mut::<ClothPins>(cloth).unwrap() = ClothPins::none();
    updates(&mut app, 300);
    assert_eq!(failure(&app, cloth), None);
    assert!(position(&app, cloth, 0).y > pinned.y + 0.2);
    // Another material, masses and weights keep the hand's limit.
    app.world_mut().get_mut::<ClothSettings>(cloth).unwrap().masses = MassLumping::Equal;
    updates(&mut app, 100);
    assert_eq!(failure(&app, cloth), None);
    assert!(position(&app, cloth, 0).y > pinned.y + 0.2);
}

#[test]
fn grabbing_wakes_and_letting_go_does() {
    let mut app = app();
    let thick = ClothMaterial { drag: 12.0, ..default() };
    let still =
        (sheet(), ClothGravityOverride(Vec3::ZERO), ClothSleepThreshold { time: 0.1, ..default() });
    let cloth = spawn(&mut app, (still, thick));
    updates(&mut app, 20);
    let asleep = |app: &App| simulation(app, cloth).is_asleep();
    assert!(asleep(&app));
    let place = position(&app, cloth, 5);
    grab(&mut app, cloth, ClothGrab::particle(5, place));
    app.update();
    assert!(!asleep(&app));
    updates(&mut app, 20);
    assert!(asleep(&app), "a hand that stands still lets it sleep");
    app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().target.y += 0.1;
    app.update();
    assert!(!asleep(&app));
    updates(&mut app, 400);
    assert!(asleep(&app));
    app.world_mut().entity_mut(cloth).remove::<ClothGrab>();
    app.update();
    assert!(!asleep(&app));
}

#[test]
fn both_forms_and_a_grab_that_never_was_keep_their_bits() {
    let run = |execution, grabbed: bool| {
        let mut app = app();
        app.insert_resource(execution);
        let cloth = spawn(&mut app, (sheet(), ClothPins::vertices([0])));
        updates(&mut app, 2);
        if grabbed {
            grab(&mut app, cloth, ClothGrab::within(Vec3::X * 0.4, 0.3, Vec3::ONE));
        }
        updates(&mut app, 30);
        bits(&app, cloth)
    };
    let fused = run(ClothExecution::Fused, true);
    assert_eq!(fused, run(ClothExecution::Staged, true));
    assert_ne!(fused, run(ClothExecution::Fused, false));
}

#[test]
fn a_grab_that_cannot_be_is_told_and_holds_nothing() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet());
    let twin = spawn(&mut app, sheet());
    updates(&mut app, 2);
    let good = ClothGrab::particle(3, Vec3::Y);
    for (bad, expected) in [
        (ClothGrab::particle(64, Vec3::Y), "particle 64"),
        (ClothGrab::within(Vec3::Y * 9.0, 0.5, Vec3::Y), "no particle is within"),
        (ClothGrab::within(Vec3::NAN, 0.5, Vec3::Y), "centre"),
        (ClothGrab::within(Vec3::ZERO, -0.5, Vec3::Y), "radius"),
        (ClothGrab::within(Vec3::ZERO, f32::NAN, Vec3::Y), "radius"),
        (ClothGrab::particle(3, Vec3::splat(f32::INFINITY)), "target"),
        (ClothGrab { stiffness: 0.0, ..good }, "stiffness"),
        (ClothGrab { stiffness: f32::NAN, ..good }, "stiffness"),
        (ClothGrab { damping: -1.0, ..good }, "damping"),
        (ClothGrab { max_force: 0.0, ..good }, "max_force"),
        (ClothGrab { max_force: f32::NAN, ..good }, "max_force"),
    ] {
        grab(&mut app, cloth, bad);
        app.update();
        let told = failure(&app, cloth).expect(expected);
        let text = told.to_string();
        assert!(
            matches!(told, ClothError { entity, kind: ClothErrorKind::Grab(_) } if entity == cloth),
            "{text}"
        );
        assert!(text.contains(expected), "{text} about {expected}");
        assert_eq!(bits(&app, cloth), bits(&app, twin), "{expected}");
    }
    assert!(GrabProblem::Nothing.to_string().contains("larger"));
    // A running one whose target is lost lets go, and takes hold again when it is found.
    grab(&mut app, cloth, good);
    updates(&mut app, 60);
    assert_eq!(failure(&app, cloth), None);
    let up = position(&app, cloth, 3).y;
    app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().target.x = f32::NAN;
    updates(&mut app, 20);
    assert!(failure(&app, cloth).is_some() && position(&app, cloth, 3).y < up - 0.1);
    app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().target.x = 0.0;
    updates(&mut app, 200);
    assert_eq!(failure(&app, cloth), None);
    assert!(position(&app, cloth, 3).y > 0.8);
    app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().stiffness = -1.0;
    app.update();
    app.world_mut().entity_mut(cloth).remove::<ClothGrab>();
    app.update();
    assert_eq!(failure(&app, cloth), None);
}

#[test]
fn what_is_hung_is_grabbed_when_it_hangs() {
    let mut app = app();
    let mut ring = |x| spawn(&mut app, Transform::from_xyz(x, 2.0, 0.0));
    let (left, right) = (ring(-0.4), ring(0.4));
    let pins =
        ClothPins::vertices([0]).anchored_to(left).and(ClothPins::vertices([7]).anchored_to(right));
    let hand = ClothGrab::particle(60, Vec3::new(0.0, 1.5, 0.5));
    let cloth = spawn(&mut app, (sheet(), slow(), pins, HangOnStart::default(), hand));
    // Frames without ticks, in which it is hung anew as a ring moves.
    set_frame(&mut app, TICK / 16);
    for _ in 0..4 {
        transform(&mut app, left).translation.x -= 0.01;
        app.update();
    }
    set_frame(&mut app, TICK);
    wait(&mut app, |app| {
        app.world().get::<ClothSimulation>(cloth).is_some_and(|it| it.tick_count() > 0)
    });
    assert!(simulation(&app, cloth).hung().is_some(), "it came to rest");
    updates(&mut app, 200);
    assert_eq!(failure(&app, cloth), None);
    assert!(position(&app, cloth, 60).distance(Vec3::new(0.0, 1.5, 0.5)) < 0.1);
}

/// What holds the cloth does not let go as it is made stiffer, or as the cloth goes on with other particles.
#[test]
fn a_grab_goes_on_where_its_numbers_or_the_particles_change() {
    type Act = fn(&mut App, Entity);
    let changes: [(&str, Act); 4] = [
        ("force", |app, cloth| {
            app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().max_force = 90.0;
        }),
        ("stiffness", |app, cloth| {
            app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().stiffness = 150.0;
        }),
        ("proxy", |app, cloth| {
            app.world_mut().entity_mut(cloth).insert(ClothProxy::grid(8, 8));
        }),
        ("coarse proxy", |app, cloth| {
            app.world_mut().entity_mut(cloth).insert(ClothProxy::grid(3, 3));
        }),
    ];
    for (what, change) in changes {
        let mut app = app();
        let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(16));
        let pins = ClothPins::from(PinSelection::FirstRow);
        let cloth = spawn(&mut app, (cloth, pins, slow()));
        updates(&mut app, 2);
        let at = position(&app, cloth, 255);
        let held = ClothGrab { max_force: 200.0, ..ClothGrab::within(at, 0.1, at) };
        grab(&mut app, cloth, held);
        let target = at + Vec3::new(-0.3, 0.4, -0.2);
        for tick in 1..=60 {
            let part = tick as f32 / 60.0;
            app.world_mut().get_mut::<ClothGrab>(cloth).unwrap().target = at.lerp(target, part);
            app.update();
        }
        change(&mut app, cloth);
        updates(&mut app, 90);
        assert_eq!(failure(&app, cloth), None, "{what}");
        let near = positions(&app, cloth).into_iter().map(|place| place.distance(target));
        let nearest = near.fold(f32::INFINITY, f32::min);
        assert!(nearest < 0.06, "{what}: {nearest}");
    }
}
