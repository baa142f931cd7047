//! Verlet, Euler and the midpoint method side by side. Truths: the factor and angle by which each turns an
//! oscillation in a substep (closed forms), the orders of convergence against the oscillator with drag and
//! damping, and bit equality between stages, instruction sets and topologies at rest.
//!
//! The oscillator is that of `spring`: lumped, `omega^2 = 4 k / (rho a^2)`; damped at `4 C / (rho a^2)`.

use bevy::math::{DVec2, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, DampingForm, Integrator, Isa, MassLumping, Material, Settings, StepInput,
    StretchMethod, Topology,
};

use crate::support::solver::*;

const CELL: f32 = 0.1;
const STIFFNESS: f32 = 0.25;
const AMPLITUDE: f64 = 0.01;
const ALL: [Integrator; 3] = [Integrator::Verlet, Integrator::Euler, Integrator::Midpoint];

fn omega() -> f64 {
    (4.0 * f64::from(STIFFNESS) / (0.2 * 0.01_f64)).sqrt()
}

fn oscillator(integrator: Integrator, substeps: u32, material: Material) -> ClothSolver {
    let lattice = sheet(Vec2::splat(CELL), 2, 2, MassLumping::Lumped);
    let wide = Vec3::new(1.2, 1.0, 1.0);
    let start: Vec<_> = lattice.rest_positions().iter().map(|&p| p * wide).collect();
    let settings = Settings { integrator, ..settings(StretchMethod::ExplicitSprings, substeps) };
    ClothSolver::new(lattice, &start, material, settings).unwrap()
}

fn soft() -> Material {
    Material { thread_stiffness: STIFFNESS, ..plain() }
}

fn way(solver: &ClothSolver) -> f64 {
    f64::from(solver.position(3).x) - 0.05
}

#[test]
fn an_oscillation_turns_and_grows_in_a_substep_as_the_closed_form_says() {
    for (integrator, substeps) in
        [(Integrator::Euler, 8), (Integrator::Midpoint, 1), (Integrator::Midpoint, 4)]
    {
        let q = omega() * f64::from(TICK) / f64::from(substeps);
        // The eigenvalue 1 + i q of Euler, and 1 + i q - q^2 / 2 of the midpoint method.
        let real = if integrator == Integrator::Euler { 1.0 } else { 1.0 - 0.5 * q * q };
        let eigenvalue = DVec2::new(real, q);
        let mut solver = oscillator(integrator, substeps, soft());
        assert!(!solver.plan().clamped.thread);
        let mut turned = DVec2::X;
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for _ in 0..32 {
            run(&mut solver, 1, Vec3::ZERO, &[]);
            (0..substeps).for_each(|_| turned = turned.rotate(eigenvalue));
            largest = largest.max(turned.length());
            worst = worst.max((way(&solver) / AMPLITUDE - turned.x).abs());
        }
        let what = format!("{integrator:?} x{substeps}, grown {largest:.3} times: off by [A]");
        check_at_most(&what, worst, 1e-4 * largest);
        assert!(largest > 1.0005, "the closed form grows");
    }
}

#[test]
fn each_converges_at_its_order_with_drag_and_damping_too() {
    let (drag, damping) = (0.8_f64, 0.0002_f64);
    let rate = drag + 4.0 * damping / (0.2 * 0.01);
    for (integrator, order) in
        [(Integrator::Verlet, 2.0), (Integrator::Euler, 1.0), (Integrator::Midpoint, 2.0)]
    {
        for braked in [false, true] {
            let rate = if braked { rate } else { 0.0 };
            let material = Material {
                drag: if braked { drag as f32 } else { 0.0 },
                damping: if braked { damping as f32 } else { 0.0 },
                ..soft()
            };
            // x'' = -omega^2 x - rate x', from rest, after 1 s.
            let turn = (omega().powi(2) - 0.25 * rate * rate).sqrt();
            let exact =
                AMPLITUDE * (-0.5 * rate).exp() * (turn.cos() + 0.5 * rate / turn * turn.sin());
            let error = |substeps| {
                let mut solver = oscillator(integrator, substeps, material);
                run(&mut solver, 64, Vec3::ZERO, &[]);
                way(&solver) - exact
            };
            // As fine as f32 lets it be seen.
            let finest = if order > 1.5 { 4 } else { 64 };
            let (coarse, fine) = (error(finest / 4), error(finest));
            let what =
                format!("{integrator:?}, braked {braked}: {coarse:.2e} to {fine:.2e}, order");
            check(&what, (coarse / fine).abs().log2() / 2.0, order, 0.12);
        }
    }
}

/// A sheet and a mesh that fall, stretched, in the wind of their own motion, held at a corner.
fn busy(topology: &Topology, integrator: Integrator, isa: Isa, staged: bool) -> Vec<[u32; 6]> {
    let material = Material {
        thread_stiffness: 50.0,
        shear_stiffness: 5.0,
        flexural_rigidity: 1e-5,
        damping: 0.003,
        damping_form: DampingForm::Relative,
        drag: 0.3,
        max_strain: 0.1,
        ..plain()
    };
    let settings = Settings { integrator, ..settings(StretchMethod::ExplicitSprings, 12) };
    let mut solver = at_rest(topology, Vec3::ZERO, material, settings);
    solver.set_isa(isa);
    solver.set_pins(&[0]).unwrap();
    let pins = still(&solver);
    let input =
        StepInput { dt: TICK, pins: &pins, gravity: Vec3::NEG_Y * 9.81, ..StepInput::default() };
    for _ in 0..10 {
        if staged {
            for _ in 0..solver.begin_tick(&input).unwrap() {
                solver.accumulate_forces(&input);
                solver.integrate(&input);
                solver.correct();
                solver.collide(&input);
            }
            solver.end_tick().unwrap();
        } else {
            solver.tick(&input).unwrap();
        }
    }
    assert_eq!(solver.position(0), topology.rest_positions()[0], "what is held stays");
    bits(&solver)
}

#[test]
fn all_give_the_same_bits_by_stages_and_on_every_instruction_set() {
    let sheet = sheet(Vec2::new(0.5, 0.7), 9, 21, MassLumping::Lumped);
    for topology in [sheet.into(), Topology::from(mesh(9, 12, 0.06, 0.2))] {
        let runs = ALL.map(|integrator| {
            let first = busy(&topology, integrator, Isa::Baseline, false);
            assert_eq!(first, busy(&topology, integrator, Isa::Baseline, true), "{integrator:?}");
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
                assert_eq!(first, busy(&topology, integrator, isa, false), "{isa:?}");
            }
            first
        });
        assert!(runs[0] != runs[1] && runs[1] != runs[2] && runs[0] != runs[2]);
    }
}

#[test]
fn a_fall_is_exact_but_for_half_a_kick_of_eulers() {
    // x = g t^2 / 2; Euler's method falls by the velocity of the substep's start, h v / 2 too little.
    let h = f64::from(TICK) / 4.0;
    for integrator in ALL {
        let lattice = sheet(Vec2::splat(1.0), 4, 4, MassLumping::Lumped);
        let settings = Settings { integrator, ..settings(StretchMethod::ExplicitSprings, 4) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, plain(), settings);
        run(&mut solver, 64, Vec3::NEG_Y * 9.81, &[]);
        let late = if integrator == Integrator::Euler { 0.5 * h * 9.81 } else { 0.0 };
        let fallen = -f64::from(solver.position(0).y);
        check(&format!("{integrator:?}, fall in a second [m]"), fallen, 4.905 - late, 2e-5);
    }
}
