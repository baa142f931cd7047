//! Teleports, resets and inherited inertia: invariants. A cloth that is carried along is, in its
//! entity's frame, the one that stayed; one without inertia is, on an entity that speeds up, the one at
//! rest.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{ClothInertia, ClothSleepThreshold, ClothTeleport, prelude::*};

/// Way of each teleport: no multiple of anything.
const WAY: Vec3 = Vec3::new(8.03, 3.7, -5.1);

fn turn() -> Quat {
    Quat::from_axis_angle(Vec3::Y, 1.1)
}

/// A curtain that swings from its first row, held by its own entity or by two anchors.
struct Swing {
    app: App,
    cloth: Entity,
    anchors: Vec<Entity>,
}

fn swing(anchored: bool) -> Swing {
    let mut app = app();
    let mut anchors = Vec::new();
    let mut pins = ClothPins::from(PinSelection::FirstRow);
    if anchored {
        anchors = [-0.5, 0.5].map(|x| spawn(&mut app, Transform::from_xyz(x, 0.2, 0.0))).to_vec();
        pins = ClothPins::vertices([0, 1, 2, 3]).anchored_to(anchors[0]);
        pins = pins.and(ClothPins::vertices([4, 5, 6, 7]).anchored_to(anchors[1]));
    }
    let cloth = spawn(&mut app, (sheet(), pins));
    updates(&mut app, 25);
    Swing { app, cloth, anchors }
}

impl Swing {
    /// Moves what holds the cloth.
    fn carry(&mut self, translation: Vec3, rotation: Quat) {
        let mut moved = self.anchors.clone();
        if moved.is_empty() {
            moved.push(self.cloth);
        }
        for entity in moved {
            let mut transform = transform(&mut self.app, entity);
            transform.translation = rotation * transform.translation + translation;
            transform.rotation = rotation * transform.rotation;
        }
    }

    fn strain(&self) -> f32 {
        simulation(&self.app, self.cloth).strain().max
    }

    fn velocity(&self, particle: usize) -> Vec3 {
        simulation(&self.app, self.cloth).velocity(particle).unwrap()
    }
}

/// How far the two are from being the same cloth, one of them moved \[m\].
fn apart(moved: &Swing, stayed: &Swing, translation: Vec3, rotation: Quat) -> f32 {
    positions(&moved.app, moved.cloth)
        .iter()
        .zip(positions(&stayed.app, stayed.cloth))
        .map(|(a, b)| a.distance(rotation * b + translation))
        .fold(0.0, f32::max)
}

#[test]
fn a_teleport_keeps_shape_strain_and_motion() {
    for anchored in [false, true] {
        // Gravity is along y, and so is the turn: the twin that stays is the truth afterwards too.
        for rotation in [Quat::IDENTITY, turn()] {
            let (mut moved, mut stayed) = (swing(anchored), swing(anchored));
            let before = moved.strain();
            moved.carry(WAY, rotation);
            for tick in 0..60 {
                moved.app.update();
                stayed.app.update();
                let strain = (moved.strain() - stayed.strain()).abs();
                assert!(strain < 0.002, "tick {tick}, anchored {anchored}: {strain}");
                let apart = apart(&moved, &stayed, WAY, rotation);
                assert!(apart < 1e-3, "tick {tick}, anchored {anchored}: {apart}");
                let velocity = moved.velocity(60).distance(rotation * stayed.velocity(60));
                assert!(velocity < 0.02, "tick {tick}, anchored {anchored}: {velocity}");
            }
            assert!(moved.strain() < before + 0.02);
        }
    }
}

#[test]
fn a_jump_of_ten_metres_leaves_strain_within_two_points() {
    for anchored in [false, true] {
        let mut moved = swing(anchored);
        let before = moved.strain();
        moved.carry(Vec3::X * 10.0, Quat::IDENTITY);
        let mut peak = 0.0_f32;
        for _ in 0..40 {
            moved.app.update();
            peak = peak.max(moved.strain());
        }
        assert!(peak < before + 0.02, "anchored {anchored}: {peak}, before {before}");
    }
}

