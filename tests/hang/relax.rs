//! Tests `relax` against the elastic catenary of a chain (`data/catenary_discrete_sag.csv`), for repeatability, and for
//! how little the cloth moves when released.

use std::time::Instant;

use bevy::math::{Vec2, Vec3};
use bevy_drape::{
    ClothMaterial,
    hang::{RelaxReport, Relaxation, hang, relax},
    solver::{
        Air, ClothSolver, MassLumping, Material, Settings, SolverError, StepInput, StretchMethod,
        Topology,
    },
};

use crate::{support::solver::*, surface::point};

const SIDE: f32 = 1.8;

/// A cloth hung from points in Weil's shape, and relaxed.
fn start(
    topology: &Topology,
    points: &[(usize, Vec3)],
    material: Material,
    settings: Settings,
    limits: Relaxation,
) -> (ClothSolver, RelaxReport) {
    let points: Vec<_> = points.iter().map(|&(i, place)| point(i, place)).collect();
    let before = Instant::now();
    let rest = topology.rest_positions();
    let places = hang(topology, rest, &points, material.max_strain, GRAVITY).unwrap();
    println!("hung in {:.1} ms", before.elapsed().as_secs_f64() * 1e3);
    let mut solver = ClothSolver::new(topology.clone(), &places, material, settings).unwrap();
    let pins: Vec<_> = points.iter().map(|point| point.particle).collect();
    solver.set_pins(&pins).unwrap();
    let pins = still(&solver);
    let input = StepInput { dt: TICK, gravity: GRAVITY, pins: &pins, ..StepInput::default() };
    let before = Instant::now();
    let report = relax(&mut solver, &input, limits).unwrap();
    println!("relaxed in {:.2} s: {report:?}", before.elapsed().as_secs_f64());
    (solver, report)
}

/// How far particles go at most, in the ticks to come.
fn moves(solver: &mut ClothSolver, ticks: usize) -> f64 {
    let from = positions(solver);
    let mut most = 0.0_f64;
    for _ in 0..ticks {
        run(solver, 1, GRAVITY, &[]);
        most = most.max(farthest(&positions(solver), &from));
    }
    most
}

#[test]
fn a_strip_comes_to_the_discrete_elastic_catenary() {
    // N springs of EA = T W / 2 a column and N - 1 masses between: eps = w L / EA = rho g L / T.
    for row in table(include_str!("../data/catenary_discrete_sag.csv")) {
        let value = |column: usize| row[column].parse::<f32>().unwrap();
        let (span, eps, springs) = (value(0), value(1), value(2) as usize);
        if ![16, 32].contains(&springs) || eps == 0.0 {
            continue;
        }
        let strip = sheet(Vec2::new(0.1, 1.0), springs + 1, 2, MassLumping::Lumped);
        let material = Material { thread_stiffness: 0.2 * 9.81 / eps, ..plain() };
        let settings = Settings { tethers: false, ..settings(StretchMethod::ExplicitSprings, 64) };
        let last = 2 * springs;
        let places = [(0, 0.0, 0.0), (1, 0.1, 0.0), (last, 0.0, span), (last + 1, 0.1, span)];
        let points = places.map(|(i, x, z)| (i, Vec3::new(x, 0.0, z)));
        let limits = Relaxation { speed: 2e-6, longest: 20.0 };
        let topology = Topology::from(strip);
        let (solver, report) = start(&topology, &points, material, settings, limits);
        assert!(!solver.plan().clamped.thread, "{}", solver.plan());
        let reference: f64 = row[3].parse().unwrap();
        for column in 0..2 {
            let sag = -f64::from(solver.position(springs + column).y);
            let what = format!("D / L {span}, eps {eps}, {springs} springs: sag / L");
            // 1e-6 of the solver, and as much of places in single precision.
            check(&what, sag, reference, 2.5e-6);
            // The continuum, from which N springs are some 1 / N^2 away.
            check(&what, sag, row[4].parse().unwrap(), 0.5 / (springs * springs) as f64);
        }
        assert!(report.at_rest, "{report:?}");
    }
}

#[test]
fn it_gives_the_same_bits_and_leaves_the_cloth_as_it_was() {
    let topology = Topology::from(sheet(Vec2::ONE, 17, 17, MassLumping::Lumped));
    let material = Material::from(ClothMaterial::default());
    let corners = [(0, Vec3::ZERO), (16, Vec3::X * 0.7)];
    let limits = Relaxation { longest: 2.0, ..Relaxation::default() };
    let run = || start(&topology, &corners, material, Settings::default(), limits);
    let ((one, report), (other, again)) = (run(), run());
    assert_eq!(bits(&one), bits(&other));
    assert_eq!(report, again);
    assert_eq!(*one.material(), material);
    assert_eq!(fastest(&one), 0.0);
    assert!(!one.has_moved());
    assert_eq!(one.position(16), Vec3::X * 0.7);
}

