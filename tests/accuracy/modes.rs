//! Axial oscillations of a hanging strip without gravity. Held to the closed forms of the discrete chain
//! (`data/chain_modes.csv`): springs turn them at Verlet's angle and leave their amplitude alone, threads
//! damp them by a law of their own, which is stated here.
//!
//! Threads are Houbolt's method (1950): `2 x3 - 5 x2 + 4 x1 - x0 = -(omega h)^2 x3` from substep to substep.
//! For small omega h a substep damps an oscillation by `(omega h)^4 / 2`, and turns it by
//! `omega h (1 - 11 / 24 (omega h)^2)`. Chains of a mesh are of the same family (`k = 0.6` in
//! `x3 - (2 + k) x2 + (1 + 2 k) x1 - k x0 = -(omega h)^2 (k x3 + (1 - 2 k) x2)`; Houbolt's is 0.5).

use std::{f64::consts::PI, sync::Arc};

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{
    ClothSolver, Graph, MassLumping, Material, StepInput, StretchMethod, Topology,
};

use super::reference::{Fabric, Method, Motion};
use super::scenes::*;
use crate::support::solver::*;

const CELLS: usize = 10;
const AMPLITUDE: f64 = 1e-3;
/// `sqrt(E / rho) / L` [1/s].
const UNIT: f64 = 10.0;

fn fabric(equal: bool) -> Fabric {
    Fabric { thread: 0.2 * UNIT * UNIT, equal, ..Fabric::default() }
}

/// Displacement of a row in a mode.
fn shape(mode: usize, equal: bool, row: usize) -> f64 {
    let n = CELLS as f64;
    let ends = if equal { 2.0 * n + 1.0 } else { 2.0 * n };
    ((2 * mode - 1) as f64 * PI * row as f64 / ends).sin()
}

/// The table's frequency of a mode [1/s].
fn tabled(mode: usize, equal: bool) -> f64 {
    let kind = if equal { "axial_full_tip" } else { "axial_half_tip" };
    let rows = table(include_str!("../data/chain_modes.csv"));
    let row = rows
        .iter()
        .find(|r| r[0] == kind && r[1].parse() == Ok(CELLS) && r[2].parse() == Ok(mode))
        .unwrap();
    let unit: f64 = row[3].parse().unwrap();
    // Of a strip of equal masses a row weighs N / (N + 1) of a cell's, and its three springs are whole,
    // where two cells are: 3 / 2 of the stiffness, beside the whole sheet's mass.
    let n = CELLS as f64;
    UNIT * unit * if equal { (1.5 * (n + 1.0) / n).sqrt() } else { 1.0 }
}

fn start(mode: usize, equal: bool) -> Vec<DVec3> {
    let sheet = strip(CELLS, 1.0);
    let rest = sheet.rest();
    (0..sheet.count()).map(|i| rest[i] + DVec3::Z * AMPLITUDE * shape(mode, equal, i / 3)).collect()
}

/// The mode's part of places, in amplitudes.
fn part(x: &[DVec3], mode: usize, equal: bool) -> f64 {
    let rest = strip(CELLS, 1.0).rest();
    let weight = |i: usize| if !equal && i / 3 == CELLS { 0.5 } else { 1.0 };
    let (mut sum, mut square) = (0.0, 0.0);
    for i in 0..x.len() {
        let s = shape(mode, equal, i / 3);
        sum += weight(i) * s * (x[i].z - rest[i].z);
        square += weight(i) * s * s;
    }
    sum / square / AMPLITUDE
}

/// The factor and the angle of one step, of values that are multiplied and turned so in each: the best
/// `p` and `q` of `x'' = p x' - q x`.
pub fn turn(x: &[f64]) -> (f64, f64) {
    let (mut aa, mut ab, mut bb, mut ac, mut bc) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for w in x.windows(3) {
        let (a, b, c) = (w[1], -w[0], w[2]);
        aa += a * a;
        ab += a * b;
        bb += b * b;
        ac += a * c;
        bc += b * c;
    }
    let det = aa * bb - ab * ab;
    let (p, q) = ((ac * bb - bc * ab) / det, (aa * bc - ab * ac) / det);
    let factor = q.sqrt();
    (factor, (p / (2.0 * factor)).acos())
}