#[test]
fn without_teleport_the_same_jump_tears_at_the_cloth() {
    let mut moved = swing(false);
    moved.app.world_mut().entity_mut(moved.cloth).insert(ClothTeleport::NEVER);
    moved.carry(Vec3::X * 10.0, Quat::IDENTITY);
    moved.app.update();
    assert!(moved.velocity(60).length() > 20.0);
}

#[test]
fn a_free_cloth_goes_along_and_keeps_its_fall() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet());
    updates(&mut app, 20);
    let before = position(&app, cloth, 9);
    let fall = simulation(&app, cloth).velocity(9).unwrap();
    transform(&mut app, cloth).translation += WAY;
    app.update();
    let now = position(&app, cloth, 9);
    let step = fall * TICK.as_secs_f32();
    assert!(now.distance(before + WAY + step) < 0.01, "{now}");
    // What it is drawn between is where it went.
    assert!(drawn_positions(&app, cloth)[9].distance(now) < 0.1);
}

#[test]
fn a_vehicle_at_50_m_s_is_no_teleport() {
    let run = |teleport: Option<ClothTeleport>| {
        let mut app = app();
        app.add_systems(FixedUpdate, |mut cloths: Query<&mut Transform, With<Cloth>>| {
            for mut transform in &mut cloths {
                transform.translation.x += 50.0 / 60.0;
            }
        });
        let cloth = spawn(&mut app, (sheet(), ClothPins::from(PinSelection::FirstRow)));
        if let Some(teleport) = teleport {
            app.world_mut().entity_mut(cloth).insert(teleport);
        }
        updates(&mut app, 30);
        bits(&app, cloth)
    };
    let reference = run(None);
    assert_eq!(reference, run(Some(ClothTeleport::NEVER)));
    let low = ClothTeleport { distance: 0.5, ..default() };
    assert_ne!(reference, run(Some(low)));
}

#[test]
fn a_teleport_can_be_asked_for() {
    let short = Vec3::new(0.5, 0.25, 0.0);
    let (mut asked, mut dragged, mut stayed) = (swing(false), swing(false), swing(false));
    for swing in [&mut asked, &mut dragged] {
        swing.carry(short, Quat::IDENTITY);
    }
    let entity = asked.cloth;
    asked.app.world_mut().trigger(TeleportCloth { entity });
    for swing in [&mut asked, &mut dragged, &mut stayed] {
        swing.app.update();
    }
    assert!(apart(&asked, &stayed, short, Quat::IDENTITY) < 1e-4);
    assert!(apart(&dragged, &stayed, short, Quat::IDENTITY) > 0.1);
    // It was asked for once.
    asked.carry(short, Quat::IDENTITY);
    asked.app.update();
    stayed.app.update();
    assert!(apart(&asked, &stayed, 2.0 * short, Quat::IDENTITY) > 0.1);
}

#[test]
fn asking_what_is_no_cloth_is_harmless() {
    let mut app = app();
    let cloth = spawn(&mut app, sheet());
    let (other, gone) = (spawn(&mut app, Transform::default()), spawn(&mut app, ()));
    app.world_mut().despawn(gone);
    for entity in [other, gone, Entity::PLACEHOLDER] {
        app.world_mut().trigger(TeleportCloth { entity });
        app.world_mut().trigger(ResetCloth { entity });
    }
    updates(&mut app, 3);
    assert_eq!(simulation(&app, cloth).tick_count(), 3);
}

#[test]
fn anchors_that_part_are_no_teleport() {
    let mut moved = swing(true);
    let anchor = moved.anchors[0];
    transform(&mut moved.app, anchor).translation.x -= 3.0;
    moved.app.update();
    // The other stays where it is.
    let place = position(&moved.app, moved.cloth, 7);
    assert!(place.distance(Vec3::new(0.5, 0.0, -0.5)) < 1e-5, "{place}");
}

#[test]
fn slow_frames_teleport_too() {
    let jump = |frame_ticks: u32, way: Vec3| {
        let mut swing = swing(false);
        swing.app.insert_resource(TimeUpdateStrategy::FixedTimesteps(frame_ticks));
        swing.carry(way, Quat::IDENTITY);
        swing.app.update();
        let stretch = swing.strain();
        let fastest = (0..64).map(|i| swing.velocity(i).length()).fold(0.0, f32::max);
        (stretch, fastest)
    };
    for ticks in [1, 2, 4, 16] {
        let (strain, fastest) = jump(ticks, Vec3::X * 10.0);
        assert!(strain < 0.03 && fastest < 10.0, "{ticks} ticks: {strain}, {fastest} m/s");
    }
}

