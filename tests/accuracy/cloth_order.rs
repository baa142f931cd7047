//! A whole cloth in motion. Held to the `f64` reference at the same step, which shows the rounding of
//! `f32` alone, and to the order of convergence of each method, with and without damping.

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{ClothSolver, StretchMethod, Topology};

use super::reference::{Fabric, Method, Motion};
use super::scenes::*;
use crate::support::solver::*;

const GRAVITY_64: DVec3 = DVec3::new(1.0, -9.81, 0.5);
const HELD: [usize; 2] = [0, 8];

fn fabric() -> Fabric {
    Fabric { thread: 20.0, shear: 8.0, rigidity: 1e-3, ..Fabric::default() }
}

/// A bulge that moves.
fn start(sheet: &Sheet) -> Motion {
    let mut motion = Motion::at_rest(&sheet.rest());
    for (i, x) in motion.x.iter_mut().enumerate() {
        if HELD.contains(&i) {
            continue;
        }
        let (s, t) = ((3.0 * x.x).sin(), (2.0 * x.z).sin());
        *x = (*x + DVec3::new(0.01 * t, 0.05 * s * t, 0.01 * s * t)).as_vec3().as_dvec3();
        let v = DVec3::new(0.1 * s, 0.3 * t, -0.2 * s * t);
        motion.v[i] = v.as_vec3().as_dvec3();
    }
    motion
}

fn reference(fabric: &Fabric, method: Method, ticks: usize, substeps: usize) -> Vec<DVec3> {
    let sheet = Sheet::square(8, 1.0);
    let model = sheet.model(fabric, &HELD, GRAVITY_64);
    let mut motion = start(&sheet);
    model.steps(&mut motion, method, f64::from(TICK) / substeps as f64, ticks * substeps);
    motion.x
}

fn solved(
    topology: impl Into<Topology>,
    fabric: &Fabric,
    method: Method,
    ticks: usize,
    substeps: usize,
) -> Vec<DVec3> {
    let start = start(&Sheet::square(8, 1.0));
    let places: Vec<_> = start.x.iter().map(|p| p.as_vec3()).collect();
    let settings =
        settings_for(fabric, method, settings(StretchMethod::ExplicitSprings, substeps as u32));
    let mut solver = ClothSolver::new(topology, &places, material(fabric), settings).unwrap();
    for (i, v) in start.v.iter().enumerate() {
        solver.set_velocity(i, v.as_vec3()).unwrap();
    }
    solver.set_pins(&HELD.map(|i| i as u32)).unwrap();
    run(&mut solver, ticks, Vec3::new(1.0, -9.81, 0.5), &[]);
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    super::scenes::places(&solver)
}

/// The fabrics that differ in one thing each.
fn fabrics() -> Vec<(&'static str, Fabric)> {
    let plain = fabric();
    let damped = Fabric { damping: 0.01, ..plain };
    vec![
        ("threads alone", Fabric { shear: 0.0, rigidity: 0.0, ..plain }),
        ("threads, shear, second differences", plain),
        ("flexion springs", Fabric { flexion: true, rigidity: 4e-3, ..plain }),
        ("equal masses", Fabric { equal: true, ..plain }),
        ("axial damping", damped),
        ("relative damping", Fabric { axial: false, ..damped }),
        ("drag and damping", Fabric { drag: 8.0, damping: 0.02, ..plain }),
        ("drag and relative damping", Fabric { drag: 8.0, axial: false, ..damped }),
    ]
}

#[test]
fn the_solvers_motion_is_the_references_but_for_rounding() {
    let sheet = Sheet::square(8, 1.0);
    for (what, fabric) in fabrics() {
        for (method, substeps) in [
            (Method::Verlet, 4),
            (Method::Verlet, 16),
            (Method::Midpoint, 32),
            (Method::Euler, 128),
        ] {
            let same = reference(&fabric, method, 16, substeps);
            let lattice = solved(sheet.lattice(lumping(&fabric)), &fabric, method, 16, substeps);
            // Sums of rounded displacements: as the root of their number.
            let tolerance = 4e-7 * (substeps as f64).sqrt() + 1e-6;
            let what = format!("{what}, {method:?} x{substeps}, from the reference");
            check_at_most(&format!("{what} [m]"), apart(&lattice, &same), tolerance);
            // Second differences of a mesh are other ones.
            if fabric.rigidity == 0.0 {
                let graph = solved(sheet.graph(lumping(&fabric)), &fabric, method, 16, substeps);
                check_at_most(&format!("graph: {what} [m]"), apart(&graph, &same), tolerance);
            }
        }
    }
}

#[test]
fn a_cloth_converges_at_each_methods_order() {
    let sheet = Sheet::square(8, 1.0);
    for (what, fabric) in fabrics() {
        let exact = reference(&fabric, Method::Verlet, 12, 2048);
        for (method, coarse, order) in
            [(Method::Verlet, 32, 2.0), (Method::Midpoint, 64, 2.0), (Method::Euler, 512, 1.0)]
        {
            let errors =
                [1, 2, 4].map(|n| apart(&reference(&fabric, method, 12, coarse * n), &exact));
            let measured = (errors[0] / errors[2]).log2() / 2.0;
            let tolerance = if method == Method::Euler { 0.05 } else { 0.03 };
            check(&format!("{what}, {method:?}: reference's order"), measured, order, tolerance);
        }
        // As fine as f32 lets it be seen.
        for (method, coarse, order) in
            [(Method::Verlet, 8, 2.0), (Method::Midpoint, 16, 2.0), (Method::Euler, 256, 1.0)]
        {
            let error =
                |n| apart(&solved(sheet.lattice(lumping(&fabric)), &fabric, method, 12, n), &exact);
            let (first, second) = (error(coarse), error(2 * coarse));
            let what = format!("{what}, {method:?}: {first:.2e} to {second:.2e} m, solver's order");
            check(&what, (first / second).log2(), order, 0.1);
        }
    }
}
