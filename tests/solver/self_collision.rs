//! A cloth that collides with itself, at the sizes that games have.
//!
//! Truths: no edge pierces a face in any frame looked at; momentum is kept; layers slide as Coulomb's law says; the same bits on
//! every instruction set and after a restart. Each scene is run without self-collision too, and has crossings then.

use std::f32::consts::PI;
use std::sync::Arc;

use bevy::math::{
    Quat, Vec2, Vec3,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{
    ClothSolver, Collider, Graph, Isa, MassLumping, Material, PinMotion, Pose, SelfCollision,
    Settings, SolverError, StepInput, Substeps, Topology,
};

use crate::support::{dice::Dice, solver::*};

/// A cloth, what moves its pins and colliders, and what it ought to do.
struct Scene {
    solver: ClothSolver,
    gravity: Vec3,
    /// Where a pin is after some seconds that began at a place.
    pin: Box<dyn Fn(Vec3, f32) -> Vec3>,
    /// The radius of a ball, if there is one, and whether it begins to turn after a second.
    ball: Option<f32>,
    turns: bool,
    /// How high the ground is.
    ground: f32,
}

impl Scene {
    fn of(solver: ClothSolver) -> Self {
        Self {
            solver,
            gravity: GRAVITY,
            pin: Box::new(|home, _| home),
            ball: None,
            turns: false,
            ground: f32::NEG_INFINITY,
        }
    }

    /// Takes ticks; the worst number of crossings of every fourth, and the largest strain and its 99 % at the end.
    fn run(&mut self, ticks: usize) -> [f64; 3] {
        let home: Vec<_> =
            self.solver.pins().iter().map(|&p| self.solver.position(p as usize)).collect();
        let (ground, ball) = (InfinitePlane3d::default(), Sphere::new(self.ball.unwrap_or(1.0)));
        let turns = self.turns;
        let turned = |time: f32| Pose {
            rotation: Quat::from_rotation_y(if turns { (time - 1.0).max(0.0) * PI } else { 0.0 }),
            ..Pose::IDENTITY
        };
        let mut worst = 0;
        for tick in 0..ticks {
            let (start, end) = (tick as f32 * TICK, (tick + 1) as f32 * TICK);
            let pins: Vec<_> = home
                .iter()
                .map(|&p| PinMotion { start: (self.pin)(p, start), end: (self.pin)(p, end) })
                .collect();
            let floor = Pose { translation: Vec3::Y * self.ground.max(-1e3), ..Pose::IDENTITY };
            let mut colliders = vec![Collider::new(&ground, floor)];
            if self.ball.is_some() {
                colliders.push(Collider::new(&ball, turned(start)).moving_to(turned(end)));
            }
            let input = StepInput {
                dt: TICK,
                gravity: self.gravity,
                pins: &pins,
                colliders: &colliders,
                ..StepInput::default()
            };
            self.solver.tick(&input).unwrap();
            if tick % 4 == 3 {
                worst = worst.max(self.solver.crossings());
            }
        }
        let strain = self.solver.strain();
        [worst.into(), strain.max.into(), strain.p99.into()]
    }
}

fn solver(topology: &Topology, place: impl Fn(Vec3) -> Vec3) -> ClothSolver {
    let places: Vec<_> = topology.rest_positions().iter().map(|&p| place(p)).collect();
    let mut solver =
        ClothSolver::new(topology.clone(), &places, usual(), Settings::default()).unwrap();
    solver.set_shared(false);
    solver
}

fn square(side: f32, n: usize) -> Topology {
    sheet(Vec2::splat(side), n, n, MassLumping::Lumped).into()
}

/// A square that falls almost on its edge into a heap.
fn edge(topology: &Topology) -> Scene {
    edge_of(topology, 3)
}

/// The same, with other noise.
fn edge_of(topology: &Topology, seed: u64) -> Scene {
    let mut dice = Dice(seed);
    let noise: Vec<_> =
        (0..topology.particle_count()).map(|_| dice.vector() * 0.0005 + Vec3::Y * 0.55).collect();
    let mut next = noise.iter();
    let turn = Quat::from_rotation_x(1.5);
    let places: Vec<_> =
        topology.rest_positions().iter().map(|&p| turn * p + *next.next().unwrap()).collect();
    let mut solver =
        ClothSolver::new(topology.clone(), &places, usual(), Settings::default()).unwrap();
    solver.set_shared(false);
    Scene { ground: 0.0, ..Scene::of(solver) }
}

/// A square of 2 m falls onto a ball, its corners onto the floor.
fn drape(n: usize) -> Scene {
    let solver = solver(&square(2.0, n), |p| p + Vec3::Y * 0.6);
    Scene { ball: Some(0.5), ground: -0.5, ..Scene::of(solver) }
}

/// A square on a small ball, which begins to turn after a second.
fn spin(n: usize) -> Scene {
    let solver = solver(&square(1.0, n), |p| p + Vec3::Y * 0.16);
    Scene { ball: Some(0.15), turns: true, ground: -0.16, ..Scene::of(solver) }
}

/// A strip whose ends are turned against each other, by two turns in so many `seconds`, and come nearer.
fn twist(seconds: f32) -> Scene {
    let (rows, columns) = (19, 64);
    let strip = sheet(Vec2::new(1.0, 0.3), rows, columns, MassLumping::Lumped).into();
    let mut solver = solver(&strip, |p| p);
    let row = |r: usize| [r * columns, r * columns + columns - 1].map(|p| p as u32);
    solver.set_pins(&(0..rows).flat_map(row).collect::<Vec<_>>()).unwrap();
    let pin = move |home: Vec3, time: f32| {
        let part = (time / seconds).min(1.0);
        let turned = Quat::from_rotation_x(home.x.signum() * 2.0 * PI * part) * home;
        Vec3::new(home.x * (1.0 - 0.25 * part), turned.y, turned.z)
    };
    Scene { gravity: Vec3::ZERO, pin: Box::new(pin), ..Scene::of(solver) }
}

/// Runs a scene without self-collision, where it is to have crossings, and with it.
fn stays_apart(what: &str, make: impl Fn() -> Scene, ticks: usize, crossings_without: f64) {
    let [without, ..] = make().run(ticks);
    assert!(without > crossings_without, "{what} without self-collision: {without} crossings");
    let mut scene = make();
    scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
    let [worst, largest, p99] = scene.run(ticks);
    check_at_most(&format!("{what}: crossings"), worst, 0.0);
    check_at_most(&format!("{what}: largest strain at the end"), largest, 0.12);
    check_at_most(&format!("{what}: strain of 99 %"), p99, 0.05);
}

#[test]
fn a_heap_has_no_crossings() {
    stays_apart("edge", || edge(&square(1.0, 64)), 100, 5000.0);
}

#[test]
fn a_heap_of_a_mesh_has_no_crossings() {
    let (positions, triangles) = jittered(48, 48, 1.0 / 47.0, 0.0, 7);
    let centred: Vec<_> = positions.iter().map(|&p| p - Vec3::new(0.5, 0.0, 0.5)).collect();
    let graph = Arc::new(Graph::new(&centred, &triangles, MassLumping::Lumped).unwrap());
    stays_apart("mesh", || edge(&graph.clone().into()), 100, 2000.0);
}

/// Where a heap is pressed together by its own fall, threads and strain limit pull layers through each other, if nothing is kept apart
/// after them: 98 crossings in this one.
#[test]
fn layers_that_are_pressed_are_kept_apart() {
    let (positions, triangles) = jittered(64, 64, 1.0 / 63.0, 0.0, 7);
    let centred: Vec<_> = positions.iter().map(|&p| p - Vec3::new(0.5, 0.0, 0.5)).collect();
    let graph = Arc::new(Graph::new(&centred, &triangles, MassLumping::Lumped).unwrap());
    let mut scene = edge_of(&graph.into(), 3);
    scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
    let [worst, ..] = scene.run(60);
    check_at_most("crossings", worst, 10.0);
}

/// Of a mesh with slivers, whose vertices lie almost on edges that they are no part of, some pierce where they are folded. They are few,
/// and no layer is through another. Three heaps, as it is left to chance how a mesh folds: of fifteen, about half had none, and one had nine.
#[test]
fn few_slivers_of_an_irregular_mesh_pierce() {
    let (positions, triangles) = jittered(32, 32, 1.0 / 31.0, 0.3, 7);
    let centred: Vec<_> = positions.iter().map(|&p| p - Vec3::new(0.5, 0.0, 0.5)).collect();
    let graph = Arc::new(Graph::new(&centred, &triangles, MassLumping::Lumped).unwrap());
    let at_end = |seed| {
        let mut scene = edge_of(&graph.clone().into(), seed);
        scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
        scene.run(100);
        f64::from(scene.solver.crossings())
    };
    let crossings = [3, 4, 5].map(at_end);
    check_at_most("crossings of three heaps", crossings.iter().sum(), 12.0);
}

#[test]
fn corners_that_fold_on_the_floor_have_no_crossings() {
    stays_apart("drape", || drape(64), 120, 500.0);
}

#[test]
fn what_a_turning_ball_winds_up_has_no_crossings() {
    stays_apart("spin", || spin(64), 150, 500.0);
}

/// It is left to chance how the strip wrinkles: of fifty, each wound up a hundredth of a second more slowly than the one before, ten had
/// crossings, and one of them 21. So most have none.
#[test]
fn most_strips_of_two_turns_have_no_crossings() {
    let [without, ..] = twist(6.0).run(400);
    assert!(without > 100.0, "{without}");
    let crossings = (0..9).map(|draw| {
        let mut scene = twist(6.0 + 0.05 * draw as f32);
        scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
        let [worst, ..] = scene.run(400);
        worst
    });
    let crossings: Vec<_> = crossings.collect();
    let some = crossings.iter().filter(|&&crossings| crossings > 0.0).count();
    check_at_most("twist: strips of nine with crossings", some as f64, 4.0);
    check_at_most("twist: crossings of nine strips", crossings.iter().sum(), 60.0);
}

/// Balls of half a spacing leave holes that a particle passes.
#[test]
fn balls_that_are_too_small_let_layers_pass() {
    let mut scene = edge(&square(1.0, 48));
    let distance = Some(0.5 / 47.0);
    scene
        .solver
        .set_self_collision(Some(SelfCollision { distance, ..SelfCollision::default() }))
        .unwrap();
    let [worst, ..] = scene.run(80);
    assert!(worst > 20.0, "{worst}");
}

#[test]
fn crossings_are_counted() {
    // The tip of one triangle is through another: two of its edges pierce that.
    let flat = [Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 0.0, -1.0), Vec3::new(0.0, 0.0, 2.0)];
    let upright = [Vec3::new(-0.2, 0.5, 0.0), Vec3::new(0.2, 0.5, 0.0), Vec3::new(0.0, -0.1, 0.0)];
    let place =
        |shift: Vec3| -> Vec<Vec3> { flat.into_iter().chain(upright.map(|p| p + shift)).collect() };
    for (shift, expected) in [(Vec3::ZERO, 2), (Vec3::Y * 0.2, 0), (Vec3::X * 3.0, 0)] {
        let graph = Graph::new(&place(shift), &[[0, 1, 2], [3, 4, 5]], MassLumping::Lumped);
        let solver = at_rest(&Arc::new(graph.unwrap()), Vec3::ZERO, plain(), Settings::default());
        assert_eq!(solver.crossings(), expected, "{shift}");
    }
}

