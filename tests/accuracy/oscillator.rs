//! One oscillator, held to the tables of Verlet's exact discrete solution, of its order of convergence and
//! of that with damping (`data/verlet_*.csv`, `data/damping_order.csv`): the reference to their last digit,
//! the solver to the rounding of `f32`. Also with steps that vary.
//!
//! The solver's oscillator is the smallest lattice, lumped: `omega^2 = 4 k / (rho a^2)`, damped at
//! `4 C / (rho a^2)`. Both are linear along its springs.

use bevy::math::{DVec3, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, DampingForm, MassLumping, Material, StepInput, StretchMethod,
};

use super::reference::{Damper, Method, Model, Motion, Spring};
use crate::support::solver::*;

const CELL: f32 = 0.1;
/// Metres for one of the tables' lengths.
const AMPLITUDE: f64 = 0.04;
/// What `f32` rounds of positions beside 0.05 m in some steps, in amplitudes.
const ROUNDING: f64 = 2e-6;

fn exact(damping: f64, v0: f64, t: f64) -> f64 {
    let turn = (1.0 - damping * damping / 4.0).sqrt();
    let sine = (v0 + damping / 2.0) / turn;
    (-damping * t / 2.0).exp() * ((turn * t).cos() + sine * (turn * t).sin())
}

/// A mass of one on a spring of one.
fn model(damping: f64) -> Model {
    Model {
        mass: vec![1.0; 2],
        held: vec![true, false],
        springs: vec![Spring { ends: [0, 1], constant: 1.0, rest: 4.0 }],
        dampers: vec![Damper { ends: [0, 1], constant: damping }],
        axial: true,
        ..Model::default()
    }
}

fn start(v0: f64) -> Motion {
    let mut motion = Motion::at_rest(&[DVec3::ZERO, DVec3::X * 5.0]);
    motion.v[1].x = v0;
    motion
}

/// The way of the reference's oscillator.
fn reference(damping: f64, v0: f64, method: Method, steps: &[f64]) -> f64 {
    let (model, mut motion) = (model(damping), start(v0));
    steps.iter().for_each(|&h| model.step(&mut motion, method, h));
    motion.x[1].x - 4.0
}

/// The way of the solver's, a tick of one substep for each step, in amplitudes.
fn solved(damping: f64, form: DampingForm, v0: f64, steps: &[f64]) -> f64 {
    let lattice = sheet(Vec2::splat(CELL), 2, 2, MassLumping::Lumped);
    let wide = 1.0 + 2.0 * AMPLITUDE as f32 / CELL;
    let positions: Vec<_> =
        lattice.rest_positions().iter().map(|&p| p * Vec3::new(wide, 1.0, 1.0)).collect();
    let unit = 0.2 * CELL * CELL / 4.0;
    let material = Material {
        thread_stiffness: unit,
        damping: damping as f32 * unit,
        damping_form: form,
        ..plain()
    };
    let settings = settings(StretchMethod::ExplicitSprings, 1);
    let mut solver = ClothSolver::new(lattice, &positions, material, settings).unwrap();
    for (i, place) in positions.iter().enumerate() {
        let speed = (v0 * AMPLITUDE) as f32 * place.x.signum();
        solver.set_velocity(i, Vec3::X * speed).unwrap();
    }
    for &h in steps {
        solver.tick(&StepInput { dt: h as f32, ..StepInput::default() }).unwrap();
        assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    }
    (f64::from(solver.position(1).x) - 0.05) / AMPLITUDE
}

fn even(h: f64) -> Vec<f64> {
    vec![h; (2.0 / h).round() as usize]
}

#[test]
fn the_reference_meets_the_tables_of_verlets_order() {
    let mut errors = Vec::new();
    for row in table(include_str!("../data/verlet_order.csv")) {
        let (h, expected): (f64, f64) = (row[1].parse().unwrap(), row[2].parse().unwrap());
        if row[0] == "taylor" {
            let error =
                (reference(0.0, 0.5, Method::Verlet, &even(h)) - exact(0.0, 0.5, 2.0)).abs();
            check(&format!("error at h {h}"), error, expected, 1e-5 * expected + 2e-13);
            errors.push(error);
        }
    }
    for pair in errors.windows(2) {
        check("order", (pair[0] / pair[1]).log2(), 2.0, 1e-3);
    }
}

