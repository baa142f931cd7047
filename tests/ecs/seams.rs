//! Features together, on a sheet and on a mesh that is no grid. Truths: bit equality (forms, frame rates, what
//! ought to change nothing), places and velocities that a rigid motion leaves as they were, weights in
//! balance, and that no particle is ever inside.

use crate::support::app::*;
use bevy::{prelude::*, time::TimeUpdateStrategy};
use bevy_drape::{
    ClothExecution, ClothGravityOverride, ClothInertia, ClothPaused, ClothSleepThreshold,
    ClothTeleport, ClothWeights, ClothWindOverride, ColliderImpulse, ColorChannel, VertexFactor,
    prelude::*,
    solver::{Gusts, MassLumping, StretchMethod},
};

/// A metre of cloth, 8 x 8: the sheet, or a mesh of the same vertices with one cell cut out, its first
/// row painted red.
fn cloth(app: &mut App, graph: bool) -> Entity {
    if !graph {
        return spawn(app, sheet());
    }
    let mut mesh = holed_mesh();
    let red = |v: usize| [if v < 8 { 1.0 } else { 0.0 }, 0.0, 0.0, 1.0];
    mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, (0..64).map(red).collect::<Vec<_>>());
    let mesh = Mesh3d(add_mesh(app, mesh));
    spawn(app, (Cloth::of_mesh3d(), mesh))
}

fn insert(app: &mut App, entity: Entity, bundle: impl Bundle) {
    app.world_mut().entity_mut(entity).insert(bundle);
}

fn first_row() -> ClothPins {
    ClothPins::vertices(0..8)
}

fn check_is_graph(app: &App, entity: Entity, graph: bool) {
    assert_eq!(simulation(app, entity).lattice().is_none(), graph);
}

/// What happens to the cloths, tick by tick, in the fixed loop.
#[derive(Resource, Default)]
struct Script {
    tick: u32,
    anchor: Option<Entity>,
    ball: Option<Entity>,
}

fn play(
    mut script: ResMut<Script>,
    cloths: Query<Entity, With<Cloth>>,
    mut transforms: Query<&mut Transform>,
    mut settings: Query<&mut ClothSettings>,
    mut materials: Query<&mut ClothMaterial>,
    mut commands: Commands,
) {
    script.tick += 1;
    let tick = script.tick;
    let mut at = |entity: Option<Entity>, act: &dyn Fn(&mut Transform)| {
        if let Some(mut transform) = entity.and_then(|entity| transforms.get_mut(entity).ok()) {
            act(&mut transform);
        }
    };
    at(script.anchor, &|t| {
        t.translation += Vec3::new(0.02, 0.01, -0.01);
        t.rotate_y(0.03);
        t.rotate_z(0.01);
    });
    // At 128 m/s, to and fro.
    let side = if tick.is_multiple_of(8) { 2.0 } else { -2.0 };
    at(script.ball, &|t| {
        if tick.is_multiple_of(4) {
            t.translation.y += side;
        }
    });
    if tick == 24 {
        at(script.anchor, &|t| t.translation += Vec3::new(7.3, 0.0, 2.1));
        at(script.ball, &|t| t.translation += Vec3::new(7.3, 0.0, 2.1));
    }
    for entity in &cloths {
        let mut commands = commands.entity(entity);
        match tick {
            8 => {
                let mass = (0..64).map(|v| 0.5 + v as f32 / 32.0).collect();
                let mass = VertexFactor::Data(mass);
                commands.insert(ClothWeights { mass, ..default() });
            }
            12 => settings.get_mut(entity).unwrap().masses = MassLumping::Equal,
            14 => materials.get_mut(entity).unwrap().flexural_rigidity = 1e-4,
            16 => {
                commands.insert(ClothAir { lift: 0.2, ..default() });
            }
            18 => settings.get_mut(entity).unwrap().stretch_method = StretchMethod::ImplicitThreads,
            28 => {
                commands.insert(ClothPaused { steps: 1 });
            }
            32 => {
                commands.remove::<ClothPaused>();
            }
            36 => {
                commands.trigger(|entity| ResetCloth { entity });
            }
            40 => {
                commands.insert(ClothInertia::new(0.0));
            }
            _ => {}
        }
    }
}