#[test]
fn what_teleports_with_the_cloth_does_not_sweep_through_it() {
    let drape = |way: Vec3| {
        let mut app = app();
        let root = spawn(&mut app, Transform::default());
        spawn(&mut app, (SdfCollider::from(Sphere::new(0.3)), ChildOf(root)));
        let place = Transform::from_xyz(0.0, 0.32, 0.0);
        let cloth = spawn(&mut app, (sheet(), place, ChildOf(root)));
        updates(&mut app, 40);
        transform(&mut app, root).translation += way;
        let mut fastest = 0.0_f32;
        for _ in 0..10 {
            app.update();
            let running = simulation(&app, cloth);
            let speeds = (0..64).map(|i| running.velocity(i).unwrap().length());
            fastest = fastest.max(speeds.fold(0.0, f32::max));
        }
        let places: Vec<_> = positions(&app, cloth).into_iter().map(|p| p - way).collect();
        (places, fastest)
    };
    let (stayed, speed) = drape(Vec3::ZERO);
    let (moved, moved_speed) = drape(Vec3::new(0.0, 0.0, 16.0));
    assert!((speed - moved_speed).abs() < 0.05, "{speed} {moved_speed}");
    for (a, b) in stayed.iter().zip(&moved) {
        assert!(a.distance(*b) < 2e-3, "{a} {b}");
    }
}

#[test]
fn a_collider_that_is_put_elsewhere_sweeps_nothing_on_its_way() {
    let run = |way: Option<f32>| {
        let mut app = app();
        let pins = ClothPins::from(PinSelection::FirstRow);
        let cloth = spawn(&mut app, (sheet(), pins));
        let place = Transform::from_xyz(-6.0, -0.5, 0.0);
        let ball = spawn(&mut app, (SdfCollider::from(Sphere::new(0.4)), place));
        updates(&mut app, 25);
        if let Some(way) = way {
            transform(&mut app, ball).translation.x += way;
        }
        updates(&mut app, 5);
        bits(&app, cloth)
    };
    let alone = run(None);
    assert_eq!(run(Some(12.0)), alone);
    // What goes its way does.
    assert_ne!(run(Some(9.0)), alone);
}

#[test]
fn a_reset_cloth_is_at_rest_in_its_rest_shape() {
    for anchored in [false, true] {
        let mut swing = swing(anchored);
        // A slow way: no teleport.
        for _ in 0..30 {
            swing.carry(Vec3::new(0.1, 0.0, 0.05), Quat::IDENTITY);
            swing.app.update();
        }
        let entity = swing.cloth;
        swing.app.world_mut().trigger(ResetCloth { entity });
        swing.app.update();
        let way = Vec3::new(3.0, 0.0, 1.5);
        let corner = |x, z| Vec3::new(x, 0.0, z) + way;
        // One tick of falling from rest is a few millimetres.
        for (particle, x, z) in [(0, -0.5, -0.5), (7, 0.5, -0.5), (56, -0.5, 0.5), (63, 0.5, 0.5)] {
            let place = position(&swing.app, swing.cloth, particle);
            assert!(place.distance(corner(x, z)) < 5e-3, "{place}, anchored {anchored}");
            assert!(swing.velocity(particle).length() < 0.2);
        }
        assert!(swing.strain() < 0.01);
        updates(&mut swing.app, 30);
        assert!(position(&swing.app, swing.cloth, 63).y < -0.3);
    }
}

/// Speeds up along x and turns about y, everything that carries it.
#[derive(Component, Clone, Copy)]
struct Rides {
    speed: f32,
    turning: f32,
}

fn ride(mut riders: Query<(&mut Transform, &mut Rides)>) {
    for (mut transform, mut rides) in &mut riders {
        rides.speed += 0.002;
        transform.translation.x += rides.speed;
        let turning = rides.turning;
        transform.rotate_y(turning);
    }
}