#[test]
fn the_reference_meets_the_discrete_closed_form_to_rounding() {
    for row in table(include_str!("../data/verlet_oscillator_exact.csv")) {
        let (h, tabled): (f64, f64) = (row[0].parse().unwrap(), row[1].parse().unwrap());
        // cos(phi) = 1 - h^2 / 2, without the cancelling.
        let phi = 2.0 * (0.5 * h).asin();
        check(&format!("h {h}, angle of a step"), phi, tabled, 1e-11);
        let (model, mut motion) = (model(0.0), start(0.0));
        let mut worst = 0.0_f64;
        for n in 1..=(20.0 / h).round() as usize {
            model.step(&mut motion, Method::Verlet, h);
            worst = worst.max((motion.x[1].x - 4.0 - (n as f64 * phi).cos()).abs());
        }
        // Of an oscillation far from the origin, where positions are rounded to 1e-15, the velocity loses.
        check_at_most(&format!("h {h}, from the closed form"), worst, 1e-12 + 1e-14 / h);
    }
}

#[test]
fn the_reference_meets_the_table_of_damping() {
    for row in table(include_str!("../data/damping_order.csv")) {
        if row[0] != "half_kick" {
            continue;
        }
        let (h, expected): (f64, f64) = (row[1].parse().unwrap(), row[2].parse().unwrap());
        // The table starts from a velocity half a step before.
        let (model, mut motion) = (model(0.2), start(0.5));
        motion.v[1].x -= 0.5 * h * (-1.0 - 0.2 * 0.5);
        motion.last = h;
        model.steps(&mut motion, Method::Verlet, h, (2.0 / h).round() as usize);
        let error = (motion.x[1].x - 4.0 - exact(0.2, 0.5, 2.0)).abs();
        check(&format!("error at h {h}"), error, expected, 1e-5 * expected);
    }
}

#[test]
fn eulers_order_is_one_and_the_midpoints_two() {
    for (method, order) in [(Method::Euler, 1.0), (Method::Midpoint, 2.0), (Method::Verlet, 2.0)] {
        for damping in [0.0, 0.2] {
            let error =
                |h| (reference(damping, 0.5, method, &even(h)) - exact(damping, 0.5, 2.0)).abs();
            let measured = (error(2.0 / 5120.0) / error(2.0 / 10240.0)).log2();
            check(&format!("{method:?}, damping {damping}, order"), measured, order, 0.01);
        }
    }
}

#[test]
fn the_solver_meets_the_tables_of_order() {
    let mut errors = Vec::new();
    for row in table(include_str!("../data/verlet_order.csv")) {
        let (h, expected): (f64, f64) = (row[1].parse().unwrap(), row[2].parse().unwrap());
        // Below, rounding is what is left.
        if row[0] == "taylor" && h > 0.02 {
            let way = solved(0.0, DampingForm::Axial, 0.5, &even(h));
            let error = (way - exact(0.0, 0.5, 2.0)).abs();
            check(&format!("error at h {h} [A]"), error, expected, ROUNDING);
            errors.push(error);
        }
    }
    check("order", (errors[0] / errors[2]).log2() / 2.0, 2.0, 0.05);
    for form in [DampingForm::Axial, DampingForm::Relative] {
        let error = |h: f64| solved(0.2, form, 0.5, &even(h)) - exact(0.2, 0.5, 2.0);
        let same = |h: f64| reference(0.2, 0.5, Method::Verlet, &even(h)) - exact(0.2, 0.5, 2.0);
        for h in [0.1, 0.05, 0.025] {
            check(&format!("{form:?} damping, error at h {h} [A]"), error(h), same(h), ROUNDING);
        }
        let order = (error(0.1) / error(0.025)).abs().log2() / 2.0;
        check(&format!("{form:?} damping, order"), order, 2.0, 0.05);
    }
}

#[test]
fn steps_that_vary_keep_the_order() {
    let uneven = |n: usize| {
        let mut dice = Dice(3);
        let steps: Vec<_> = (0..n).map(|_| 1.0 + 0.1 * f64::from(dice.roll())).collect();
        let total: f64 = steps.iter().sum();
        // As the solver is given them.
        steps.iter().map(|s| f64::from((s * 2.0 / total) as f32)).collect::<Vec<_>>()
    };
    let off = |n: usize, way: &dyn Fn(&[f64]) -> f64| {
        let steps = uneven(n);
        way(&steps) - exact(0.0, 0.5, steps.iter().sum())
    };
    let by_reference = |steps: &[f64]| reference(0.0, 0.5, Method::Verlet, steps);
    let by_solver = |steps: &[f64]| solved(0.0, DampingForm::Axial, 0.5, steps);
    for n in [20, 40, 80] {
        let (measured, same) = (off(n, &by_solver), off(n, &by_reference));
        check(&format!("error of {n} uneven steps [A]"), measured, same, ROUNDING);
    }
    // Of the fine ones the mean of several halvings: their unevenness has its part in each.
    let order = (off(100, &by_reference) / off(1600, &by_reference)).abs().log2() / 4.0;
    check("reference's order", order, 2.0, 0.1);
    let order = (off(20, &by_solver) / off(80, &by_solver)).abs().log2() / 2.0;
    check("solver's order", order, 2.0, 0.3);
}
