//! Soft pins, held to the closed forms of a mass on a spring: the offset `m g / k`, the period
//! `2 pi sqrt(m / k)`, the decay `exp(-c t / 2 m)`; and to statics where they carry a cloth: their forces
//! are its weight.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, Isa, MassLumping, Material, ParameterError, PinMotion, Settings, SoftPin,
    SolverError, StepInput, StretchMethod,
};

use crate::support::solver::*;

/// The smallest lattice, every particle on a spring of its own: four masses that move alike.
fn on_springs(stiffness: f32, damping: f32, substeps: u32) -> (ClothSolver, f64) {
    let lattice = sheet(Vec2::splat(0.2), 2, 2, MassLumping::Lumped);
    let mut solver =
        at_rest(&lattice, Vec3::ZERO, plain(), settings(StretchMethod::ImplicitThreads, substeps));
    let pins: Vec<_> = (0..4).map(|particle| SoftPin { particle, stiffness, damping }).collect();
    solver.set_soft_pins(&pins).unwrap();
    // 0.2 kg/m2 of 0.04 m2 on four particles.
    let mass = 0.2 * 0.04 / 4.0;
    check("mass [kg]", f64::from(solver.mass(0)), mass, 1e-9);
    (solver, mass)
}

fn ticks_to(solver: &mut ClothSolver, targets: &[Vec3], gravity: Vec3, ticks: usize) -> Vec<Vec3> {
    let pins: Vec<_> = targets.iter().map(|&p| PinMotion::still(p)).collect();
    let input =
        StepInput { dt: TICK, gravity, pins: &pins, colliders: &[], ..StepInput::default() };
    (0..ticks)
        .map(|_| {
            solver.tick(&input).unwrap();
            solver.position(0) - targets[0]
        })
        .collect()
}

#[test]
fn a_mass_hangs_by_its_weight_over_the_stiffness() {
    for stiffness in [0.1, 1.0, 100.0, 1e4] {
        for substeps in [1, 8] {
            let (_, mass) = on_springs(stiffness, 0.0, substeps);
            let critical = 2.0 * (mass * f64::from(stiffness)).sqrt();
            let (mut solver, mass) = on_springs(stiffness, critical as f32, substeps);
            let targets = positions(&solver);
            let offset = *ticks_to(&mut solver, &targets, GRAVITY, 400).last().unwrap();
            let expected = -mass * 9.81 / f64::from(stiffness);
            let what = format!("{stiffness} N/m x{substeps}, offset [m]");
            check(&what, f64::from(offset.y), expected, 2e-4 * expected.abs() + 1e-7);
        }
    }
}

#[test]
fn a_mass_swings_in_its_period_and_decays_as_its_damper_says() {
    let omega = 20.0_f64;
    for ratio in [0.05, 0.2] {
        let (_, mass) = on_springs(1.0, 0.0, 32);
        let (stiffness, damping) = (mass * omega * omega, 2.0 * ratio * mass * omega);
        let (mut solver, _) = on_springs(stiffness as f32, damping as f32, 32);
        let targets: Vec<_> = positions(&solver).iter().map(|p| *p + Vec3::X * 0.1).collect();
        let track = ticks_to(&mut solver, &targets, Vec3::ZERO, 128);
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        let phase = (ratio / (1.0 - ratio * ratio).sqrt()).atan();
        let mut worst = 0.0_f64;
        for (tick, offset) in track.iter().enumerate() {
            let t = f64::from(TICK) * (tick + 1) as f64;
            // The solution that starts at rest.
            let expected =
                -0.1 * (-ratio * omega * t).exp() * (damped * t - phase).cos() / phase.cos();
            worst = worst.max((f64::from(offset.x) - expected).abs());
        }
        check_at_most(&format!("ratio {ratio}, from the closed form [A]"), worst / 0.1, 4e-3);
    }
}

#[test]
fn soft_pins_carry_the_weight_of_a_cloth_in_both_forms() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        // Far stiffer than a particle of the cloth could feel alone in a substep, and softer.
        for stiffness in [5.0, 50.0, 500.0] {
            let lattice = curtain(Vec2::ONE, 17, 17, MassLumping::Lumped);
            let material = Material { drag: 4.0, ..plain() };
            let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings(form, 24));
            let pins: Vec<_> = (0..17)
                .map(|particle| SoftPin { particle, stiffness, damping: 0.1 * stiffness })
                .collect();
            solver.set_soft_pins(&pins).unwrap();
            let targets: Vec<_> = positions(&solver)[..17].to_vec();
            ticks_to(&mut solver, &targets, GRAVITY, 600);
            let force: f64 =
                (0..17).map(|i| f64::from((targets[i].y - solver.position(i).y) * stiffness)).sum();
            check(&format!("{form:?} {stiffness} N/m, force [N]"), force, 0.2 * 9.81, 2e-3);
        }
    }
}

