//! Bending, held to the heavy elastica (`data/heavy_elastica_master.csv`, a shooting method) and to
//! the
//! exact equilibrium of the discrete strip (`data/discrete_cantilever_convergence.csv`).

use std::sync::Arc;

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    Bending, ClothSolver, Lattice, MassLumping, Material, Settings, StretchMethod,
};

use crate::support::solver::*;

/// A strip along z, clamped by its first two rows, settled under gravity: drop over reach of its
/// tip.
/// `gamma = rho g L^3 / B`.
fn droop(gamma: f32, cells: usize) -> f64 {
    let (length, columns) = (1.0_f32, 3);
    let cell = length / cells as f32;
    let positions: Vec<_> = (0..cells + 2)
        .flat_map(|r| {
            (0..columns).map(move |c| Vec3::new(c as f32 * cell, 0.0, (r as f32 - 1.0) * cell))
        })
        .collect();
    let lattice =
        Arc::new(Lattice::new(cells + 2, columns, &positions, MassLumping::Lumped).unwrap());
    // Threads of 1e6 N/m stretch by rho g L / k = 2e-6: far below what is asked of the droop.
    let material = Material {
        thread_stiffness: 1e6,
        flexural_rigidity: 0.2 * 9.81 / gamma,
        // Critical for the first mode, 3.5 sqrt(B / rho) / L^2.
        drag: 7.0 * (9.81 / gamma).sqrt(),
        ..plain()
    };
    // As many substeps as the bending wants: omega^2 = 32 B / (rho a^4).
    let omega = (32.0 * material.flexural_rigidity / 0.2).sqrt() / (cell * cell);
    let substeps = (TICK * omega / 1.8).ceil().max(16.0) as u32;
    let settings =
        Settings { tethers: false, ..settings(StretchMethod::ImplicitThreads, substeps) };
    let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
    solver.set_pins(&[0, 1, 2, 3, 4, 5]).unwrap();
    run(&mut solver, if gamma > 5.0 { 320 } else { 128 }, GRAVITY, &[]);
    assert!(!solver.plan().clamped.bending, "{}", solver.plan());
    check_at_most(
        &format!("gamma {gamma}, {cells} cells, speed left [m/s]"),
        fastest(&solver),
        1e-2,
    );
    let tip = solver.position((cells + 1) * columns + 1);
    f64::from(-tip.y) / f64::from(tip.z)
}

#[test]
fn a_cantilever_droops_as_the_elastica() {
    let discrete = table(include_str!("../data/discrete_cantilever_convergence.csv"));
    let continuum = table(include_str!("../data/heavy_elastica_master.csv"));
    for gamma in [1.0_f32, 10.0] {
        let mut errors = Vec::new();
        let master = continuum.iter().find(|r| r[0].parse::<f32>().unwrap() == gamma).unwrap();
        let master: f64 = master[1].parse().unwrap();
        for cells in [10, 20, 40] {
            let row = discrete
                .iter()
                .find(|r| {
                    r[0] == "second_difference"
                        && r[1] == "half"
                        && r[2].parse::<f32>().unwrap() == gamma
                        && r[3].parse::<usize>().unwrap() == cells
                })
                .unwrap();
            let exact: f64 = row[4].parse().unwrap();
            let measured = droop(gamma, cells);
            check(&format!("gamma {gamma}, {cells} cells, H/W"), measured, exact, 1e-3 * exact);
            errors.push(measured / master - 1.0);
        }
        // Two halvings are enough: the error at 40 cells is that of the rounding.
        check(&format!("gamma {gamma}, error at 10 cells"), errors[0], 0.014, 0.006);
        check(&format!("gamma {gamma}, order"), (errors[0] / errors[1]).log2(), 2.0, 0.35);
        check_at_most(&format!("gamma {gamma}, error at 40 cells"), errors[2].abs(), 3e-3);
    }
}

#[test]
fn a_flat_sheet_has_no_bending_force() {
    for bending in [Bending::SecondDifference, Bending::Flexion] {
        let lattice = sheet(Vec2::new(1.0, 0.625), 11, 17, MassLumping::Lumped);
        let material = Material { thread_stiffness: 0.0, flexural_rigidity: 0.01, ..plain() };
        let settings = Settings { bending, ..settings(StretchMethod::ExplicitSprings, 8) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
        let before = bits(&solver);
        run(&mut solver, 16, Vec3::ZERO, &[]);
        // Rest lengths of 1/16 m are exact.
        assert_eq!(before, bits(&solver), "{bending:?}");
    }
}

fn quarter_cylinder() -> Arc<Lattice> {
    let (rows, columns) = (13, 9);
    let positions: Vec<_> = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| (r, c)))
        .map(|(r, c)| {
            let angle = std::f32::consts::FRAC_PI_2 * r as f32 / (rows - 1) as f32;
            Vec3::new(c as f32 * 0.05, 0.4 * angle.sin(), 0.4 * angle.cos())
        })
        .collect();
    Arc::new(Lattice::new(rows, columns, &positions, MassLumping::Lumped).unwrap())
}

