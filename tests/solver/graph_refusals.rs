//! What a graph refuses, and what the solver makes of one: typed errors, and particles that are
//! counted as they were given.

use std::sync::Arc;

use bevy::math::Vec3;
use bevy_drape::solver::{ClothSolver, Graph, GraphError, MassLumping, Settings, Weights};

use crate::support::solver::*;

/// A square of two triangles.
const SQUARE: [Vec3; 4] = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.0, 1.0)];
const HALVES: [[u32; 3]; 2] = [[0, 1, 2], [3, 2, 1]];

fn make(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Graph, GraphError> {
    Graph::new(positions, triangles, MassLumping::Lumped)
}

#[test]
fn a_mesh_that_is_no_cloth_is_refused() {
    assert!(make(&SQUARE, &HALVES).is_ok());
    assert_eq!(make(&SQUARE, &[]), Err(GraphError::TooFewTriangles { triangles: 0 }));
    assert_eq!(make(&[], &HALVES[..1]), Err(GraphError::TooFewTriangles { triangles: 1 }));
    assert_eq!(
        make(&SQUARE, &[[0, 1, 2], [3, 2, 4]]),
        Err(GraphError::NoSuchCorner { triangle: 1, corner: 4, particles: 4 })
    );
    for bad in [f32::NAN, f32::INFINITY, 2e6] {
        let mut positions = SQUARE;
        positions[3].y = bad;
        assert_eq!(make(&positions, &HALVES), Err(GraphError::NonFinite { particle: 3 }));
    }
    let mut positions = SQUARE;
    positions[1] = positions[2];
    assert_eq!(make(&positions, &HALVES), Err(GraphError::Coincident { first: 1, second: 2 }));
    positions[1] = Vec3::new(0.0, 0.0, 0.5);
    assert_eq!(make(&positions, &HALVES), Err(GraphError::ZeroArea { triangle: 0 }));
    assert_eq!(make(&SQUARE, &[[0, 1, 2], [3, 2, 2]]), Err(GraphError::ZeroArea { triangle: 1 }));
    assert_eq!(
        make(&SQUARE, &[[0, 1, 2], [3, 2, 1], [2, 0, 1]]),
        Err(GraphError::Duplicate { first: 0, second: 2 })
    );
    let five = [SQUARE.as_slice(), &[Vec3::Y]].concat();
    assert_eq!(make(&five, &HALVES), Err(GraphError::Isolated { particle: 4 }));
}

#[test]
fn weights_that_are_no_weights_are_refused() {
    let make = |mass: &[f32], stiffness: &[f32]| {
        let weights = Weights { mass, stiffness };
        Graph::with_weights(&SQUARE, &HALVES, MassLumping::Lumped, weights).map(|_| ())
    };
    assert_eq!(make(&[1.0; 4], &[2.0; 4]), Ok(()));
    assert!(matches!(make(&[1.0; 3], &[]), Err(GraphError::WrongWeightCount { got: 3, .. })));
    assert!(matches!(make(&[], &[1.0; 5]), Err(GraphError::WrongWeightCount { got: 5, .. })));
    for bad in [0.0, -1.0, 1e4, f32::NAN] {
        let weights = [1.0, 1.0, bad, 1.0];
        assert!(matches!(make(&weights, &[]), Err(GraphError::Weight { particle: 2, .. })));
        assert!(matches!(make(&[], &weights), Err(GraphError::Weight { particle: 2, .. })));
    }
}

#[test]
fn particles_keep_their_numbers_and_weigh_what_the_cloth_weighs() {
    let (positions, triangles) = jittered(9, 13, 0.1, 0.3, 7);
    let graph = Arc::new(make(&positions, &triangles).unwrap());
    assert_eq!(graph.rest_positions(), &positions[..]);
    assert_eq!(graph.triangles(), &triangles[..]);
    let mut solver =
        ClothSolver::new(graph.clone(), &positions, plain(), Settings::default()).unwrap();
    for (i, &p) in positions.iter().enumerate() {
        assert_eq!(solver.position(i), p);
    }
    let mass: f64 = (0..positions.len()).map(|i| f64::from(solver.mass(i))).sum();
    check("mass [kg]", mass, 0.2 * f64::from(graph.total_area()), 1e-6);
    check("area [m2]", f64::from(graph.total_area()), 0.8 * 1.2, 1e-5);
    // Springs join what they are said to join.
    for (a, b, rest) in graph.structural_springs() {
        assert!((positions[a].distance(positions[b]) - rest).abs() < 1e-6);
    }
    solver.set_pins(&[5, 100]).unwrap();
    assert_eq!(solver.pins(), &[5, 100]);
    run(&mut solver, 4, GRAVITY, &[]);
    assert_eq!(solver.position(5), positions[5]);
    assert_eq!(solver.position(100), positions[100]);
    assert!(solver.set_pins(&[117]).is_err());
}
