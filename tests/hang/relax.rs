//! Relaxed, held to the elastic catenary of a chain (`data/catenary_discrete_sag.csv`), to itself from run
//! to run, and to how little it moves once it is let go.

use std::time::Instant;

use bevy::math::{Vec2, Vec3};
use bevy_drape::{
    ClothMaterial,
    hang::{RelaxReport, Relaxation, hang, relax},
    solver::{ClothSolver, FormChoice, MassLumping, Material, Settings, StepInput, Topology},
};

use crate::{common::*, surface::point};

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