#[test]
fn no_stiffness_is_too_high_and_none_exceeds_the_speed_limit() {
    // The damper alone leaves exp(-k t / c) of the way, t a second.
    for (damping, left) in [(0.0, 0.0), (1e9, 10.0 * (-1.0_f64).exp())] {
        let (mut solver, _) = on_springs(1e9, damping, 4);
        let targets: Vec<_> = positions(&solver).iter().map(|p| *p + Vec3::Y * 10.0).collect();
        let track = ticks_to(&mut solver, &targets, GRAVITY, 64);
        let longest = 100.0 * TICK * 1.001;
        assert!(track.windows(2).all(|pair| pair[0].distance(pair[1]) <= longest));
        check("from the target [m]", f64::from(track[63].length()), left, 0.01);
    }
}

#[test]
fn a_target_that_moves_evenly_is_followed_without_lag() {
    let (mut solver, _) = on_springs(1000.0, 10.0, 8);
    let home = positions(&solver);
    let mut at = Vec3::ZERO;
    for _ in 0..200 {
        let way = Vec3::X * 0.02;
        let pins: Vec<_> =
            home.iter().map(|&p| PinMotion { start: p + at, end: p + at + way }).collect();
        at += way;
        let input = StepInput {
            dt: TICK,
            gravity: Vec3::ZERO,
            pins: &pins,
            colliders: &[],
            ..StepInput::default()
        };
        solver.tick(&input).unwrap();
    }
    check_at_most("lag [m]", f64::from(solver.position(0).distance(home[0] + at)), 1e-5);
}

#[test]
fn a_hard_pin_wins_and_every_instruction_set_agrees() {
    let run = |isa: Isa| {
        let lattice = curtain(Vec2::ONE, 9, 21, MassLumping::Lumped);
        let mut solver = at_rest(&lattice, Vec3::ZERO, plain(), Settings::default());
        solver.set_isa(isa);
        let soft = [0, 7, 20].map(|particle| SoftPin { particle, stiffness: 3.0, damping: 0.01 });
        solver.set_soft_pins(&soft).unwrap();
        solver.set_pins(&[0]).unwrap();
        let still = |p: u32| PinMotion::still(lattice.rest_positions()[p as usize]);
        let pins = [0, 0, 7, 20].map(still);
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            pins: &pins,
            colliders: &[],
            ..StepInput::default()
        };
        for _ in 0..60 {
            solver.tick(&input).unwrap();
        }
        assert_eq!(solver.position(0), lattice.rest_positions()[0]);
        assert_ne!(solver.position(7), lattice.rest_positions()[7]);
        bits(&solver)
    };
    let reference = run(Isa::Baseline);
    for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        assert_eq!(run(isa), reference, "{isa:?}");
    }
}

#[test]
fn what_cannot_be_a_soft_pin_is_refused() {
    let (mut solver, _) = on_springs(1.0, 0.0, 4);
    let before: Vec<_> = solver.soft_pins().copied().collect();
    for (stiffness, damping, field) in [
        (0.0, 0.0, "stiffness"),
        (-1.0, 0.0, "stiffness"),
        (f32::NAN, 0.0, "stiffness"),
        (f32::INFINITY, 0.0, "stiffness"),
        (1.0, -1.0, "damping"),
        (1.0, f32::NAN, "damping"),
        (1.0, f32::INFINITY, "damping"),
    ] {
        let refused = solver.set_soft_pins(&[SoftPin { particle: 0, stiffness, damping }]);
        assert!(
            matches!(refused, Err(SolverError::Parameter(ParameterError { name, .. })) if name == field)
        );
    }
    let nowhere = [SoftPin { particle: 4, stiffness: 1.0, damping: 0.0 }];
    let expected = SolverError::NoSuchParticle { particle: 4, count: 4 };
    assert_eq!(solver.set_soft_pins(&nowhere), Err(expected));
    assert_eq!(solver.soft_pins().copied().collect::<Vec<_>>(), before);
    let input =
        StepInput { dt: TICK, gravity: GRAVITY, pins: &[], colliders: &[], ..StepInput::default() };
    assert_eq!(solver.tick(&input), Err(SolverError::WrongPinCount { pins: 4, motions: 0 }));
}