#[test]
fn everything_at_once_gives_the_same_bits_in_both_forms_at_every_frame_rate() {
    let run = |graph: bool, strategy: TimeUpdateStrategy, execution: ClothExecution| {
        let mut app = app();
        app.insert_resource(execution).init_resource::<Script>().add_systems(FixedUpdate, play);
        let gusts = Gusts { strength: 2.0, seed: 5, ..default() };
        app.insert_resource(ClothWind::steady(Vec3::new(1.0, 0.0, 2.0)).with_gusts(gusts));
        let anchor = spawn(&mut app, Transform::from_xyz(0.0, 0.2, -0.5));
        let zone = WindZone::radial(Sphere::new(1.5), 4.0);
        spawn(&mut app, (zone, Transform::from_xyz(0.2, -1.0, 0.0)));
        let ball = SdfCollider::from(Sphere::new(0.2));
        let ball = (ball, ColliderImpulse::default(), Transform::from_xyz(0.1, 1.0, 0.2));
        let ball = spawn(&mut app, ball);
        app.insert_resource(Script { tick: 0, anchor: Some(anchor), ball: Some(ball) });
        let cloth = cloth(&mut app, graph);
        let hard = ClothPins::vertices([0, 1]).anchored_to(anchor);
        let soft = ClothPins::vertices(2..8).anchored_to(anchor).softly(120.0, 3.0);
        let inertia = ClothInertia::new(0.4);
        insert(&mut app, cloth, (hard.and(soft), ClothAir::default(), inertia));
        app.insert_resource(strategy);
        let mut pushed = false;
        while app.world().get::<ClothSimulation>(cloth).is_none_or(|c| c.tick_count() < 45) {
            app.update();
            pushed |= app.world().get::<ColliderImpulse>(ball).unwrap().linear != Vec3::ZERO;
        }
        check_is_graph(&app, cloth, graph);
        assert_eq!(failure(&app, cloth), None);
        assert!(positions(&app, cloth).iter().all(|p| p.is_finite()));
        assert!(simulation(&app, cloth).strain().max < 0.5);
        (bits(&app, cloth), pushed)
    };
    let (fused, staged) = (ClothExecution::Fused, ClothExecution::Staged);
    for graph in [false, true] {
        let (one, pushed) = run(graph, TimeUpdateStrategy::FixedTimesteps(1), fused);
        assert!(pushed, "the ball has met the cloth");
        assert!(one == run(graph, TimeUpdateStrategy::FixedTimesteps(1), staged).0, "staged");
        assert!(one == run(graph, TimeUpdateStrategy::FixedTimesteps(3), staged).0, "slow frames");
        let quick = TimeUpdateStrategy::ManualDuration(TICK / 5 * 2);
        assert!(one == run(graph, quick, fused).0, "quick frames");
    }
}

/// A cloth over a ball on the ground, soft pins and air included.
struct Resting {
    app: App,
    cloth: Entity,
    ball: Entity,
    anchor: Entity,
}

fn resting(graph: bool) -> Resting {
    let mut app = app();
    let ball = spawn(&mut app, SdfCollider::from(Sphere::new(0.3)).with_friction(0.9));
    let anchor = spawn(&mut app, Transform::from_xyz(-0.5, 0.32, -0.5));
    let cloth = cloth(&mut app, graph);
    let pins = ClothPins::vertices([0]).anchored_to(anchor).softly(20.0, 2.0);
    let material = ClothMaterial { damping: 0.01, ..default() };
    let thick = ClothAir { density: 12.0, ..default() };
    let place = Transform::from_xyz(0.0, 0.32, 0.0);
    // What quadratic drag alone slows swings a little for long.
    let sleep = ClothSleepThreshold { distance: 0.05, time: 0.5 };
    insert(&mut app, cloth, (pins, material, thick, sleep, place));
    for tick in 0.. {
        app.update();
        if simulation(&app, cloth).is_asleep() {
            break;
        }
        assert!(tick < 3000, "graph {graph}: awake, {:?}", simulation(&app, cloth).last_tick());
    }
    check_is_graph(&app, cloth, graph);
    updates(&mut app, 2);
    Resting { app, cloth, ball, anchor }
}

