//! Held to `x0 + v0 t + g t^2 / 2`, which Verlet gives without error, to the exact solution of
//! `v' = g - c v`, and to bit equality far from the world's origin.

use std::sync::Arc;

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{ClothSolver, DampingForm, Lattice, MassLumping, Material, StretchMethod};

use crate::support::solver::*;

const V0: Vec3 = Vec3::new(1.0, 2.0, -0.5);

fn thrown(offset: Vec3, form: StretchMethod, substeps: u32, material: Material) -> ClothSolver {
    let grid: Vec<_> = (0..88)
        .map(|i| Vec3::new((i % 11) as f32 - 5.0, 0.0, (i / 11) as f32 - 4.0) / 16.0)
        .collect();
    let lattice = Arc::new(Lattice::new(8, 11, &grid, MassLumping::Lumped).unwrap());
    let mut solver = at_rest(&lattice, offset, material, settings(form, substeps));
    for i in 0..lattice.particle_count() {
        solver.set_velocity(i, V0).unwrap();
    }
    solver
}

fn damped(form: DampingForm) -> Material {
    Material {
        thread_stiffness: 20.0,
        shear_stiffness: 5.0,
        flexural_rigidity: 1e-4,
        damping: 0.01,
        damping_form: form,
        ..plain()
    }
}

/// Largest distance from the parabola over a second, and largest strain at its end.
fn departure(mut solver: ClothSolver) -> (f64, f64) {
    let start = positions(&solver);
    let mut worst = 0.0_f64;
    for tick in 1..=64 {
        run(&mut solver, 1, GRAVITY, &[]);
        let t = f64::from(tick) / 64.0;
        for (i, x0) in start.iter().enumerate() {
            let exact = x0.as_dvec3() + V0.as_dvec3() * t + GRAVITY.as_dvec3() * (0.5 * t * t);
            worst = worst.max(solver.position(i).as_dvec3().distance(exact));
        }
    }
    let strain = strains(&solver).iter().fold(0.0, |most: f64, s| most.max(s.abs()));
    (worst, strain)
}

#[test]
fn a_thrown_sheet_follows_the_parabola() {
    // f32 rounds each of the steps of a second: 1e-7 of 3 m, growing as their root.
    for (substeps, tolerance) in [(1, 4e-6), (4, 1e-5), (16, 3e-5), (64, 2e-4)] {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            for damping in [DampingForm::Axial, DampingForm::Relative] {
                let (away, strain) = departure(thrown(Vec3::ZERO, form, substeps, damped(damping)));
                let what = format!("{form:?} {damping:?} x{substeps}");
                check_at_most(&format!("{what}, from the parabola [m]"), away, tolerance);
                check_at_most(&format!("{what}, strain"), strain, 3e-5);
            }
        }
    }
}

#[test]
fn a_cloth_far_away_moves_with_the_same_bits() {
    // A 1/16 m grid is representable beside all of these places, which are multiples of 16 m.
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let mut here = thrown(Vec3::ZERO, form, 4, damped(DampingForm::Axial));
        for place in [Vec3::X * 1008.0, Vec3::new(-10_000.0, 4096.0, 10_000.0)] {
            let mut here = here.clone();
            let mut there = thrown(place, form, 4, damped(DampingForm::Axial));
            run(&mut here, 64, GRAVITY, &[]);
            run(&mut there, 64, GRAVITY, &[]);
            assert_eq!(bits(&here), bits(&there), "{form:?} at {place}");
            assert_eq!(there.origin() - here.origin(), place);
        }
        run(&mut here, 1, GRAVITY, &[]);
    }
}

#[test]
fn far_away_the_parabola_holds_to_an_ulp_of_the_place() {
    for (far, ulp) in [(1000.0, 6.2e-5), (10_000.0, 9.8e-4)] {
        let (away, _) = departure(thrown(
            Vec3::new(far, 0.0, -far),
            StretchMethod::ImplicitThreads,
            4,
            damped(DampingForm::Axial),
        ));
        check_at_most(&format!("from the parabola at {far} m [m]"), away, ulp);
    }
}

#[test]
fn a_long_fall_carries_the_origin_along() {
    let mut solver =
        thrown(Vec3::ZERO, StretchMethod::ExplicitSprings, 4, damped(DampingForm::Axial));
    solver
        .set_settings(bevy_drape::solver::Settings { max_speed: 1e4, ..*solver.settings() })
        .unwrap();
    let start = solver.position(40).as_dvec3();
    run(&mut solver, 640, GRAVITY, &[]);
    let exact = start + V0.as_dvec3() * 10.0 + GRAVITY.as_dvec3() * 50.0;
    let here = solver.origin().as_dvec3() + solver.local_position(40).as_dvec3();
    assert!(solver.origin().y < -400.0, "the origin stayed at {}", solver.origin());
    check_at_most("from the parabola after 10 s [m]", here.distance(exact), 5e-3);
    let (low, high) = solver.bounds();
    assert!(low.y > -475.0 && high.y < -465.0, "bounds {low} {high}");
}

/// Velocity and way at time t of `v' = g - c v`.
fn with_drag(c: f64, t: f64) -> (DVec3, DVec3) {
    let (v0, end) = (V0.as_dvec3(), GRAVITY.as_dvec3() / c);
    let decay = (-c * t).exp();
    (end + (v0 - end) * decay, end * t + (v0 - end) * ((1.0 - decay) / c))
}

#[test]
fn air_drag_is_exact_in_velocity_whatever_the_substeps() {
    let c = 2.0;
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for substeps in [1, 4, 16] {
            let material = Material { drag: c as f32, ..damped(DampingForm::Axial) };
            let mut solver = thrown(Vec3::ZERO, form, substeps, material);
            run(&mut solver, 64, GRAVITY, &[]);
            // The stored velocity is that of the last substep's middle.
            let middle = 1.0 - f64::from(TICK) / f64::from(substeps) / 2.0;
            let error = solver.velocity(13).as_dvec3().distance(with_drag(c, middle).0);
            check_at_most(
                &format!("{form:?} x{substeps}, velocity [m/s]"),
                error,
                1e-5 + 5e-6 * f64::from(substeps),
            );
            run(&mut solver, 640, GRAVITY, &[]);
            let speed = f64::from(solver.velocity(13).length());
            check(
                &format!("{form:?} x{substeps}, terminal speed [m/s]"),
                speed,
                9.81 / c,
                2e-5 * f64::from(substeps) + 2e-5,
            );
        }
    }
}

#[test]
fn the_way_under_drag_is_of_second_order() {
    let c = 8.0;
    let error = |substeps| {
        let material = Material { drag: c as f32, ..plain() };
        let mut solver = thrown(Vec3::ZERO, StretchMethod::ImplicitThreads, substeps, material);
        let start = solver.position(0).as_dvec3();
        run(&mut solver, 16, GRAVITY, &[]);
        (solver.position(0).as_dvec3() - start - with_drag(c, 0.25).1).length()
    };
    let (coarse, fine) = (error(1), error(4));
    check("order of the way under drag", (coarse / fine).log2() / 2.0, 2.0, 0.1);
}
