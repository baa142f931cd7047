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

/// A square, and beside its edge from 1 to 3 a row of triangles with the given particles on that edge.
fn with_a_side(on: &[Vec3]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let positions = [SQUARE.as_slice(), &[Vec3::new(2.0, 0.0, 0.5)], on].concat();
    let side: Vec<u32> = [1].into_iter().chain((5..).take(on.len())).chain([3]).collect();
    let fan = side.windows(2).map(|pair| [pair[0], 4, pair[1]]);
    (positions, HALVES.into_iter().chain(fan).collect())
}

#[test]
fn a_particle_on_an_edge_that_does_not_have_it_is_refused() {
    let junction = GraphError::TJunction { particle: 5, first: 1, second: 3 };
    let middle = Vec3::new(1.0, 0.0, 0.5);
    let (positions, triangles) = with_a_side(&[middle]);
    let refused = make(&positions, &triangles).unwrap_err();
    assert_eq!(refused, junction);
    let said = "particle 5 lies on the edge from 1 to 3, whose triangle does not have it (a T-junction): split that \
                triangle there";
    assert_eq!(refused.to_string(), said);
    // More than one, in whatever order, whoever has the lower number.
    let (positions, triangles) =
        with_a_side(&[middle, middle + Vec3::Z * 0.2, middle + Vec3::Z * 0.3]);
    assert_eq!(make(&positions, &triangles), Err(junction));
    let other: Vec<_> = triangles.iter().map(|t| t.map(|corner| 7 - corner)).collect();
    let reversed: Vec<_> = positions.iter().rev().copied().collect();
    let found = make(&reversed, &other).unwrap_err();
    assert!(matches!(found, GraphError::TJunction { first: 4 | 6, second: 4 | 6, .. }), "{found}");
}

#[test]
fn a_slit_and_a_hole_are_no_junction() {
    // The side is one edge, and both triangles have it.
    let (positions, triangles) = with_a_side(&[]);
    assert!(make(&positions, &triangles).is_ok());
    // A hole, however narrow it is.
    let (positions, triangles) = with_a_side(&[Vec3::new(1.001, 0.0, 0.5)]);
    assert!(make(&positions, &triangles).is_ok());
    // A slit that is closed at rest, with particles on both sides at other places.
    let (mut positions, mut triangles) = with_a_side(&[Vec3::new(1.0, 0.0, 0.5)]);
    positions.push(Vec3::new(1.0, 0.0, 0.3));
    triangles.splice(1..2, [[3, 2, 6], [6, 2, 1]]);
    assert!(make(&positions, &triangles).is_ok());
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
