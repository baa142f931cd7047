//! A strip clamped at one end under its own weight: Romero's cantilever. Held to the heavy elastica at
//! Gamma = 0.1 to 1000 (`data/heavy_elastica_master.csv`), to the exact discrete equilibria
//! (`data/discrete_cantilever_convergence.csv`) and, for flexion springs, to the elastica of their quartic
//! energy (`data/quartic_elastica_master.csv`).
//!
//! The clamp is two held rows. A hinge there counts double, which makes second differences of second order;
//! flexion springs have no such factor (it would be eight), and are of first order.

use std::sync::Arc;

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{Graph, MassLumping, StretchMethod, Topology};

use super::reference::{FLEXION_CURVATURE, Fabric, Hinge, Method, Model, Spring};
use super::scenes::*;
use crate::support::solver::*;

const STIFF: f64 = 1e6;
/// Flexion springs pull along the threads, which must not give way to them.
const FIRM: f64 = 1e10;

/// H/W of a master curve at a parameter.
fn master(text: &str, parameter: f64) -> f64 {
    let rows = table(text);
    let row = rows.iter().find(|r| (r[0].parse::<f64>().unwrap() / parameter - 1.0).abs() < 1e-9);
    row.unwrap_or_else(|| panic!("no {parameter} in the table"))[1].parse().unwrap()
}

fn elastica(gamma: f64) -> f64 {
    master(include_str!("../data/heavy_elastica_master.csv"), gamma)
}

fn quartic_elastica(gamma4: f64) -> f64 {
    master(include_str!("../data/quartic_elastica_master.csv"), gamma4)
}

/// A discrete strip's H/W as tabled: `(model, clamp, parameter, cells)`.
fn tabled(model: &str, clamp: &str, parameter: f64, cells: usize) -> f64 {
    let rows = table(include_str!("../data/discrete_cantilever_convergence.csv"));
    let row = rows.iter().find(|r| {
        r[0] == model && r[1] == clamp && r[2].parse() == Ok(parameter) && r[3].parse() == Ok(cells)
    });
    row.unwrap()[4].parse().unwrap()
}

/// H/W of a chain of length and weight one and of rigidity `1 / gamma`, whose clamped hinge counts `clamp`
/// times.
fn exact(clamp: f64, gamma: f64, cells: usize) -> f64 {
    let n = cells as f64;
    let count = cells + 2;
    let mut model = Model {
        mass: (0..count).map(|i| if i + 1 == count { 0.5 / n } else { 1.0 / n }).collect(),
        held: (0..count).map(|i| i < 2).collect(),
        // Links that stretch by 1e-7.
        springs: (0..count - 1)
            .map(|i| Spring { ends: [i, i + 1], constant: 1e7 * n, rest: 1.0 / n })
            .collect(),
        gravity: DVec3::NEG_Y,
        ..Model::default()
    };
    for i in 0..count - 2 {
        let factor = if i == 0 { clamp } else { 1.0 };
        let constant = factor * n.powi(3) / gamma;
        model.hinges.push(Hinge { at: [i, i + 1, i + 2], constant });
    }
    // A curve of about the right droop to begin with.
    let target = elastica(gamma);
    let curve = |tip: f64| {
        let mut x = vec![DVec3::new(0.0, 0.0, -1.0 / n), DVec3::ZERO];
        for i in 0..cells {
            let s = (i as f64 + 0.5) / n;
            let angle = tip * (1.0 - (1.0 - s).powi(3));
            x.push(x[i + 1] + DVec3::new(0.0, -angle.sin(), angle.cos()) / n);
        }
        x
    };
    let ratio = |x: &[DVec3]| -x[count - 1].y / x[count - 1].z;
    let (mut low, mut high) = (0.0, 1.57);
    for _ in 0..40 {
        let tip = 0.5 * (low + high);
        if ratio(&curve(tip)) < target { low = tip } else { high = tip }
    }
    ratio(&model.equilibrium(&curve(low)))
}