#[test]
fn a_sheet_curved_at_rest_stays_curved() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let material = Material {
            thread_stiffness: 20.0,
            shear_stiffness: 5.0,
            flexural_rigidity: 1e-3,
            damping: 0.001,
            ..plain()
        };
        let mut solver = at_rest(&quarter_cylinder(), Vec3::ZERO, material, settings(form, 16));
        let before = positions(&solver);
        run(&mut solver, 64, Vec3::ZERO, &[]);
        check_at_most(
            &format!("{form:?}, moved [m]"),
            farthest(&before, &positions(&solver)),
            2e-5,
        );
        // Flattened, it curls back: what keeps it still above is not a lack of force.
        let flat: Vec<_> = (0..13 * 9)
            .map(|i| {
                // A rest curvature has no side: a slight bow says which.
                let along = (i / 9) as f32;
                Vec3::new((i % 9) as f32 * 0.05, 0.002 * along * (12.0 - along), along * 0.052)
            })
            .collect();
        let lattice = quarter_cylinder();
        let material = Material { drag: 4.0, flexural_rigidity: 2e-2, ..material };
        let mut solver =
            ClothSolver::new(lattice.clone(), &flat, material, settings(form, 16)).unwrap();
        run(&mut solver, 640, Vec3::ZERO, &[]);
        // The rest curvature is a magnitude: which way and in which plane each hinge turns is open.
        let turns: f64 = (1..12)
            .map(|r| {
                let at = |r: usize| solver.position(r * 9 + 4);
                let (before, after) = (at(r) - at(r - 1), at(r + 1) - at(r));
                f64::from(before.angle_between(after).to_degrees())
            })
            .sum();
        check(&format!("{form:?}, mean turn curled back [degrees]"), turns / 11.0, 7.5, 0.5);
    }
}

#[test]
fn a_clamped_rigidity_bends_as_the_plan_says() {
    // A plan that cannot carry the rigidity lowers it, and says to what: the same droop as that
    // one.
    let lattice = curtain(Vec2::new(0.1, 1.0), 12, 3, MassLumping::Lumped);
    let stiff = Material { thread_stiffness: 1e5, flexural_rigidity: 50.0, drag: 12.0, ..plain() };
    let settled = |material: Material| {
        let mut solver =
            at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ImplicitThreads, 8));
        solver.set_pins(&[0, 1, 2, 3, 4, 5]).unwrap();
        run(&mut solver, 128, Vec3::Z * 9.81, &[]);
        (*solver.plan(), positions(&solver))
    };
    let (plan, asked) = settled(stiff);
    assert!(plan.clamped.bending && plan.flexural_rigidity < 50.0, "{plan}");
    let (plan, same) = settled(Material { flexural_rigidity: plan.flexural_rigidity, ..stiff });
    assert!(!plan.clamped.bending, "{plan}");
    check_at_most("apart [m]", farthest(&asked, &same), 1e-5);
}

#[test]
fn flexion_springs_resist_bending_but_not_a_slight_one() {
    // Energy of the fourth power: at a tenth of the curvature a hundredth of the moment, so that
    // the
    // light strip droops relatively more than the elastica would.
    let droop = |gravity: f32| {
        let lattice = sheet(Vec2::new(0.1, 0.6), 13, 3, MassLumping::Lumped);
        let material =
            Material { thread_stiffness: 6000.0, flexural_rigidity: 8.0, drag: 4.0, ..plain() };
        let settings =
            Settings { bending: Bending::Flexion, ..settings(StretchMethod::ExplicitSprings, 320) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
        solver.set_pins(&[0, 1, 2, 3, 4, 5]).unwrap();
        run(&mut solver, 384, Vec3::NEG_Y * gravity, &[]);
        assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
        f64::from(-solver.position(37).y)
    };
    let (light, heavy) = (droop(0.3), droop(2.4));
    // Small drops go as the cube root of the load: 8 times the load, twice the drop, and a little
    // less
    // as the strip turns down. A linear stiffness would give nearly 8.
    check("drop for 8 times the load, relative", heavy / light, 1.75, 0.25);
}