#[test]
fn soft_pins_air_layers_weights_and_zones_wake_what_sleeps() {
    type Act = fn(&mut Resting);
    let near = |s: &mut Resting| {
        let zone = WindZone::radial(Sphere::new(0.2), 1.0);
        spawn(&mut s.app, (zone, Transform::from_xyz(0.0, 0.3, 0.0)));
    };
    let causes: [(&str, Act); 11] = [
        ("a soft anchor moves", |s| transform(&mut s.app, s.anchor).translation.x += 0.001),
        ("a soft anchor goes", |s| _ = s.app.world_mut().despawn(s.anchor)),
        ("a soft pin is stiffer", |s| {
            let pins = ClothPins::vertices([0]).anchored_to(s.anchor).softly(30.0, 2.0);
            insert(&mut s.app, s.cloth, pins);
        }),
        ("other air", |s| insert(&mut s.app, s.cloth, ClothAir::default())),
        ("no air", |s| _ = s.app.world_mut().entity_mut(s.cloth).remove::<ClothAir>()),
        ("weights", |s| {
            let mass = VertexFactor::Data(vec![2.0; 64]);
            insert(&mut s.app, s.cloth, ClothWeights { mass, ..default() });
        }),
        ("masses", |s| {
            let mut settings = s.app.world_mut().get_mut::<ClothSettings>(s.cloth).unwrap();
            settings.masses = MassLumping::Equal;
        }),
        ("its layers", |s| {
            s.app.world_mut().get_mut::<ClothSettings>(s.cloth).unwrap().layers = 1.into();
        }),
        ("the collider's layers", |s| {
            s.app.world_mut().get_mut::<SdfCollider>(s.ball).unwrap().layers = 2.into();
        }),
        ("wind", |s| _ = s.app.insert_resource(ClothWind::steady(Vec3::X * 0.1))),
        ("a zone", near),
    ];
    for (cause, act) in causes {
        let mut scene = resting(true);
        let count = simulation(&scene.app, scene.cloth).tick_count();
        act(&mut scene);
        scene.app.update();
        let simulation = simulation(&scene.app, scene.cloth);
        assert_eq!(simulation.tick_count(), count + 1, "{cause}");
        assert_eq!(failure(&scene.app, scene.cloth).is_some(), cause == "a soft anchor goes");
    }
    for graph in [false, true] {
        let mut scene = resting(graph);
        let count = simulation(&scene.app, scene.cloth).tick_count();
        // Wind that does not blow, and one that blows elsewhere.
        let gusts = Gusts { seed: 9, period: 3.0, ..default() };
        scene.app.insert_resource(ClothWind::default().with_gusts(gusts));
        let away = Transform::from_xyz(9.0, 0.0, 0.0);
        spawn(&mut scene.app, (WindZone::radial(Sphere::new(2.0), 9.0), away));
        updates(&mut scene.app, 4);
        assert_eq!(simulation(&scene.app, scene.cloth).tick_count(), count);
    }
}

#[test]
fn weights_of_one_given_to_a_running_cloth_change_no_bit() {
    for (graph, place) in [(false, 0.0), (true, 0.0), (false, 20_000.3), (true, 20_000.3)] {
        let run = |weigh: bool| {
            let mut app = app();
            app.insert_resource(ClothWind::steady(Vec3::new(2.0, 0.5, 1.0)));
            let place = Vec3::new(place, 0.0, -place);
            let anchor = spawn(&mut app, Transform::from_translation(place));
            let ball = SdfCollider::from(Sphere::new(0.3));
            spawn(&mut app, (ball, Transform::from_translation(place + Vec3::NEG_Y * 0.4)));
            let cloth = cloth(&mut app, graph);
            let soft = ClothPins::vertices([7, 8]).anchored_to(anchor).softly(50.0, 1.0);
            let pins = ClothPins::vertices([0]).and(soft);
            let place = Transform::from_translation(place);
            insert(&mut app, cloth, (pins, ClothAir::default(), place));
            updates(&mut app, 20);
            if weigh {
                let mass = VertexFactor::Data(vec![1.0; 64]);
                insert(&mut app, cloth, ClothWeights { mass, ..default() });
            }
            let mut seen = Vec::new();
            for _ in 0..20 {
                app.update();
                seen.push(bits(&app, cloth));
            }
            seen.push(
                drawn_positions(&app, cloth)
                    .iter()
                    .map(|p| p.to_array().map(f32::to_bits))
                    .collect(),
            );
            assert_eq!(simulation(&app, cloth).pinned(), &[0]);
            seen
        };
        assert!(run(true) == run(false), "graph {graph}, at {place} m");
    }
}