/// A substep that carries the stiffest motion too [s].
const STEP: f64 = 1.0 / 256.0;
/// Samples taken: ten periods and more.
const SAMPLES: usize = 100;

/// Substeps from sample to sample: some eighth of a period.
fn sampling(omega: f64) -> usize {
    (0.8 / (omega * STEP)).round() as usize
}

/// The chain's frequency from the angle between samples: `sin(phi / 2) = omega h / 2` in a substep.
fn frequency(angle: f64, omega: f64) -> f64 {
    2.0 / STEP * (0.5 * angle / sampling(omega) as f64).sin()
}

/// Values of a mode after each of `count` substeps of length `h`.
fn solved(
    topology: impl Into<Topology>,
    mode: usize,
    equal: bool,
    form: StretchMethod,
    h: f64,
    count: usize,
) -> Vec<f64> {
    let fabric = fabric(equal);
    let x: Vec<_> = start(mode, equal).iter().map(|p| p.as_vec3()).collect();
    let settings = settings_for(&fabric, Method::Verlet, settings(form, 1));
    let mut solver = ClothSolver::new(topology, &x, material(&fabric), settings).unwrap();
    solver.set_pins(&[0, 1, 2]).unwrap();
    let pins = still(&solver);
    let input =
        StepInput { dt: h as f32, pins: &pins, gravity: Vec3::ZERO, ..StepInput::default() };
    (0..count)
        .map(|_| {
            solver.tick(&input).unwrap();
            assert!(!solver.plan().clamped.thread, "{}", solver.plan());
            part(&places(&solver), mode, equal)
        })
        .collect()
}

#[test]
fn the_reference_meets_the_table_of_modes() {
    for equal in [false, true] {
        for mode in [1, 2, 3] {
            let omega = tabled(mode, equal);
            let sheet = strip(CELLS, 1.0);
            let model = sheet.model(&fabric(equal), &[0, 1, 2], DVec3::ZERO);
            let mut motion = Motion::at_rest(&start(mode, equal));
            let values: Vec<_> = (0..SAMPLES)
                .map(|_| {
                    model.steps(&mut motion, Method::Verlet, STEP, sampling(omega));
                    part(&motion.x, mode, equal)
                })
                .collect();
            let (factor, angle) = turn(&values);
            let measured = frequency(angle, omega);
            check(&format!("equal {equal}, mode {mode} [1/s]"), measured, omega, 1e-8 * omega);
            check("amplitude after a step", factor, 1.0, 1e-9);
        }
    }
}

#[test]
fn springs_swing_at_the_tables_frequencies_and_lose_nothing() {
    let sheet = strip(CELLS, 1.0);
    for equal in [false, true] {
        for mode in [1, 2, 3] {
            let omega = tabled(mode, equal);
            let lumping = lumping(&fabric(equal));
            for (what, topology) in [
                ("lattice", Topology::from(sheet.lattice(lumping))),
                ("graph", Topology::from(sheet.graph(lumping))),
            ] {
                let every = sampling(omega);
                let count = SAMPLES * every;
                let values =
                    solved(topology, mode, equal, StretchMethod::ExplicitSprings, STEP, count);
                let values: Vec<_> = values.into_iter().skip(every - 1).step_by(every).collect();
                let (factor, angle) = turn(&values);
                let measured = frequency(angle, omega);
                let what = format!("{what}, equal {equal}, mode {mode}");
                check(&format!("{what} [1/s]"), measured, omega, 2e-5 * omega);
                let decrement = -factor.ln() * 2.0 * PI / angle;
                check(&format!("{what}: decrement of a period"), decrement, 0.0, 1e-4);
            }
        }
    }
}

