//! Bending of triangle meshes, held to the heavy elastica (`data/heavy_elastica_master.csv`), and rest
//! shapes to themselves.

use std::sync::Arc;

use bevy::math::Vec3;
use bevy_drape::solver::{Graph, MassLumping, Material, Settings, StretchMethod};

use crate::support::solver::*;

/// A strip of 1 m along z, clamped by its first rows, settled under gravity: drop over reach of its
/// tip. `gamma = rho g L^3 / B`.
fn droop(gamma: f32, positions: &[Vec3], triangles: &[[u32; 3]], cell: f32) -> f64 {
    let graph = Arc::new(Graph::new(positions, triangles, MassLumping::Lumped).unwrap());
    let material = Material {
        thread_stiffness: 2e4,
        shear_stiffness: 2e3,
        flexural_rigidity: 0.2 * 9.81 / gamma,
        // Critical for the first mode, 3.5 sqrt(B / rho) / L^2.
        drag: 7.0 * (9.81 / gamma).sqrt(),
        ..plain()
    };
    let omega = (32.0 * material.flexural_rigidity / 0.2).sqrt() / (cell * cell);
    let substeps = (4.0 * TICK * omega / 1.8).ceil().max(16.0) as u32;
    let settings =
        Settings { tethers: false, ..settings(StretchMethod::ImplicitThreads, substeps) };
    let mut solver = at_rest(&graph, Vec3::ZERO, material, settings);
    let pins: Vec<u32> =
        (0..positions.len() as u32).filter(|&i| positions[i as usize].z < 1e-4).collect();
    solver.set_pins(&pins).unwrap();
    run(&mut solver, if gamma > 5.0 { 320 } else { 128 }, GRAVITY, &[]);
    assert!(!solver.plan().clamped.bending, "{}", solver.plan());
    let (mut drop, mut reach) = (0.0, 0.0);
    for (i, rest) in positions.iter().enumerate().filter(|(_, rest)| rest.z > 0.999) {
        drop -= f64::from(solver.position(i).y);
        reach += f64::from(solver.position(i).z);
        assert!(rest.is_finite());
    }
    drop / reach
}

#[test]
fn a_cantilever_of_triangles_droops_as_the_elastica() {
    let continuum = table(include_str!("../data/heavy_elastica_master.csv"));
    for gamma in [1.0_f32, 10.0] {
        let master = continuum.iter().find(|r| r[0].parse::<f32>().unwrap() == gamma).unwrap();
        let master: f64 = master[1].parse().unwrap();
        for (name, jitter, tolerance) in [("grid", 0.0, 0.02), ("jittered", 0.25, 0.05)] {
            let (mut positions, triangles) = jittered(18, 7, 1.0 / 16.0, jitter, 4);
            for p in &mut positions {
                p.z -= 1.0 / 16.0;
            }
            let measured = droop(gamma, &positions, &triangles, 1.0 / 16.0);
            check(
                &format!("{name}, gamma {gamma}: H/W / elastica's"),
                measured / master,
                1.0,
                tolerance,
            );
        }
        let (positions, triangles) = hexagonal(19, 6, 1.0 / (17.0 * 0.75_f32.sqrt()));
        let row = 1.0 / 17.0;
        let positions: Vec<_> = positions.iter().map(|p| *p - Vec3::Z * row).collect();
        let measured = droop(gamma, &positions, &triangles, row);
        check(&format!("hexagonal, gamma {gamma}: H/W / elastica's"), measured / master, 1.0, 0.05);
    }
}
