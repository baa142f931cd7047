//! A cloth that is held near an animated pose. Truths: no particle is further from its place than its max distance, or in its backstop,
//! at any tick's end, whatever the pose does; a drive is a critically damped spring; what is bounded by nothing has the bits of a
//! cloth without a skin, and so have the forms of the step, the threads and what is saved; bad limits are refused by name.

use bevy::math::{DVec3, Quat, Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    Backstop, ClothSolver, Collider, MassLumping, Material, Pose, Settings, SkinLimit, SkinMotion,
    SolverError, StepInput, Topology,
};

use crate::support::{dice::Dice, solver::*};

/// Most that a particle is beyond its bounds at a tick's end \[m\].
const CLOSE: f64 = 1e-4;

fn square(n: usize) -> Topology {
    sheet(Vec2::ONE, n, n, MassLumping::Lumped).into()
}

fn irregular(n: usize) -> Topology {
    let (positions, triangles) = jittered(n, n, 1.0 / (n - 1) as f32, 0.3, 7);
    let graph = bevy_drape::solver::Graph::new(&positions, &triangles, MassLumping::Lumped);
    std::sync::Arc::new(graph.unwrap()).into()
}

/// A pose that walks, turns and, in its second second, dashes by 5 m in 0.1 s.
fn pose(time: f32) -> Pose {
    let dash = ((time - 1.0) / 0.1).clamp(0.0, 1.0) * 5.0;
    Pose {
        translation: Vec3::new(dash + 1.5 * time, 0.05 * (12.0 * time).sin(), 0.0),
        rotation: Quat::from_rotation_y(0.8 * (5.0 * time).sin()),
        ..Pose::IDENTITY
    }
}

fn placed(pose: &Pose, p: Vec3) -> Vec3 {
    pose.rotation * p + pose.translation
}

/// Places on the skin of a flat shape that goes along with a pose.
fn motions(rest: &[Vec3], tick: usize) -> Vec<SkinMotion> {
    let poses = [tick, tick + 1].map(|tick| pose(tick as f32 * TICK));
    rest.iter()
        .map(|&p| SkinMotion {
            place: [placed(&poses[0], p), placed(&poses[1], p)],
            normal: [poses[0].rotation * Vec3::Y, poses[1].rotation * Vec3::Y],
        })
        .collect()
}

/// Limits that differ from particle to particle: planes, balls small and large, before and behind the place.
fn varied(count: usize) -> Vec<SkinLimit> {
    let mut dice = Dice(5);
    let mut roll = |from: f32, to: f32| from + (to - from) * (0.5 + 0.5 * dice.vector().x);
    let limit = |k: usize| {
        let max_distance = roll(0.01, 0.15);
        let distance = roll(-0.9 * max_distance, 0.05);
        let radius = if k.is_multiple_of(3) { f32::INFINITY } else { roll(0.2, 1.0) };
        let backstop = (!k.is_multiple_of(7)).then_some(Backstop { distance, radius });
        SkinLimit { max_distance, backstop, drive: if k.is_multiple_of(5) { 4.0 } else { 0.0 } }
    };
    (0..count).map(limit).collect()
}

/// How far particles are beyond their max distance, and in their backstops, at most \[m\].
fn violation(solver: &ClothSolver, motions: &[SkinMotion]) -> f64 {
    let limits = solver.skin().unwrap();
    let each = limits.iter().zip(motions).enumerate().map(|(particle, (limit, motion))| {
        let [place, normal] = [motion.place[1], motion.normal[1]].map(Vec3::as_dvec3);
        let off: DVec3 = solver.position(particle).as_dvec3() - place;
        let beyond = off.length() - f64::from(limit.max_distance);
        let inside = limit.backstop.map_or(f64::NEG_INFINITY, |Backstop { distance, radius }| {
            let (distance, radius) = (f64::from(distance), f64::from(radius));
            if radius.is_infinite() {
                return -distance - off.dot(normal.normalize());
            }
            radius - (off + normal.normalize() * (distance + radius)).length()
        });
        beyond.max(inside)
    });
    each.fold(f64::NEG_INFINITY, f64::max)
}

/// The worst violation of a cloth that is led through the pose for some ticks.
fn led(solver: &mut ClothSolver, ticks: usize, colliders: &[Collider]) -> f64 {
    let rest = solver.topology().rest_positions().to_vec();
    let mut worst = f64::NEG_INFINITY;
    for tick in 0..ticks {
        let skin = motions(&rest, tick);
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            skin: &skin,
            colliders,
            ..StepInput::default()
        };
        solver.tick(&input).unwrap();
        worst = worst.max(violation(solver, &skin));
    }
    worst
}

