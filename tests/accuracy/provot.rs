//! Provot's correction by itself. Held to the rate at which Gauss-Seidel passes of any consistent order
//! converge on a chain, which is that of `data/provot_chain_convergence.csv`; to the momenta that one
//! correction leaves; and to what remains of the excess in a run of small substeps.

use bevy::math::{DVec3, Quat, Vec2, Vec3};
use bevy_drape::solver::{ClothSolver, MassLumping, Material, Settings, StretchMethod};

use super::scenes::*;
use crate::support::solver::*;

/// Largest strain of a chain of `springs` springs held at its top, all 50 % too long, after so many passes
/// with a limit of 10 %.
fn after(springs: usize, passes: u32) -> f64 {
    let sheet = strip(springs, 1.0);
    let material = Material { thread_stiffness: 0.0, max_strain: 0.1, ..plain() };
    let base = settings(StretchMethod::ExplicitSprings, 1);
    let settings =
        Settings { provot_passes: passes, tethers: false, lumping: MassLumping::Equal, ..base };
    let lattice = sheet.lattice(MassLumping::Equal);
    let stretch = Vec3::new(1.0, 1.0, 1.5);
    let start: Vec<_> = lattice.rest_positions().iter().map(|&p| p * stretch).collect();
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    solver.set_pins(&[0, 1, 2]).unwrap();
    run(&mut solver, 1, Vec3::ZERO, &[]);
    let cell = 1.0 / springs as f64;
    let strain = |i: usize| {
        let at = |row: usize| solver.position(3 * row + 1).as_dvec3();
        at(i).distance(at(i + 1)) / cell - 1.0
    };
    (0..springs).map(strain).fold(f64::MIN, f64::max)
}

#[test]
fn passes_converge_as_slowly_as_the_table_says() {
    let rows = table(include_str!("../data/provot_chain_convergence.csv"));
    let tabled = |springs: usize, passes: u32| -> f64 {
        let of = |r: &&Vec<String>| {
            r[0].parse() == Ok(springs) && r[1] == "top_down" && r[2].parse() == Ok(passes)
        };
        rows.iter().find(of).unwrap()[4].parse().unwrap()
    };
    for (springs, first, second) in
        [(10, 50, 200), (20, 200, 500), (20, 500, 1000), (40, 500, 1000)]
    {
        let per_pass = |a: f64, b: f64| (a / b).ln() / f64::from(second - first);
        let excess = |passes| after(springs, passes) - 0.1;
        let (measured, expected) = (
            per_pass(excess(first), excess(second)),
            per_pass(tabled(springs, first), tabled(springs, second)),
        );
        let what = format!("{springs} springs, {first} to {second} passes: decay of a pass");
        check(&what, measured, expected, 0.03 * expected);
    }
    // Four times the passes for twice the springs.
    let passes = |springs: usize| {
        let (mut low, mut high) = (1, 1000);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if after(springs, middle) > 0.105 { low = middle } else { high = middle }
        }
        high
    };
    let [few, many] = [8, 16].map(passes);
    println!("passes to bring the excess below 0.5 %: {few} for 8 springs, {many} for 16");
    check("passes for twice the springs, relative", f64::from(many) / f64::from(few), 4.0, 0.4);
}

#[test]
fn no_order_of_passes_raises_the_strain_beyond_twice_the_first() {
    for springs in [10, 20, 40] {
        check_at_most(
            &format!("{springs} springs, strain after one pass"),
            after(springs, 1),
            1.0 + 1e-6,
        );
    }
}

#[test]
fn one_correction_keeps_both_momenta() {
    // A cell askew, its long springs too long alone: what moves, moves along them.
    let lattice = sheet(Vec2::new(0.2, 0.1), 2, 2, MassLumping::Equal);
    let turn = Quat::from_rotation_z(0.4) * Quat::from_rotation_x(1.1);
    let place = |p: &Vec3| turn * (*p * Vec3::new(1.5, 1.0, 1.0)) + Vec3::new(0.3, 0.2, -0.1);
    let start: Vec<_> = lattice.rest_positions().iter().map(place).collect();
    let material = Material { thread_stiffness: 0.0, max_strain: 0.1, ..plain() };
    let settings =
        Settings { lumping: MassLumping::Equal, ..settings(StretchMethod::ExplicitSprings, 1) };
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    run(&mut solver, 1, Vec3::ZERO, &[]);
    let (mut linear, mut angular, mut moved) = (DVec3::ZERO, DVec3::ZERO, 0.0_f64);
    for (i, x) in start.iter().enumerate() {
        let d = solver.position(i).as_dvec3() - x.as_dvec3();
        linear += d;
        angular += x.as_dvec3().cross(d);
        moved = moved.max(d.length());
    }
    check("moved [m]", moved, 0.2 * (1.5 - 1.1) / 2.0, 1e-6);
    check_at_most("momentum, of what moved", linear.length() / moved, 1e-6);
    check_at_most("angular momentum, of what moved [m]", angular.length() / moved, 1e-6);
}

/// Largest strain, after 3 s, of the strip 10 springs long whose threads would stretch by more than 10 %.
fn excess(substeps: u32) -> f64 {
    let springs = 10;
    let sheet = strip(springs, 1.0);
    let material =
        Material { thread_stiffness: 2.0, damping: 0.01, drag: 4.0, max_strain: 0.1, ..plain() };
    let settings =
        Settings { tethers: false, ..settings(StretchMethod::ExplicitSprings, substeps) };
    let mut solver = at_rest(&sheet.lattice(MassLumping::Lumped), Vec3::ZERO, material, settings);
    solver.set_pins(&[0, 1, 2]).unwrap();
    run(&mut solver, 256, Vec3::Z * 9.81, &[]);
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    largest(&strains(&solver)) - 0.1
}

#[test]
fn one_pass_leaves_an_excess_of_the_squared_substep() {
    let excess = [4, 8, 16].map(excess);
    println!("excess over 10 % with x4, x8, x16: {excess}", excess = list(&excess));
    check("order of the excess", (excess[0] / excess[2]).log2() / 2.0, 2.0, 0.25);
}