/// A strip in the air whose ends fly at each other, and fold it onto itself.
#[test]
fn a_cloth_that_folds_onto_itself_keeps_its_momentum() {
    let strip: Topology = sheet(Vec2::new(1.0, 0.3), 19, 64, MassLumping::Lumped).into();
    let material = Material { drag: 0.0, ..usual() };
    let mut solver = at_rest(&strip, Vec3::ZERO, material, Settings::default());
    solver.set_self_collision(Some(SelfCollision::default())).unwrap();
    let rest = strip.rest_positions().to_vec();
    for (particle, p) in rest.iter().enumerate() {
        // Upwards in the middle, the ends towards each other and over it.
        let up = if p.x.abs() < 0.25 { 0.0 } else { 2.0 * (p.x.abs() - 0.25) };
        let velocity = Vec3::new(-2.0 * p.x, up, 0.3 * p.z + 0.1);
        solver.set_velocity(particle, velocity).unwrap();
    }
    let speed = rest.iter().map(|p| 2.0 * f64::from(p.x.abs())).sum::<f64>() / rest.len() as f64;
    let before = momenta(&solver).0;
    let mut touched = 0;
    for _ in 0..128 {
        touched += run(&mut solver, 1, Vec3::ZERO, &[]).self_contact_count;
    }
    assert!(touched > 100, "it touched itself {touched} times");
    let drift = (momenta(&solver).0 - before).length() / (mass(&solver) * speed);
    check_at_most("drift of its momentum, of m v", drift, 1e-4);
}