#[test]
fn air_that_is_refused_leaves_the_last_good_air_whatever_else_changes() {
    let run = |bad: bool| {
        let mut app = app();
        let cloth = cloth(&mut app, true);
        insert(&mut app, cloth, ClothAir { density: 20.0, ..default() });
        updates(&mut app, 5);
        if bad {
            insert(&mut app, cloth, ClothAir { density: f32::NAN, ..default() });
        }
        app.world_mut().get_mut::<ClothSettings>(cloth).unwrap().masses = MassLumping::Equal;
        updates(&mut app, 20);
        assert_eq!(failure(&app, cloth).is_some(), bad);
        bits(&app, cloth)
    };
    assert!(run(true) == run(false));
}

/// Entities that move by a way and a turn about z in each tick.
#[derive(Component)]
struct Rides(Vec3, f32);

fn ride(mut riders: Query<(&mut Transform, &Rides)>) {
    for (mut transform, rides) in &mut riders {
        transform.translation += rides.0;
        transform.rotate_z(rides.1);
    }
}

#[test]
fn velocities_are_those_in_the_world_in_a_ride_too() {
    for graph in [false, true] {
        let mut app = app();
        app.add_systems(FixedUpdate, ride);
        let cloth = cloth(&mut app, graph);
        let still = ClothGravityOverride(Vec3::ZERO);
        let pins = ClothPins::vertices([0, 7]);
        insert(&mut app, cloth, (ClothInertia::new(0.0), still, pins, ClothSleepThreshold::NEVER));
        updates(&mut app, 2);
        insert(&mut app, cloth, Rides(Vec3::new(0.1, 0.0, 0.05), 0.01));
        updates(&mut app, 10);
        let before = positions(&app, cloth);
        app.update();
        for (i, before) in before.iter().enumerate() {
            let gone = (position(&app, cloth, i) - before) / TICK.as_secs_f32();
            let velocity = simulation(&app, cloth).velocity(i).unwrap();
            assert!(gone.length() > 5.0 && velocity.distance(gone) < 0.01, "{velocity}, {gone}");
        }
        let asked = Vec3::new(1.0, 2.0, 3.0);
        let mut running = app.world_mut().get_mut::<ClothSimulation>(cloth).unwrap();
        running.set_velocities(|_| asked);
        for i in [1, 20, 63] {
            assert!(running.velocity(i).unwrap().distance(asked) < 1e-4);
        }
    }
}

#[test]
fn the_wind_keeps_its_direction_in_a_ride_that_turns() {
    const TURN: f32 = 0.2;
    for graph in [false, true] {
        let mut app = app();
        let cloth = cloth(&mut app, graph);
        let air = ClothAir { lift: 0.0, ..default() };
        let still = ClothGravityOverride(Vec3::ZERO);
        insert(&mut app, cloth, (air, still, ClothInertia::new(0.0), ClothSleepThreshold::NEVER));
        updates(&mut app, 3);
        app.insert_resource(ClothWind::steady(Vec3::Y * 2.0));
        transform(&mut app, cloth).rotate_z(TURN);
        app.update();
        // What it gains at a time of the tick turns with it for the rest: by half the turn on the mean.
        let gained = positions(&app, cloth).iter().sum::<Vec3>() / 64.0;
        let angle = (-gained.x).atan2(gained.y);
        assert!(gained.y > 1e-4 && (angle - 0.5 * TURN).abs() < 0.02, "{gained}: {angle}");
    }
}