/// A sheet on a carriage, held by a row, or free on a floor that rides along: places in the carriage's
/// frame after 90 ticks.
fn carriage(free: bool, rides: Option<Rides>, inertia: Option<ClothInertia>) -> Vec<Vec3> {
    let mut app = app();
    app.add_systems(FixedUpdate, ride);
    let root = spawn(&mut app, Transform::default());
    let floor = SdfCollider::from(Cuboid::new(9.0, 1.0, 9.0)).with_friction(0.02);
    let (floor_at, pins) = if free {
        (-0.51, ClothPins::none())
    } else {
        (-9.0, ClothPins::from(PinSelection::FirstRow))
    };
    spawn(&mut app, (floor, Transform::from_xyz(0.0, floor_at, 0.0), ChildOf(root)));
    let cloth = spawn(&mut app, (sheet(), pins, ClothSleepThreshold::NEVER, ChildOf(root)));
    updates(&mut app, 2);
    if let Some(rides) = rides {
        app.world_mut().entity_mut(root).insert(rides);
    }
    if let Some(inertia) = inertia {
        app.world_mut().entity_mut(cloth).insert(inertia);
    }
    updates(&mut app, 90);
    let back = app.world().get::<Transform>(root).unwrap().compute_affine().inverse();
    positions(&app, cloth).iter().map(|p| back.transform_point3(*p)).collect()
}

#[test]
fn without_inertia_a_carriage_that_speeds_up_is_at_rest() {
    for free in [false, true] {
        let still = carriage(free, None, None);
        for turning in [0.0, 0.03] {
            let what = format!("free {free}, turning {turning}");
            let rides = Some(Rides { speed: 0.0, turning });
            let away = |inertia| farthest(&carriage(free, rides, inertia), &still);
            let without = away(Some(ClothInertia::new(0.0)));
            assert!(without < 5e-3, "{what}: {without}");
            let with = away(None);
            assert!(with > 0.2, "{what}: {with}");
            if turning == 0.0 {
                let part = away(Some(ClothInertia::new(0.3)));
                assert!(part > 0.1 * with && part < 0.7 * with, "{what}: {part} of {with}");
            }
        }
    }
}

#[test]
fn full_inertia_is_as_if_there_were_no_component() {
    let rides = Some(Rides { speed: 0.0, turning: 0.03 });
    let full = Some(ClothInertia::default());
    assert_eq!(carriage(false, rides, None), carriage(false, rides, full));
}

#[test]
fn shifts_and_turns_have_inertia_of_their_own() {
    let still = carriage(false, None, None);
    let shifts = Some(Rides { speed: 0.0, turning: 0.0 });
    let linear = ClothInertia { linear: 0.0, angular: 1.0 };
    assert!(farthest(&carriage(false, shifts, Some(linear)), &still) < 5e-3);
    let angular = ClothInertia { linear: 1.0, angular: 0.0 };
    assert_eq!(carriage(false, shifts, Some(angular)), carriage(false, shifts, None));
}

#[test]
fn an_entity_that_leaves_the_numbers_takes_no_cloth_along() {
    for bad in [Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::X * 1e30] {
        for pins in [ClothPins::none(), ClothPins::from(PinSelection::FirstRow)] {
            let mut app = app();
            let cloth = spawn(&mut app, (sheet(), pins.clone()));
            let good = spawn(&mut app, sheet());
            updates(&mut app, 5);
            transform(&mut app, cloth).translation = bad;
            updates(&mut app, 3);
            // A free cloth wants nothing of an entity that is merely too far away.
            if !(bad.is_finite() && pins == ClothPins::none()) {
                let error = failure(&app, cloth).expect("it is told").to_string();
                assert!(error.contains(&cloth.to_string()), "{error}");
            }
            assert!(positions(&app, cloth).iter().all(|p| p.is_finite() && p.length() < 2.0));
            assert_eq!(failure(&app, good), None);
            assert_eq!(simulation(&app, good).tick_count(), 8);
            transform(&mut app, cloth).translation = Vec3::ZERO;
            updates(&mut app, 3);
            assert_eq!(failure(&app, cloth), None, "{bad}");
        }
    }
}