#[test]
fn the_reference_meets_the_discrete_table() {
    for gamma in [1.0, 10.0, 100.0] {
        for cells in [5, 10, 20, 40, 80] {
            for (name, clamp) in [("half", 2.0), ("full", 1.0)] {
                let expected = tabled("second_difference", name, gamma, cells);
                let what = format!("{name} clamp, gamma {gamma}, {cells} cells: H/W");
                check(&what, exact(clamp, gamma, cells), expected, 4e-6 * expected);
            }
        }
        // The one converges at second order, the other at first.
        for (clamp, order) in [(2.0, 2.0), (1.0, 1.0)] {
            let error = |cells| exact(clamp, gamma, cells) / elastica(gamma) - 1.0;
            let measured = (error(40) / error(80)).log2();
            check(&format!("gamma {gamma}, clamp x{clamp}: order"), measured, order, 0.12);
        }
    }
}

/// Makes a mesh of a sheet.
type ToMesh = fn(&Sheet, MassLumping) -> Arc<Graph>;

/// H/W of a settled strip of the solver's, of length 1 and the fabric's rigidity; a lattice where it is no mesh.
fn droop(fabric: &Fabric, cells: usize, mesh: Option<ToMesh>) -> f64 {
    let cell = 1.0 / cells as f64;
    let sheet = Sheet { cells: [2, cells + 1], cell: bevy::math::DVec2::splat(cell) };
    // Critical for the first mode, 3.5 sqrt(B / rho) / L^2, or for a chain's swing.
    let stiff = 7.0 * (fabric.rigidity / fabric.density).sqrt();
    let drag = if fabric.flexion { 8.0 } else { stiff.max(6.0) };
    let thread = if fabric.flexion { FIRM } else { STIFF };
    let fabric = Fabric { thread, drag, ..*fabric };
    // omega^2 = 32 B / (rho a^4), or four times the flexion constant over half the mass.
    let omega = if fabric.flexion {
        let constant = 8.0 * fabric.rigidity / FLEXION_CURVATURE.powi(2) / cell.powi(4);
        (4.0 * 2.0 * constant / (fabric.density * cell * cell)).sqrt()
    } else {
        (32.0 * fabric.rigidity / fabric.density).sqrt() / (cell * cell)
    };
    let more = if mesh.is_some() {
        4.0
    } else if fabric.flexion {
        2.0
    } else {
        1.0
    };
    let substeps = (more * f64::from(TICK) * omega / 1.8).ceil().max(16.0) as u32;
    let settings =
        settings_for(&fabric, Method::Verlet, settings(StretchMethod::ImplicitThreads, substeps));
    let topology: Topology = match mesh {
        Some(mesh) => mesh(&sheet, MassLumping::Lumped).into(),
        None => sheet.lattice(MassLumping::Lumped).into(),
    };
    let mut solver = at_rest(&topology, Vec3::ZERO, material(&fabric), settings);
    solver.set_pins(&[0, 1, 2, 3, 4, 5]).unwrap();
    settle(&mut solver, GRAVITY, 1e-6, 448);
    assert!(!solver.plan().clamped.bending, "{}", solver.plan());
    let tip = solver.position(3 * (cells + 1) + 1).as_dvec3();
    -tip.y / (tip.z - cell)
}

/// Rigidity for a Gamma.
fn rigidity(gamma: f64) -> f64 {
    0.2 * 9.81 / gamma
}

#[test]
fn second_differences_droop_as_the_elastica_at_second_order() {
    for (gamma, cells) in [
        (0.1, [5, 10, 20]),
        (1.0, [5, 10, 20]),
        (10.0, [5, 10, 20]),
        (100.0, [10, 20, 40]),
        (1000.0, [20, 40, 80]),
    ] {
        let master = elastica(gamma);
        let mut errors = Vec::new();
        for cells in cells {
            let fabric = Fabric { rigidity: rigidity(gamma), ..Fabric::default() };
            let measured = droop(&fabric, cells, None);
            let same = exact(2.0, gamma, cells);
            let what = format!("gamma {gamma}, {cells} cells: H/W");
            check(&what, measured, same, 6e-4 * same);
            errors.push((measured / master - 1.0, same / master - 1.0));
        }
        let order = |a: f64, b: f64| (a / b).abs().log2();
        let [first, second, third] = [errors[0], errors[1], errors[2]];
        println!("gamma {gamma}: errors {errors:.4?}");
        check(&format!("gamma {gamma}: reference's order"), order(second.1, third.1), 2.0, 0.15);
        let same = order(first.1, second.1);
        check(&format!("gamma {gamma}: solver's order"), order(first.0, second.0), same, 0.08);
        check_at_most(&format!("gamma {gamma}: finest error"), third.0.abs(), 0.03);
    }
}

