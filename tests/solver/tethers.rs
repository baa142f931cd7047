//! Tethers change no equilibrium that the cloth's own threads and shear reach: with and without
//! them.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{ClothSolver, MassLumping, Material, Settings, StretchMethod};

use crate::support::solver::*;

fn settled(solver: &ClothSolver, tethers: bool, pins: &[u32], ticks: usize) -> ClothSolver {
    let mut solver = solver.clone();
    solver.set_settings(Settings { tethers, ..*solver.settings() }).unwrap();
    solver.set_pins(pins).unwrap();
    run(&mut solver, ticks, GRAVITY, &[]);
    solver
}

#[test]
fn a_hanging_strip_is_the_same_with_and_without() {
    for stiffness in [20.0, 200.0, 2000.0] {
        let lattice = curtain(Vec2::new(0.4, 1.0), 21, 5, MassLumping::Lumped);
        let material = Material { thread_stiffness: stiffness, drag: 15.0, ..plain() };
        let solver =
            at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ImplicitThreads, 16));
        for pins in [vec![0, 1, 2, 3, 4], vec![0, 4], vec![0, 1, 3, 4]] {
            let with = settled(&solver, true, &pins, 320);
            let without = settled(&solver, false, &pins, 320);
            let apart = farthest(&positions(&with), &positions(&without));
            // Between two single pins the first row's half threads carry more than a tether leaves
            // room
            // for: 1.73 against 1.70 %.
            let most = if pins.len() == 2 { 3e-4 } else { 1e-5 };
            check_at_most(&format!("{stiffness} N/m, pins {pins:?}, apart [m]"), apart, most);
        }
    }
}

#[test]
fn a_sheet_hung_on_the_bias_shears_as_far_as_without() {
    for shear in [30.0, 0.0] {
        let lattice = curtain(Vec2::ONE, 21, 21, MassLumping::Lumped);
        let material = Material {
            thread_stiffness: 2000.0,
            shear_stiffness: shear,
            flexural_rigidity: 1e-5,
            drag: 4.0,
            ..plain()
        };
        let settings =
            Settings { provot_passes: 2, ..settings(StretchMethod::ImplicitThreads, 16) };
        let solver = at_rest(&lattice, Vec3::ZERO, material, settings);
        let with = settled(&solver, true, &[0], 384);
        let without = settled(&solver, false, &[0], 384);
        let lowest = |s: &ClothSolver| f64::from(s.bounds().0.y);
        check(
            &format!("shear {shear} N/m, lowest point [m]"),
            lowest(&with),
            lowest(&without),
            1e-4,
        );
        // Along the diagonal the cloth is 1.414 m, along its threads 2 m.
        assert!(lowest(&with) < -1.42, "the bias did not give");
    }
}
