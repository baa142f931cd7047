//! Mass and stiffness that vary over a lattice, held to bit equality with materials that are as much
//! heavier and stiffer, and to the balance of forces in a hanging chain: each spring carries what
//! hangs below it.

use std::sync::Arc;

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{Lattice, LatticeError, MassLumping, Material, Settings, StretchMethod};

use crate::support::solver::*;

fn weighted(lattice: &Lattice, mass: &[f32], stiffness: &[f32]) -> Arc<Lattice> {
    Arc::new(lattice.clone().with_weights(mass, stiffness).unwrap())
}

#[test]
fn equal_factors_are_another_material_to_the_bit() {
    let plain = Material {
        area_density: 0.25,
        thread_stiffness: 64.0,
        shear_stiffness: 16.0,
        flexural_rigidity: 1e-4,
        ..plain()
    };
    // Powers of two, so that no product is rounded.
    let (m, s) = (4.0, 0.5);
    let other = Material {
        area_density: m * plain.area_density,
        thread_stiffness: s * plain.thread_stiffness,
        shear_stiffness: s * plain.shear_stiffness,
        flexural_rigidity: s * plain.flexural_rigidity,
        ..plain
    };
    let lattice = sheet(Vec2::new(1.0, 0.8), 5, 7, MassLumping::Lumped);
    let heavier = weighted(&lattice, &[m; 35], &[s; 35]);
    assert!((heavier.total_area() - 0.8).abs() < 1e-6, "no more cloth, only more of it");
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let settings = Settings { tethers: false, ..settings(form, 16) };
        let hung = |lattice: &Arc<Lattice>, material| {
            let mut solver = at_rest(lattice, Vec3::ZERO, material, settings);
            solver.set_pins(&[0, 6]).unwrap();
            run(&mut solver, 30, GRAVITY, &[]);
            solver
        };
        let (by_factors, by_material) = (hung(&heavier, plain), hung(&lattice, other));
        assert!(bits(&by_factors) == bits(&by_material), "{form:?}");
        assert_eq!(by_factors.mass(8), by_material.mass(8));
        assert!(by_factors.position(20).y < -0.05, "it hangs");
    }
}

#[test]
fn each_spring_of_a_chain_carries_what_hangs_below_it() {
    let (rows, cell) = (6, 0.1_f64);
    let lattice = curtain(Vec2::new(0.1, 0.5), rows, 2, MassLumping::Lumped);
    let mass = [1.0, 3.0, 0.5, 1.0, 2.0, 8.0];
    let stiffness = [1.0, 2.0, 4.0, 1.0, 0.5, 0.5];
    let both = |f: [f32; 6]| f.iter().flat_map(|&f| [f, f]).collect::<Vec<_>>();
    let lattice = weighted(&lattice, &both(mass), &both(stiffness));
    let material = Material { drag: 4.0, thread_stiffness: 100.0, ..plain() };
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let settings = Settings { tethers: false, ..settings(form, 24) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
        solver.set_pins(&[0, 1]).unwrap();
        run(&mut solver, 1500, GRAVITY, &[]);
        let mut weight = 0.0;
        for row in (1..rows).rev() {
            // A quarter of a cell in the last row, a half in the others, per column.
            let area = if row == rows - 1 { 0.25 } else { 0.5 } * cell * cell;
            weight += f64::from(mass[row]) * area * 0.2 * 9.81;
            let mean = f64::from(stiffness[row - 1] + stiffness[row]) / 2.0;
            // The cloth is a cell wide, half of it a column.
            let expected = weight / (mean * 100.0 * 0.5 * cell);
            let length = solver.position(2 * row).distance(solver.position(2 * row - 2));
            let strain = f64::from(length) / cell - 1.0;
            check(&format!("{form:?}, strain above row {row}"), strain, expected, 2e-3 * expected);
        }
    }
}

#[test]
fn factors_that_cannot_be_used_are_refused() {
    let lattice = Lattice::sheet(Vec2::ONE, 2, 3, MassLumping::Lumped).unwrap();
    let problem = |mass: &[f32], stiffness: &[f32]| {
        lattice.clone().with_weights(mass, stiffness).unwrap_err()
    };
    let wrong = LatticeError::WrongFactorCount { expected: 6, got: 5 };
    assert_eq!(problem(&[1.0; 5], &[1.0; 6]), wrong);
    assert_eq!(problem(&[1.0; 6], &[1.0; 5]), wrong);
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let mut factors = [1.0; 6];
        factors[4] = bad;
        for error in [problem(&factors, &[1.0; 6]), problem(&[1.0; 6], &factors)] {
            assert!(matches!(error, LatticeError::BadFactor { particle: 4, .. }), "{error}");
        }
    }
}
