//! A strip hung from its top row, held to the statics of a chain: each spring carries what is below
//! it.
//! Lumped, the elongation is eps / 2 at any resolution; the tables are
//! `data/hanging_strip_elongation.csv` and `data/hanging_chain_profile.csv`.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{ClothSolver, MassLumping, Material, Settings, StretchMethod};

use crate::support::solver::*;

const K: f32 = 20.0;
const COLUMNS: usize = 5;

/// Settled depths below the pins by row and column, for eps = `springs m g / k`.
fn depths(
    form: StretchMethod,
    lumping: MassLumping,
    springs: usize,
    gravity: f32,
) -> Vec<Vec<f64>> {
    let lattice = curtain(Vec2::new(0.4, 1.0), springs + 1, COLUMNS, lumping);
    let material = Material { thread_stiffness: K, drag: 15.0, ..plain() };
    let settings = Settings { lumping, tethers: false, ..settings(form, 16) };
    let mut solver: ClothSolver = at_rest(&lattice, Vec3::ZERO, material, settings);
    solver.set_pins(&(0..COLUMNS as u32).collect::<Vec<_>>()).unwrap();
    run(&mut solver, 256, Vec3::NEG_Y * gravity, &[]);
    assert!(!solver.plan().clamped.thread);
    (0..=springs)
        .map(|r| (0..COLUMNS).map(|c| -f64::from(solver.position(r * COLUMNS + c).y)).collect())
        .collect()
}

#[test]
fn a_lumped_strip_lengthens_by_half_eps_at_any_resolution() {
    // eps = rho g L / k = 0.1 for g = 10 m/s2.
    for row in table(include_str!("../data/hanging_strip_elongation.csv")) {
        if row[1] != "0.1" || row[2] != "half" || row[0] == "50" {
            continue;
        }
        let springs: usize = row[0].parse().unwrap();
        let reference: f64 = row[3].parse().unwrap();
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            let depths = depths(form, MassLumping::Lumped, springs, 10.0);
            for (column, depth) in depths[springs].iter().enumerate() {
                let what = format!("{form:?}, {springs} springs, column {column}, elongation / L");
                check(&what, depth - 1.0, reference, 2e-6);
            }
            // Node by node: the part above carries less and less, y = s + eps (s - s^2 / 2).
            for (i, row) in depths.iter().enumerate() {
                let s = i as f64 / springs as f64;
                assert!((row[2] - s - 0.1 * (s - s * s / 2.0)).abs() < 2e-6, "{form:?} node {i}");
            }
        }
    }
}

#[test]
fn a_strip_of_equal_masses_is_the_chain_of_full_masses() {
    let springs = 20;
    // A particle weighs rho L W / (rows columns) and a spring is k (W / 4) / a: the eps of the
    // table,
    // N m g / (k a), is 0.1 for this gravity.
    let mass = 0.2 * 0.4 / (21.0 * COLUMNS as f64);
    let spring = f64::from(K) * 0.1 / 0.05;
    let gravity = 0.1 * spring / (20.0 * 20.0 * mass);
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let depths = depths(form, MassLumping::Equal, springs, gravity as f32);
        for row in table(include_str!("../data/hanging_chain_profile.csv")) {
            if row[0] != "20" || row[1] != "0.1" {
                continue;
            }
            let node: usize = row[2].parse().unwrap();
            let reference: f64 = row[3].parse().unwrap();
            for (column, &depth) in depths[node].iter().enumerate() {
                check(
                    &format!("{form:?}, node {node}, column {column}, depth / L"),
                    depth,
                    reference,
                    3e-6,
                );
            }
        }
    }
}

#[test]
fn shear_does_not_change_with_the_cell() {
    // Simple shear of an otherwise slack sheet: one row held, the last row's weight across it.
    // F = G W gamma, so the drop of the far side is rho g L^2 / (2 G), eps / 2 with G for k.
    let mut drops = Vec::new();
    for cells in [4, 8] {
        let lattice = sheet(Vec2::new(4.0, 1.0), cells + 1, 4 * cells + 1, MassLumping::Lumped);
        let material =
            Material { thread_stiffness: 2000.0, shear_stiffness: 100.0, drag: 10.0, ..plain() };
        let settings = Settings { tethers: false, ..settings(StretchMethod::ExplicitSprings, 32) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
        let columns = lattice.columns();
        solver.set_pins(&(0..columns as u32).collect::<Vec<_>>()).unwrap();
        // Along x, in the sheet's plane, across the held row.
        run(&mut solver, 256, Vec3::X * 1.0, &[]);
        assert!(!solver.plan().clamped.shear && !solver.plan().clamped.thread, "{}", solver.plan());
        let middle = cells * columns + columns / 2;
        let drop = solver.position(middle).x - lattice.rest_positions()[middle].x;
        drops.push(f64::from(drop));
    }
    // Away from the free sides; those turn the shear a little.
    check("side drop [m], 8 cells", drops[1], 0.2 * 1.0 / (2.0 * 100.0), 4e-5);
    check("side drop [m], 4 cells", drops[0], drops[1], 4e-5);
}