/// A cloth that was forced through itself stays calm once it collides with itself.
#[test]
fn a_tangle_is_calm() {
    let mut scene = drape(64);
    let [without, ..] = scene.run(32);
    assert!(without > 300.0, "{without}");
    scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
    let before = scene.solver.crossings();
    let [_, largest, _] = scene.run(128);
    let after = scene.solver.crossings();
    assert!(after < before, "{before} crossings, {after} two seconds later");
    check_at_most("largest strain", largest, 0.15);
    check_at_most("fastest [m/s]", fastest(&scene.solver), 0.5);
}

#[test]
fn a_heap_has_the_same_bits_everywhere_and_after_a_restart() {
    let topology = square(1.0, 40);
    let half = |isa: Isa| {
        let mut scene = edge(&topology);
        scene.solver.set_isa(isa);
        scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
        scene.run(45);
        scene
    };
    // Tangled as well: what stands down does so after a restart.
    let tangled = || {
        let mut scene = drape(40);
        scene.run(32);
        scene.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
        scene
    };
    let mut one = tangled();
    one.run(10);
    let saved = one.solver.save();
    one.run(10);
    let mut other = tangled();
    other.solver.restore(&saved).unwrap();
    other.run(10);
    assert!(bits(&one.solver) == bits(&other.solver), "tangled");
    let mut first = half(Isa::Baseline);
    // In the middle of falling together.
    let saved = first.solver.save();
    first.run(20);
    let expected = bits(&first.solver);
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        let mut other = half(isa);
        other.run(20);
        assert!(bits(&other.solver) == expected, "{isa:?}");
    }
    let mut restored = edge(&topology);
    restored.solver.set_self_collision(Some(SelfCollision::default())).unwrap();
    restored.solver.restore(&saved).unwrap();
    restored.run(20);
    assert!(bits(&restored.solver) == expected, "restored");
}