#[test]
fn impulses_are_in_the_worlds_axes_in_a_ride_that_turns() {
    const TURN: f32 = 0.04;
    for graph in [false, true] {
        let mut app = app();
        app.add_systems(FixedUpdate, ride);
        let floor = SdfCollider::from(InfinitePlane3d::default()).with_friction(0.0);
        let floor = spawn(&mut app, (floor, ColliderImpulse::default()));
        let cloth = cloth(&mut app, graph);
        let place = Transform::from_xyz(0.0, 0.006, 0.0);
        insert(&mut app, cloth, (ClothInertia::new(0.0), ClothSleepThreshold::NEVER, place));
        updates(&mut app, 4);
        insert(&mut app, cloth, Rides(Vec3::ZERO, TURN));
        let mut sum = Vec3::ZERO;
        for _ in 0..8 {
            app.update();
            sum += app.world().get::<ColliderImpulse>(floor).unwrap().linear;
        }
        // A floor without friction is pushed down, and nowhere else.
        assert!(sum.y < -0.01 && sum.x.abs() < 0.25 * TURN * sum.y.abs(), "{sum}");
    }
}

#[test]
fn a_still_collider_is_met_by_what_rides_past_it() {
    for (graph, speed) in [(false, 0.05), (true, 0.05), (false, 1.5), (true, 1.5)] {
        let mut app = app();
        app.add_systems(FixedUpdate, ride);
        let ball = SdfCollider::from(Sphere::new(0.4));
        spawn(&mut app, (ball, Transform::from_xyz(3.0, -0.5, 0.0)));
        let cloth = cloth(&mut app, graph);
        let pins = first_row();
        insert(&mut app, cloth, (ClothInertia::new(0.0), pins, ClothSleepThreshold::NEVER));
        updates(&mut app, 40);
        insert(&mut app, cloth, Rides(Vec3::X * speed, 0.0));
        let mut nearest = f32::INFINITY;
        for _ in 0..(5.0 / speed) as usize {
            app.update();
            for p in positions(&app, cloth) {
                nearest = nearest.min(p.distance(Vec3::new(3.0, -0.5, 0.0)));
            }
        }
        assert!(nearest > 0.4, "graph {graph}, {speed} m a tick: {nearest}");
        assert!(nearest < 0.5 || speed > 1.0, "it has gone past: {nearest}");
    }
}

#[test]
fn a_teleport_into_a_zone_is_felt_at_once() {
    for graph in [false, true] {
        let mut app = app();
        let zone = WindZone::directional(Sphere::new(3.0), Vec3::Y * 3.0);
        spawn(&mut app, (zone, Transform::from_xyz(60.0, 0.0, 0.0)));
        let cloth = cloth(&mut app, graph);
        let material = ClothMaterial { area_density: 1e-3, ..default() };
        insert(&mut app, cloth, (material, ClothGravityOverride(Vec3::ZERO), ClothAir::default()));
        updates(&mut app, 5);
        transform(&mut app, cloth).translation.x = 60.0;
        app.update();
        assert!(mean_velocity(&app, cloth).y > 1.0, "in");
        transform(&mut app, cloth).translation.x = 20.0;
        updates(&mut app, 20);
        assert!(mean_velocity(&app, cloth).length() < 0.3, "out again");
        let entity = cloth;
        transform(&mut app, cloth).translation.x = 60.0;
        app.world_mut().trigger(ResetCloth { entity });
        app.update();
        assert!(mean_velocity(&app, cloth).y > 1.0, "put in");
    }
}

/// A cloth of two anchors, the first of them hard where asked; where it is after a tick and after a
/// third of a second in which some of the anchors have jumped by `way`.
fn two_anchors(graph: bool, hard: bool, jumps: &[usize], way: Vec3) -> [Vec<Vec3>; 2] {
    let mut app = app();
    let anchors = [-0.5, 0.5].map(|x| spawn(&mut app, Transform::from_xyz(x, 0.0, -0.5)));
    let cloth = cloth(&mut app, graph);
    let first = ClothPins::vertices([0, 1, 2]).anchored_to(anchors[0]);
    let first = if hard { first } else { first.softly(300.0, 8.0) };
    let second = ClothPins::vertices([6, 7]).anchored_to(anchors[1]).softly(300.0, 8.0);
    insert(&mut app, cloth, first.and(second));
    updates(&mut app, 30);
    for &jumps in jumps {
        transform(&mut app, anchors[jumps]).translation += way;
    }
    [1, 20].map(|ticks| {
        updates(&mut app, ticks);
        assert_eq!(failure(&app, cloth), None);
        positions(&app, cloth)
    })
}