/// Substeps until what is no oscillation has died away: the third root is a half, or less.
const BEGINNING: usize = 20;

#[test]
fn threads_follow_houbolts_recurrence() {
    let sheet = strip(CELLS, 1.0);
    for mode in [1, 2, 3] {
        let omega = tabled(mode, false);
        for q in [0.05, 0.2, 1.0, 5.0] {
            let lattice = sheet.lattice(lumping(&fabric(false)));
            let values =
                solved(lattice, mode, false, StretchMethod::ImplicitThreads, q / omega, 60);
            // The first substep has nothing to carry on.
            let off = values[1..]
                .windows(4)
                .map(|x| (2.0 + q * q) * x[3] - (5.0 * x[2] - 4.0 * x[1] + x[0]));
            let worst = off.map(f64::abs).fold(0.0, f64::max) / (2.0 + q * q);
            check_at_most(&format!("mode {mode}, omega h {q}: off the recurrence"), worst, 2e-4);
        }
    }
}

#[test]
fn threads_damp_by_the_fourth_power_of_the_substep() {
    let sheet = strip(CELLS, 1.0);
    let omega = tabled(1, false);
    // Of the roots of `(2 + q^2) z^3 - 5 z^2 + 4 z - 1`: the logarithm of their size, and the angle.
    for (q, decay, turned) in [(0.2, 6.908e-4, 0.19663), (0.4, 7.895e-3, 0.37760)] {
        let lattice = sheet.lattice(lumping(&fabric(false)));
        let values = solved(lattice, 1, false, StretchMethod::ImplicitThreads, q / omega, 100);
        let (factor, angle) = turn(&values[BEGINNING..]);
        check(&format!("omega h {q}: decay of a substep"), -factor.ln(), decay, 0.03 * decay);
        check(&format!("omega h {q}: angle of a substep"), angle, turned, 2e-3 * turned);
    }
}

/// A vertex between four that are held, which swings along one of the two chains that meet in it.
#[test]
fn chains_follow_a_recurrence_of_second_order() {
    const KEPT: f64 = 0.6;
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z];
    let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
    let graph = Arc::new(Graph::new(&corners, &fan, MassLumping::Lumped).unwrap());
    let mut start = corners;
    start[0] += Vec3::X * AMPLITUDE as f32;
    let swing = |h: f32| {
        let material = Material { thread_stiffness: 1.0, ..plain() };
        let settings = settings(StretchMethod::ImplicitThreads, 1);
        let mut solver = ClothSolver::new(graph.clone(), &start, material, settings).unwrap();
        solver.set_pins(&[1, 2, 3, 4]).unwrap();
        let pins = still(&solver);
        let input = StepInput { dt: h, pins: &pins, gravity: Vec3::ZERO, ..StepInput::default() };
        let x: Vec<_> = (0..40)
            .map(|_| {
                solver.tick(&input).unwrap();
                f64::from(solver.position(0).x) / AMPLITUDE
            })
            .collect();
        // The two sides of the recurrence, whose ratio is the square of omega h. The first substep has nothing to carry on.
        let sides = x[1..].windows(4).map(|x| {
            let motion = x[3] - (2.0 + KEPT) * x[2] + (1.0 + 2.0 * KEPT) * x[1] - KEPT * x[0];
            [-motion, KEPT * x[3] + (1.0 - 2.0 * KEPT) * x[2]]
        });
        let sums = sides.clone().fold([0.0; 2], |[a, b], [m, f]| [a + m * f, b + f * f]);
        let square = sums[0] / sums[1];
        let worst = sides.map(|[m, f]| (m - square * f).abs()).fold(0.0, f64::max);
        check_at_most(&format!("substep {h}: off the recurrence"), worst, 2e-4);
        square
    };
    let (square, of_twice) = (swing(0.1), swing(0.2));
    assert!(square > 0.05, "{square}");
    check("square of twice the substep", of_twice / square, 4.0, 0.01);
}