#[test]
fn the_plan_has_the_substeps_that_layers_need() {
    let topology = square(1.0, 64);
    let settings = Settings { substeps: Substeps::Automatic { budget: 8 }, ..Settings::default() };
    let mut solver = at_rest(&topology, Vec3::ZERO, usual(), settings);
    let before = solver.plan_for(1.0 / 60.0).unwrap().substeps;
    solver.set_self_collision(Some(SelfCollision::default())).unwrap();
    let plan = *solver.plan_for(1.0 / 60.0).unwrap();
    assert_eq!([before, plan.substeps, plan.layers], [8, 12, 12]);
    assert!(plan.to_string().contains("layers need 12"), "{plan}");
    solver.set_self_collision(None).unwrap();
    assert_eq!(solver.plan_for(1.0 / 60.0).unwrap().substeps, 8);
}

#[test]
fn what_cannot_be_is_refused() {
    let mut solver = at_rest(&square(1.0, 11), Vec3::ZERO, usual(), Settings::default());
    let good = SelfCollision { distance: Some(0.09), friction: 0.2 };
    solver.set_self_collision(Some(good)).unwrap();
    for bad in [
        SelfCollision { distance: Some(0.11), ..good },
        SelfCollision { distance: Some(0.0), ..good },
        SelfCollision { distance: Some(f32::NAN), ..good },
        SelfCollision { friction: -1.0, ..good },
        SelfCollision { friction: f32::NAN, ..good },
    ] {
        let refused = solver.set_self_collision(Some(bad));
        assert!(matches!(refused, Err(SolverError::Parameter(_))), "{bad:?}: {refused:?}");
        assert_eq!(solver.self_collision(), Some(good));
    }
    let message = solver
        .set_self_collision(Some(SelfCollision { distance: Some(0.11), ..good }))
        .unwrap_err()
        .to_string();
    assert!(message.contains("distance is 0.11") && message.contains("neighbouring"), "{message}");
}

