//! One spring between two masses, held to the closed form of the discrete oscillator:
//! `x_n = A cos(n phi)` with `cos(phi) = 1 - h^2 omega^2 / 2`.
//!
//! The smallest lattice is two such oscillators side by side. By hand: its particles weigh a
//! quarter of
//! the cell; lumped, two half springs hold them, `omega^2 = 2 (k/2) / (rho a^2 / 4) = 4 k / (rho
//! a^2)`;
//! with equal masses two whole ones, twice that.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{ClothSolver, MassLumping, Material, Settings, StretchMethod};

use crate::support::solver::*;

const CELL: f32 = 0.1;
const AMPLITUDE: f64 = 0.01;

fn stretched(axis: usize, lumping: MassLumping, k: f32, substeps: u32) -> ClothSolver {
    let lattice = sheet(Vec2::splat(CELL), 2, 2, lumping);
    let mut wide = Vec3::ONE;
    wide[axis] += 0.2;
    let start: Vec<_> = lattice.rest_positions().iter().map(|&p| p * wide).collect();
    let settings = Settings { lumping, ..settings(StretchMethod::ExplicitSprings, substeps) };
    let material = Material { thread_stiffness: k, ..plain() };
    ClothSolver::new(lattice, &start, material, settings).unwrap()
}

#[test]
fn a_stretched_spring_pulls_its_ends_together_and_a_short_one_apart() {
    for (form, stretch) in [
        (StretchMethod::ExplicitSprings, 1.1),
        (StretchMethod::ImplicitThreads, 1.1),
        (StretchMethod::ExplicitSprings, 0.9),
        (StretchMethod::ImplicitThreads, 0.9),
    ] {
        let lattice = sheet(Vec2::splat(CELL), 2, 2, MassLumping::Lumped);
        let start: Vec<_> = lattice.rest_positions().iter().map(|&p| p * stretch).collect();
        let material = Material { thread_stiffness: 0.5, ..plain() };
        let mut solver = ClothSolver::new(lattice, &start, material, settings(form, 4)).unwrap();
        let before = strains(&solver)[0];
        run(&mut solver, 1, Vec3::ZERO, &[]);
        let after = strains(&solver)[0];
        check_at_most(
            &format!("{form:?}, strain {after:.4} over {before:.4}"),
            after / before,
            0.99,
        );
        assert!(after / before > 0.5, "one tick cannot bring a soft spring home");
    }
}

#[test]
fn one_springs_motion_is_the_discrete_closed_form() {
    let k = 0.25;
    for (lumping, factor) in [(MassLumping::Lumped, 4.0), (MassLumping::Equal, 8.0)] {
        let omega = (factor * f64::from(k) / (0.2 * 0.01_f64)).sqrt();
        for substeps in [1, 4] {
            let h = f64::from(TICK) / f64::from(substeps);
            let phi = (1.0 - (h * omega).powi(2) / 2.0).acos();
            for axis in [0, 2] {
                let mut solver = stretched(axis, lumping, k, substeps);
                assert!(!solver.plan().clamped.thread);
                let mut worst = 0.0_f64;
                for tick in 1..=100 {
                    run(&mut solver, 1, Vec3::ZERO, &[]);
                    let angle = f64::from(tick * substeps) * phi;
                    let expected = 0.05 + AMPLITUDE * angle.cos();
                    worst = worst.max((f64::from(solver.position(3)[axis]) - expected).abs());
                }
                // In 100 ticks the ODE itself is left by 0.4 (lumped) and 1.2 rad at one substep.
                let what = format!("{lumping:?} axis {axis} x{substeps}, h omega {:.2}", h * omega);
                check_at_most(
                    &format!("{what}, from the closed form [A]"),
                    worst / AMPLITUDE,
                    1e-4,
                );
            }
        }
    }
}

#[test]
fn the_oscillator_converges_to_second_order() {
    // Against the ODE's A cos(omega t) after 1 s; also from an initial velocity alone.
    let k = 0.25;
    let omega = (4.0 * f64::from(k) / (0.2 * 0.01_f64)).sqrt();
    for moving in [false, true] {
        let error = |substeps| {
            let mut solver = stretched(0, MassLumping::Lumped, k, substeps);
            let speed = 0.2;
            if moving {
                for i in 0..4 {
                    let away = solver.position(i).x.signum();
                    solver.set_position(i, solver.topology().rest_positions()[i]).unwrap();
                    solver.set_velocity(i, Vec3::X * away * speed).unwrap();
                }
            }
            run(&mut solver, 64, Vec3::ZERO, &[]);
            let way = f64::from(solver.position(3).x) - 0.05;
            let exact = if moving {
                f64::from(speed) / omega * omega.sin()
            } else {
                AMPLITUDE * omega.cos()
            };
            (way - exact).abs()
        };
        let (coarse, fine) = (error(2), error(8));
        check(&format!("order, moving {moving}"), (coarse / fine).log2() / 2.0, 2.0, 0.1);
    }
}

/// Damping by hand: two masses m and a damper C of half strength between them: their relative
/// velocity decays at `2 (C/2) / m`, here `4 C / (rho a^2)`.
#[test]
fn damping_is_of_second_order_and_brakes_at_its_rate() {
    let c = 0.002_f64;
    let rate = 4.0 * c / (0.2 * 0.01);
    let error = |substeps| {
        let material = Material { thread_stiffness: 0.0, damping: c as f32, ..plain() };
        let lattice = sheet(Vec2::splat(CELL), 2, 2, MassLumping::Lumped);
        let mut solver = at_rest(
            &lattice,
            Vec3::ZERO,
            material,
            settings(StretchMethod::ExplicitSprings, substeps),
        );
        for i in 0..4 {
            let away = solver.position(i).x.signum();
            solver.set_velocity(i, Vec3::X * away * 0.1).unwrap();
        }
        run(&mut solver, 16, Vec3::ZERO, &[]);
        let way = f64::from(solver.position(3).x) - 0.05;
        way - 0.1 / rate * (1.0 - (-rate * 0.25).exp())
    };
    check("way of a braked spring [m]", error(16), 0.0, 1e-6);
    let (coarse, fine) = (error(1), error(4));
    check("order of damping", (coarse / fine).abs().log2() / 2.0, 2.0, 0.25);
}
