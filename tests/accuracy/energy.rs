//! Energy of an undamped cloth that swings: Verlet's error of it stays on a plateau that scales as `h^2`,
//! and does not drift in ten minutes.

use bevy_drape::solver::{ClothSolver, MassLumping, StretchMethod};

use super::reference::{Fabric, Method, Model, Motion};
use super::scenes::*;
use crate::support::solver::*;

/// A sheet of 10 x 10 cells held at its corners.
fn falling(substeps: u32) -> (ClothSolver, Model) {
    let sheet = Sheet::square(10, 1.0);
    let fabric = Fabric { thread: 200.0, shear: 100.0, ..Fabric::default() };
    let corners = [0, 10, 110, 120];
    let settings =
        settings_for(&fabric, Method::Verlet, settings(StretchMethod::ExplicitSprings, substeps));
    let lattice = sheet.lattice(MassLumping::Lumped);
    let mut solver = at_rest(&lattice, bevy::math::Vec3::ZERO, material(&fabric), settings);
    solver.set_pins(&corners.map(|i| i as u32)).unwrap();
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    (solver, sheet.model(&fabric, &corners, GRAVITY.as_dvec3()))
}

/// Kinetic and whole energy half a substep before the tick's end [J].
fn energies(solver: &ClothSolver, model: &Model) -> (f64, f64) {
    let h = f64::from(solver.plan().step);
    let after = places(solver);
    let v: Vec<_> = (0..after.len()).map(|i| solver.velocity(i).as_dvec3()).collect();
    let before: Vec<_> = after.iter().zip(&v).map(|(x, v)| *x - *v * h).collect();
    let moving = |i: usize| if model.held[i] { 0.0 } else { 0.5 * model.mass[i] };
    let kinetic: f64 = v.iter().enumerate().map(|(i, v)| moving(i) * v.length_squared()).sum();
    (kinetic, kinetic + 0.5 * (model.energy(&before) + model.energy(&after)))
}

/// The same of the reference.
fn errors_of_reference(substeps: usize, seconds: usize) -> Vec<f64> {
    let (solver, model) = falling(substeps as u32);
    let h = f64::from(TICK) / substeps as f64;
    let mut motion = Motion::at_rest(&places(&solver));
    let mut largest = 0.0_f64;
    let errors: Vec<_> = (0..seconds * 64)
        .map(|_| {
            model.steps(&mut motion, Method::Verlet, h, substeps - 1);
            let before = motion.x.clone();
            model.step(&mut motion, Method::Verlet, h);
            let moving = motion.v.iter().zip(&model.mass);
            let kinetic: f64 = moving.map(|(v, m)| 0.5 * m * v.length_squared()).sum();
            largest = largest.max(kinetic);
            kinetic + 0.5 * (model.energy(&before) + model.energy(&motion.x))
        })
        .collect();
    errors.chunks(8).map(|e| mean(e) / largest).collect()
}

/// Error of the energy over the largest kinetic energy, each eighth of a second: it was zero at first.
fn errors(substeps: u32, seconds: usize) -> Vec<f64> {
    let (mut solver, model) = falling(substeps);
    let mut largest = 0.0_f64;
    let errors: Vec<_> = (0..seconds * 8)
        .map(|_| {
            let mut all = 0.0;
            for _ in 0..8 {
                run(&mut solver, 1, GRAVITY, &[]);
                let (kinetic, whole) = energies(&solver, &model);
                largest = largest.max(kinetic);
                all += whole / 8.0;
            }
            all
        })
        .collect();
    errors.iter().map(|e| e / largest).collect()
}

fn most(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e.abs()).fold(0.0, f64::max)
}

fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn the_references_error_of_the_energy_scales_with_the_squared_step() {
    let most = [14, 28].map(|substeps| most(&errors_of_reference(substeps, 60)));
    println!("largest error over the largest kinetic energy: {}", list(&most));
    check("of twice as long a step, relative", most[0] / most[1], 4.0, 0.8);
}

#[test]
fn the_solvers_energy_does_not_drift_in_ten_minutes_and_scales_with_the_squared_step() {
    // It spreads to all motions in the first minutes, and then is on a plateau.
    let plateau = [14, 28].map(|substeps| {
        let means: Vec<_> = errors(substeps, 600).chunks(480).map(mean).collect();
        println!("x{substeps}: mean error by minute {}", list(&means));
        let drift = mean(&means[7..]) / mean(&means[3..6]);
        check(&format!("x{substeps}: minutes 8 to 10 over 4 to 6"), drift, 1.0, 0.15);
        mean(&means[4..])
    });
    check("plateau of twice as long a step, relative", plateau[0] / plateau[1], 4.0, 0.5);
    // With finer steps rounding shows: it takes energy, some 1e-4 of the kinetic a minute.
    let means: Vec<_> = errors(56, 240).chunks(480).map(mean).collect();
    println!("x56: mean error by minute {}", list(&means));
    check_at_most("x56: what rounding takes in two minutes", (means[3] - means[1]).abs(), 1e-3);
}