#[test]
fn no_particle_leaves_its_bounds_whatever_the_pose_does() {
    for (what, topology) in [("sheet", square(33)), ("mesh", irregular(24))] {
        let mut solver = at_rest(&topology, Vec3::ZERO, usual(), Settings::default());
        let limits = varied(topology.particle_count());
        solver.set_skin(Some(&limits)).unwrap();
        check_at_most(&format!("{what}: beyond"), led(&mut solver, 180, &[]), CLOSE);
        // It is held by nothing else: without them it falls.
        let mut free = at_rest(&topology, Vec3::ZERO, usual(), Settings::default());
        let loose = vec![SkinLimit::default(); topology.particle_count()];
        free.set_skin(Some(&loose)).unwrap();
        led(&mut free, 30, &[]);
        let skin = motions(topology.rest_positions(), 29);
        free.set_skin(Some(&limits)).unwrap();
        assert!(violation(&free, &skin) > 0.3, "{what}: {}", violation(&free, &skin));
    }
}

/// A collider that pushes cloth out of its bounds does so within a tick at most.
#[test]
fn colliders_do_not_push_it_out_of_its_bounds() {
    let ball = Sphere::new(0.3);
    let at = Pose { translation: Vec3::new(0.3, -0.25, 0.2), ..Pose::IDENTITY };
    let mut solver = at_rest(&square(33), Vec3::ZERO, usual(), Settings::default());
    let near = SkinLimit { max_distance: 0.02, ..SkinLimit::default() };
    solver.set_skin(Some(&vec![near; 33 * 33])).unwrap();
    check_at_most("beyond", led(&mut solver, 60, &[Collider::new(&ball, at)]), CLOSE);
}

/// Radius of the balls that press into a cloth \[m\].
const BALL: f32 = 0.12;

/// The largest that were seen at the end of a tick.
#[derive(Debug, Default)]
struct Pressed {
    beyond: f64,
    strain: f64,
    inside: f64,
    touching: u32,
}

/// Bounds and a body that go different ways: for some ticks, two balls rise into a mesh that is held around its border, and sway. All of it
/// dashes by the end of the first half second, if asked.
fn pressed(ticks: usize, dashes: bool) -> Pressed {
    let n = 24;
    let topology = irregular(n);
    let material = Material { max_strain: 0.05, ..usual() };
    let mut solver = at_rest(&topology, Vec3::ZERO, material, Settings::default());
    let rest = topology.rest_positions().to_vec();
    let limit = |k: usize| {
        let is_border = [k / n, k % n].into_iter().any(|i| i == 0 || i + 1 == n);
        let max_distance = if is_border { 0.02 } else { 0.4 };
        SkinLimit { max_distance, ..SkinLimit::default() }
    };
    solver.set_skin(Some(&(0..n * n).map(limit).collect::<Vec<_>>())).unwrap();
    let ball = Sphere::new(BALL);
    let low = rest.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let dash = |tick: usize| {
        let part = ((tick as f32 * TICK - 0.5) / 0.1).clamp(0.0, 1.0);
        if dashes { Vec3::new(3.0, 1.0, 4.0) * part } else { Vec3::ZERO }
    };
    let centre = |tick: usize, side: f32| {
        let time = tick as f32 * TICK;
        let rise = (time / 0.5).min(1.0) * 0.12;
        let sway = 0.1 * (8.0 * time).sin();
        let off = Vec3::new(0.5 + 0.125 * side + sway, rise - 0.13, 0.5 + sway * side);
        low + dash(tick) + off
    };
    let mut worst = Pressed::default();
    for tick in 0..ticks {
        let poses = [-1.0, 1.0].map(|side| {
            [tick, tick + 1].map(|tick| Pose { translation: centre(tick, side), ..Pose::IDENTITY })
        });
        let place = |p: Vec3| [tick, tick + 1].map(|tick| p + dash(tick));
        let motion = |&p: &Vec3| SkinMotion { place: place(p), ..SkinMotion::default() };
        let skin: Vec<_> = rest.iter().map(motion).collect();
        let colliders = poses.map(|[from, to]| Collider::new(&ball, from).moving_to(to));
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            skin: &skin,
            colliders: &colliders,
            ..StepInput::default()
        };
        let report = solver.tick(&input).unwrap();
        worst.beyond = worst.beyond.max(violation(&solver, &skin));
        worst.strain = worst.strain.max(report.max_strain.into());
        for [_, ball] in poses {
            let depths = (0..n * n).map(|k| BALL - solver.position(k).distance(ball.translation));
            worst.inside = depths.map(f64::from).fold(worst.inside, f64::max);
        }
        worst.touching = worst.touching.max(report.contact_count);
    }
    worst
}