#[test]
fn soft_anchors_teleport_together_or_not_at_all() {
    let way = Vec3::new(6.1, 0.0, 0.0);
    for graph in [false, true] {
        for hard in [false, true] {
            let stays = two_anchors(graph, hard, &[], way);
            let together = two_anchors(graph, hard, &[0, 1], way);
            for (there, here) in together.iter().flatten().zip(stays.iter().flatten()) {
                assert!(there.distance(*here + way) < 1e-3, "{there} {here}");
            }
            let [parted, later] = two_anchors(graph, hard, &[0], way);
            // What holds hard takes it along; of two that pull, none.
            let carried = parted[63].x > stays[0][63].x + 0.5 * way.x;
            assert_eq!(carried, hard, "{}", parted[63]);
            assert!(later.iter().all(|p| p.is_finite()));
        }
    }
}

#[test]
fn painted_vertices_hold_softly_with_the_weight_over_the_stiffness() {
    let mut app = app();
    let cloth = cloth(&mut app, true);
    let pins = ClothPins::color(ColorChannel::Red, 0.5).softly(40.0, 12.0);
    let hanging = Transform::from_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2));
    let material = ClothMaterial { drag: 4.0, ..default() };
    insert(&mut app, cloth, (pins, hanging, material, ClothSleepThreshold::NEVER));
    updates(&mut app, 500);
    let running = simulation(&app, cloth);
    let weight = 9.81 * (0..64).map(|i| running.mass(i).unwrap()).sum::<f32>();
    let lowered = (0..8).map(|i| 0.5 - position(&app, cloth, i).y).sum::<f32>() / 8.0;
    assert!((lowered - weight / 40.0).abs() < 0.01 * lowered, "{lowered}, {}", weight / 40.0);
}

#[test]
fn freezing_keeps_soft_pins_air_and_a_ride_as_they_were() {
    for graph in [false, true] {
        let run = |frozen: bool| {
            let mut app = app();
            app.insert_resource(ClothWind::steady(Vec3::new(1.0, 0.0, 3.0)));
            let cloth = cloth(&mut app, graph);
            let pins = first_row().softly(100.0, 2.0);
            insert(&mut app, cloth, (pins, ClothAir::default(), ClothInertia::new(0.5)));
            updates(&mut app, 15);
            if frozen {
                insert(&mut app, cloth, ClothPaused::default());
                updates(&mut app, 20);
                app.world_mut().entity_mut(cloth).remove::<ClothPaused>();
            }
            updates(&mut app, 10);
            bits(&app, cloth)
        };
        assert!(run(true) == run(false), "graph {graph}");
    }
}

#[test]
fn a_cloth_that_was_held_by_a_fault_takes_hold_where_it_is() {
    // Its entity goes a metre and a half while the wind is bad; a jump would tear at the first row.
    for graph in [false, true] {
        let mut app = app();
        let cloth = cloth(&mut app, graph);
        insert(&mut app, cloth, (first_row(), ClothAir::default(), ClothTeleport::NEVER));
        updates(&mut app, 20);
        let bad = ClothWind::steady(Vec3::NAN);
        insert(&mut app, cloth, ClothWindOverride(bad));
        for _ in 0..15 {
            transform(&mut app, cloth).translation.x += 0.1;
            app.update();
        }
        assert!(failure(&app, cloth).is_some());
        app.world_mut().entity_mut(cloth).remove::<ClothWindOverride>();
        app.update();
        assert_eq!(failure(&app, cloth), None);
        assert!(position(&app, cloth, 0).distance(Vec3::new(1.0, 0.0, -0.5)) < 1e-4);
        // Led there in a tick, not in a substep.
        let led = simulation(&app, cloth).velocity(0).unwrap().length();
        assert!((led - 1.5 * 64.0).abs() < 5.0, "{led} m/s");
    }
}