/// Two sheets in one mesh: the lower one is held, the other lies on it, turned by some angle.
fn incline(turn: f32, degrees: f32, friction: f32) -> f64 {
    let (below, above, cell) = (40_usize, 20_usize, 0.02_f32);
    let (mut rest, mut start, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (n, height) in [(below, 0.0), (above, 1.0)] {
        let first = rest.len() as u32;
        let along = |i: usize| (i as f32 - 0.5 * (n - 1) as f32) * cell;
        for at in 0..n * n {
            let place = Vec3::new(along(at % n), height, along(at / n));
            rest.push(place);
            let turned = Quat::from_rotation_y(turn) * place + Vec3::new(0.1, 0.0, 0.23) * cell;
            let lies = Vec3::new(turned.x, 0.92 * cell, turned.z);
            start.push(if height > 0.0 { lies } else { place });
            if at % n + 1 < n && at / n + 1 < n {
                triangles.extend(halves(first + at as u32, n, true));
            }
        }
    }
    let graph = Arc::new(Graph::new(&rest, &triangles, MassLumping::Lumped).unwrap());
    let material = Material { drag: 0.0, ..usual() };
    let mut solver = ClothSolver::new(graph, &start, material, Settings::default()).unwrap();
    let held = (below * below) as u32;
    solver.set_pins(&(0..held).collect::<Vec<_>>()).unwrap();
    solver
        .set_self_collision(Some(SelfCollision { friction, ..SelfCollision::default() }))
        .unwrap();
    let angle = degrees.to_radians();
    let gravity = Vec3::new(angle.sin(), -angle.cos(), 0.0) * 9.81;
    let place = |solver: &ClothSolver| {
        let all = (below * below..rest.len()).map(|i| f64::from(solver.position(i).x));
        all.sum::<f64>() / (above * above) as f64
    };
    run(&mut solver, 32, gravity, &[]);
    let before = place(&solver);
    run(&mut solver, 32, gravity, &[]);
    place(&solver) - before
}

/// Whether their particles lie in each other's gaps or not, layers stay below Coulomb's angle and slide above it.
#[test]
fn layers_slide_at_the_angle_of_friction() {
    let friction = 0.5_f32;
    let angle = friction.atan().to_degrees();
    for turn in [0.0, 0.3] {
        let [stays, slides] = [-0.5, 0.5].map(|by| incline(turn, angle + by, friction));
        check_at_most(&format!("turned by {turn}, below: slid by [m]"), stays.abs(), 1e-4);
        // From rest, by what the slope has above friction, between 0.5 and 1 s.
        let angle = f64::from(angle + 0.5).to_radians();
        let expected = 9.81 * (angle.sin() - 0.5 * angle.cos()) * 0.5 * (1.0 - 0.25);
        check_at_most(&format!("turned by {turn}, above: slid by [m]"), -slides, -0.5 * expected);
    }
}