/// Contact stretches it by 14 % where nothing follows.
#[test]
fn what_a_body_stretches_ends_within_its_limit() {
    let worst = pressed(240, false);
    println!("{worst:?}");
    check_at_most("beyond", worst.beyond, CLOSE);
    check_at_most("in a ball", worst.inside, CLOSE);
    // Passes end where none moves a spring by more than a two-thousandth.
    check_at_most("strain", worst.strain, 0.05 + 1e-3);
    assert!(worst.strain > 0.045 && worst.touching > 10, "{worst:?}");
}

/// The limit would pull it into the balls by millimetres.
#[test]
fn what_the_limit_pulls_ends_outside_of_the_body() {
    let worst = pressed(60, true);
    println!("{worst:?}");
    check_at_most("beyond", worst.beyond, CLOSE);
    check_at_most("in a ball", worst.inside, CLOSE);
    assert!(worst.strain > 0.5 && worst.touching > 10, "{worst:?}");
}

/// A cloth whose skin bounds nothing flies against two balls, and over their rims. What it loses they are given.
#[test]
fn what_it_bears_at_a_tick_s_end_is_given_to_the_body() {
    let topology = irregular(24);
    let material = Material { max_strain: 0.01, drag: 0.0, ..usual() };
    let mut solver = at_rest(&topology, Vec3::ZERO, material, Settings::default());
    let count = topology.particle_count();
    solver.set_skin(Some(&vec![SkinLimit::default(); count])).unwrap();
    for particle in 0..count {
        solver.set_velocity(particle, Vec3::new(0.0, -4.0, 0.0)).unwrap();
    }
    let skin = motions(topology.rest_positions(), 0);
    let low = topology.rest_positions().iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let ball = Sphere::new(0.1);
    let poses = [0.39, 0.61]
        .map(|x| Pose { translation: low + Vec3::new(x, -0.15, 0.5), ..Pose::IDENTITY });
    let colliders = poses.map(|pose| Collider::new(&ball, pose).measured());
    let before = momenta(&solver).0;
    let mut given = DVec3::ZERO;
    let mut worst = 0.0_f64;
    for _ in 0..30 {
        let input =
            StepInput { dt: TICK, skin: &skin, colliders: &colliders, ..StepInput::default() };
        solver.tick(&input).unwrap();
        given += (solver.impulse(0).linear + solver.impulse(1).linear).as_dvec3();
        let off = (momenta(&solver).0 + given - before).length() / before.length();
        worst = worst.max(off);
    }
    check_at_most("momentum that is gone", worst, 1e-6);
    assert!(given.y < -0.3 * before.length(), "{given} of {before}");
}

/// A ball that appears around the middle of a cloth lets it out as fast as it may, although the limit pulls at what is inside.
#[test]
fn what_is_deep_in_a_body_comes_out_by_and_by() {
    let topology = irregular(24);
    let material = Material { max_strain: 0.0, ..usual() };
    let settings = Settings { max_depenetration_speed: 0.2, ..Settings::default() };
    let mut solver = at_rest(&topology, Vec3::ZERO, material, settings);
    solver.set_skin(Some(&vec![SkinLimit::default(); topology.particle_count()])).unwrap();
    let skin = motions(topology.rest_positions(), 0);
    let low = topology.rest_positions().iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
    let ball = Sphere::new(BALL);
    let pose = Pose { translation: low + Vec3::new(0.5, -0.04, 0.5), ..Pose::IDENTITY };
    let colliders = [Collider::new(&ball, pose)];
    let before = positions(&solver);
    let input = StepInput { dt: TICK, skin: &skin, colliders: &colliders, ..StepInput::default() };
    solver.tick(&input).unwrap();
    let ways = before.iter().zip(positions(&solver)).map(|(a, b)| a.distance(b));
    // 5 mm without a skin, and 8 cm all at once.
    check_at_most("the way out", ways.fold(0.0, f32::max).into(), 0.01);
}

/// Normals are of any length, and of another one at either end of a tick.
#[test]
fn the_length_of_a_normal_does_not_matter() {
    let run = |lengths: [f32; 2]| {
        let topology = square(5);
        let mut solver = at_rest(&topology, Vec3::ZERO, usual(), Settings::default());
        let stop = Some(Backstop { distance: -0.02, radius: f32::INFINITY });
        let limit = SkinLimit { max_distance: 0.1, backstop: stop, ..SkinLimit::default() };
        solver.set_skin(Some(&[limit; 25])).unwrap();
        let normals = [Vec3::Y * lengths[0], Vec3::new(0.8, 0.6, 0.0) * lengths[1]];
        let motion = |&p: &Vec3| SkinMotion { place: [p; 2], normal: normals };
        let skin: Vec<_> = topology.rest_positions().iter().map(motion).collect();
        let input = StepInput { dt: TICK, gravity: GRAVITY, skin: &skin, ..StepInput::default() };
        solver.tick(&input).unwrap();
        positions(&solver)
    };
    let unit = run([1.0; 2]);
    let other = run([4.0, 0.25]);
    let off = unit.iter().zip(&other).map(|(a, b)| f64::from(a.distance(*b))).fold(0.0, f64::max);
    check_at_most("apart", off, 1e-6);
}