#[test]
fn hinges_of_a_mesh_droop_as_the_elastica_at_second_order() {
    for gamma in [1.0, 10.0, 100.0] {
        let master = elastica(gamma);
        let fabric = Fabric { rigidity: rigidity(gamma), ..Fabric::default() };
        let error = |cells| droop(&fabric, cells, Some(Sheet::graph)) / master - 1.0;
        let (coarse, fine) = (error(8), error(16));
        println!("gamma {gamma}: mesh of 8 cells off by {coarse:.4}, of 16 by {fine:.4}");
        check(&format!("gamma {gamma}: order"), (coarse / fine).log2(), 2.0, 0.25);
        check_at_most(&format!("gamma {gamma}: error of 16 cells"), fine.abs(), 0.05);
    }
}

#[test]
fn hinges_of_an_irregular_mesh_droop_as_the_elastica() {
    // The order is lost in how the triangles of each mesh lie.
    for gamma in [1.0, 10.0, 100.0] {
        let fabric = Fabric { rigidity: rigidity(gamma), ..Fabric::default() };
        let error = droop(&fabric, 16, Some(Sheet::irregular)) / elastica(gamma) - 1.0;
        check_at_most(&format!("gamma {gamma}: error of 16 cells"), error.abs(), 0.08);
    }
}

#[test]
fn flexion_springs_follow_their_own_quartic_law_at_first_order() {
    // Their rigidity B stands for B4 = B / 20^2.
    let fabric = |gamma4: f64| Fabric {
        rigidity: 0.2 * 9.81 / gamma4 * FLEXION_CURVATURE.powi(2),
        flexion: true,
        ..Fabric::default()
    };
    for gamma4 in [1.0, 10.0, 100.0] {
        let mut errors = Vec::new();
        for cells in [5, 10, 20] {
            let measured = droop(&fabric(gamma4), cells, None);
            let same = tabled("bend_spring", "full", gamma4, cells);
            let what = format!("gamma4 {gamma4}, {cells} cells: H/W");
            check(&what, measured, same, 4e-3 * same);
            errors.push(measured / quartic_elastica(gamma4) - 1.0);
        }
        println!("gamma4 {gamma4}: errors {errors:.4?}");
        check(&format!("gamma4 {gamma4}: order"), (errors[1] / errors[2]).log2(), 1.0, 0.15);
    }
    // A light load's drop goes as its cube root.
    let (light, heavy) = (droop(&fabric(0.1), 10, None), droop(&fabric(0.8), 10, None));
    check("drop for eight times the load, relative", heavy / light, 2.0, 0.1);
}

#[test]
fn second_differences_are_nearer_the_elastica_for_their_cost() {
    // The same rigidity and as many cells: one form follows the curve, the other cannot.
    for gamma in [1.0, 10.0, 100.0] {
        let fabric = Fabric { rigidity: rigidity(gamma), ..Fabric::default() };
        let master = elastica(gamma);
        let second = droop(&fabric, 20, None);
        let flexion = droop(&Fabric { flexion: true, ..fabric }, 20, None);
        println!("gamma {gamma}: elastica {master:.4}, hinges {second:.4}, flexion {flexion:.4}");
        check_at_most("second differences' error", (second / master - 1.0).abs(), 0.03);
        assert!((flexion / master - 1.0).abs() > 0.1, "flexion springs have no rigidity at flat");
    }
}