#[test]
fn it_ends_when_its_time_is_over_and_says_so() {
    let topology = Topology::from(sheet(Vec2::ONE, 9, 9, MassLumping::Lumped));
    let material = Material::from(ClothMaterial::default());
    let corners = [(0, Vec3::ZERO), (8, Vec3::X * 0.7)];
    let limits = Relaxation { speed: 0.0, longest: 10.0 * TICK };
    let (_, report) = start(&topology, &corners, material, Settings::default(), limits);
    assert_eq!((report.ticks, report.at_rest), (10, false));
    assert!(report.speed > 0.0);
    let limits = Relaxation { longest: 0.0, ..limits };
    let (_, report) = start(&topology, &corners, material, Settings::default(), limits);
    assert_eq!((report.ticks, report.at_rest), (0, false));
}

#[test]
fn air_and_drag_are_put_back() {
    let topology = Topology::from(sheet(Vec2::ONE, 9, 9, MassLumping::Lumped));
    let material = Material::from(ClothMaterial::default());
    let mut solver = at_rest(&topology, Vec3::ZERO, material, Settings::default());
    solver.set_air(Some(Air::default())).unwrap();
    solver.set_pins(&[0, 8]).unwrap();
    let pins = still(&solver);
    let input = StepInput { dt: TICK, gravity: GRAVITY, pins: &pins, ..StepInput::default() };
    let report = relax(&mut solver, &input, Relaxation::default()).unwrap();
    assert!(report.at_rest);
    assert_eq!(solver.air(), Some(&Air::default()));
    assert_eq!(*solver.material(), material);
    // Bad input is told, and the cloth is as it was then too.
    let input = StepInput { gravity: Vec3::NAN, ..input };
    assert_eq!(relax(&mut solver, &input, Relaxation::default()), Err(SolverError::Gravity));
    assert_eq!(solver.air(), Some(&Air::default()));
    assert_eq!(*solver.material(), material);
}

#[test]
fn whatever_hangs_hardly_moves_when_it_is_let_go() {
    let lattice = Topology::from(sheet(Vec2::ONE, 25, 25, MassLumping::Lumped));
    let graph = Topology::from(mesh(25, 25, 1.0 / 24.0, 0.2));
    let material = Material::from(ClothMaterial::default());
    // Two corners at different heights, opposite ones, three, four, two points inside.
    let scenes: [&[usize]; 5] =
        [&[0, 24], &[0, 624], &[0, 24, 600], &[0, 24, 600, 624], &[306, 318]];
    for (name, topology) in [("lattice", lattice), ("graph", graph)] {
        for particles in scenes {
            let place = |&i: &usize| {
                let drawn = topology.rest_positions()[i] * 0.8;
                (i, drawn + Vec3::Y * if i == 24 { 0.2 } else { 0.0 })
            };
            let points: Vec<_> = particles.iter().map(place).collect();
            let limits = Relaxation::default();
            let (mut hung, report) =
                start(&topology, &points, material, Settings::default(), limits);
            assert!(report.at_rest, "{name} {particles:?}: {report:?}");
            let what = format!("{name}, {particles:?}: largest move in 1 s [m]");
            check_at_most(&what, moves(&mut hung, 64), 0.02);
        }
    }
}

#[test]
fn the_two_corner_curtain_hardly_moves_when_it_is_let_go() {
    let topology = Topology::from(sheet(Vec2::splat(SIDE), 64, 64, MassLumping::Lumped));
    let material = Material::from(ClothMaterial::default());
    let corners = [(0, Vec3::X * -0.62), (63, Vec3::X * 0.62)];
    let settings = Settings::default();
    let (mut hung, report) = start(&topology, &corners, material, settings, Relaxation::default());
    assert!(report.at_rest, "{report:?}");
    let moved = moves(&mut hung, 64) / f64::from(SIDE);
    check_at_most("Weil's start: largest move in 1 s / height", moved, 0.02);
    // The same from the flat sheet, its corners where they are in that.
    let mut flat = at_rest(&topology, Vec3::ZERO, material, settings);
    flat.set_pins(&[0, 63]).unwrap();
    let moved = moves(&mut flat, 64) / f64::from(SIDE);
    println!("flat start: largest move in 1 s / height: {moved}");
    assert!(moved > 0.5);
}

/// The shifts and pulls of its springs go with its shape: without them the mesh looks for another rest, 0.1 m away.
#[test]
fn a_mesh_that_was_hung_stays_as_long_as_it_is() {
    let topology = Topology::from(mesh(32, 32, 1.0 / 31.0, 0.3));
    let material = Material::from(ClothMaterial::default());
    let corners = [(0, Vec3::ZERO), (31, Vec3::X * 0.95)];
    let settings = settings(StretchMethod::ImplicitThreads, 20);
    let (mut solver, _) = start(&topology, &corners, material, settings, Relaxation::default());
    check_at_most("moves in two seconds [m]", moves(&mut solver, 128), 4e-3);
}