/// `x'' = -w^2 x - 2 w x'` from rest: `x = (1 + w t) exp(-w t)` of where it began.
#[test]
fn a_drive_is_a_critically_damped_spring() {
    let topology = square(5);
    let off = Vec3::new(0.1, 0.2, -0.1);
    let material = Material { drag: 0.0, ..usual() };
    let mut solver = at_rest(&topology, off, material, Settings::default());
    let drive = SkinLimit { drive: 3.0, ..SkinLimit::default() };
    solver.set_skin(Some(&[drive; 25])).unwrap();
    let still = |&p: &Vec3| SkinMotion { place: [p; 2], ..SkinMotion::default() };
    let skin: Vec<_> = topology.rest_positions().iter().map(still).collect();
    for tick in 1..=90 {
        let input = StepInput { dt: TICK, skin: &skin, ..StepInput::default() };
        solver.tick(&input).unwrap();
        let rate = 3.0 * f64::from(TICK) * f64::from(tick);
        let expected = off.as_dvec3() * (1.0 + rate) * (-rate).exp();
        let now = (solver.position(12) - topology.rest_positions()[12]).as_dvec3();
        check_at_most("from where it ought to be", now.distance(expected), 1e-3);
    }
}

#[test]
fn what_nothing_bounds_has_the_bits_of_a_cloth_without_a_skin() {
    let topology = square(17);
    let bits = |skin: bool| {
        let mut solver = at_rest(&topology, Vec3::ZERO, usual(), Settings::default());
        solver.set_pins(&[0, 16]).unwrap();
        let skin = if skin { motions(topology.rest_positions(), 0) } else { Vec::new() };
        if !skin.is_empty() {
            solver.set_skin(Some(&vec![SkinLimit::default(); skin.len()])).unwrap();
        }
        let pins = still(&solver);
        for _ in 0..60 {
            let input = StepInput {
                dt: TICK,
                gravity: GRAVITY,
                pins: &pins,
                skin: &skin,
                ..StepInput::default()
            };
            solver.tick(&input).unwrap();
        }
        positions(&solver)
    };
    assert!(bits(true) == bits(false));
}

#[test]
fn limits_that_cannot_be_are_refused() {
    let mut solver = at_rest(&square(3), Vec3::ZERO, usual(), Settings::default());
    let mut refused = |limit: SkinLimit| {
        let mut limits = [SkinLimit::default(); 9];
        limits[4] = limit;
        let error = solver.set_skin(Some(&limits)).unwrap_err();
        assert!(matches!(error, SolverError::SkinLimit { particle: 4, .. }), "{error:?}");
        assert!(solver.skin().is_none());
        error.to_string()
    };
    let fine = SkinLimit { max_distance: 0.1, ..SkinLimit::default() };
    let stop = |distance, radius| Some(Backstop { distance, radius });
    for (bad, name) in [
        (SkinLimit { max_distance: -1.0, ..fine }, "max distance"),
        (SkinLimit { max_distance: f32::NAN, ..fine }, "max distance"),
        (SkinLimit { drive: f32::INFINITY, ..fine }, "drive"),
        (SkinLimit { backstop: stop(-0.2, 1.0), ..fine }, "backstop distance"),
        (SkinLimit { backstop: stop(f32::NAN, 1.0), ..fine }, "backstop distance"),
        (SkinLimit { backstop: stop(0.0, 0.0), ..fine }, "backstop radius"),
        (SkinLimit { backstop: stop(-0.1, 0.05), ..fine }, "backstop radius"),
    ] {
        let said = refused(bad);
        assert!(said.contains(name) && said.contains("particle 4"), "{said}");
    }
    let few = solver.set_skin(Some(&[fine; 8])).unwrap_err();
    assert_eq!(few, SolverError::WrongSkinCount { particles: 9, motions: 8 });

    solver.set_skin(Some(&[SkinLimit { backstop: stop(0.0, 1.0), ..fine }; 9])).unwrap();
    let mut tick = |skin: &[SkinMotion]| {
        solver.tick(&StepInput { dt: TICK, skin, ..StepInput::default() }).unwrap_err()
    };
    assert_eq!(tick(&[]), SolverError::WrongSkinCount { particles: 9, motions: 0 });
    let flat = SkinMotion { normal: [Vec3::Y; 2], ..SkinMotion::default() };
    let mut skin = [flat; 9];
    skin[3].normal[1] = Vec3::ZERO;
    assert_eq!(tick(&skin), SolverError::NoSkinNormal(3));
    skin[2].place[0] = Vec3::NAN;
    assert_eq!(tick(&skin), SolverError::NonFinite { what: "place on the skin", particle: 2 });
}
