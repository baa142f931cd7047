//! The surface, held to what a cloth is: no thread longer or shorter than at rest where that can be had,
//! every particle somewhere, the same for every way of naming and turning the scene.

use std::sync::Arc;

use bevy::math::{DVec3, Quat, Vec2, Vec3};
use bevy_drape::{
    hang::{Catenary, HangingPoint, hang},
    solver::{Graph, MassLumping, Topology},
};

use crate::support::solver::*;

const DOWN: Vec3 = Vec3::NEG_Y;

pub fn point(particle: usize, place: Vec3) -> HangingPoint {
    HangingPoint { particle: particle as u32, place }
}

fn hung(topology: &Topology, points: &[HangingPoint]) -> Vec<Vec3> {
    let places = hang(topology, topology.rest_positions(), points, 0.0, DOWN).unwrap();
    assert_eq!(places.len(), topology.particle_count());
    assert!(places.iter().all(|place| place.is_finite()));
    for point in points {
        assert_eq!(places[point.particle as usize], point.place);
    }
    places
}

/// Prints and bounds the size of strains: the mean, and of 99 % of the springs.
fn check_strains(what: &str, topology: &Topology, places: &[Vec3], mean: f64, p99: f64) {
    let mut sizes: Vec<f64> = thread_strains_at(topology, places).iter().map(|s| s.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let measured = sizes.iter().sum::<f64>() / sizes.len() as f64;
    check_at_most(&format!("{what}: mean strain"), measured, mean);
    check_at_most(&format!("{what}: p99 strain"), sizes[sizes.len() * 99 / 100], p99);
}

#[test]
fn hung_from_two_corners_no_thread_changes_its_length() {
    for (name, topology) in lattice_and_mesh(1.0, 33) {
        for (span, height) in [(0.6, 0.0), (0.9, 0.3), (0.05, 0.0), (0.01, -0.7), (1.0, 0.0)] {
            let points = [point(0, Vec3::ZERO), point(32, Vec3::new(span, height, 0.0))];
            let places = hung(&topology, &points);
            // The graph's inner edges are not along threads: the shear of the surface stretches them.
            if name == "lattice" {
                // Chords of cells on a curve are shorter than their arcs.
                check_strains(&format!("span {span}"), &topology, &places, 0.007, 0.4);
            }
            let curve = Catenary::new(
                DVec3::ZERO,
                DVec3::new(f64::from(span), f64::from(height), 0.0),
                1.0,
                DVec3::NEG_Y,
            )
            .unwrap();
            // The first row hangs in a catenary, the others straight down from it.
            for (i, place) in places.iter().enumerate() {
                let rest = topology.rest_positions()[i] - topology.rest_positions()[0];
                let from = curve.at(f64::from(rest.x));
                let off = (from - DVec3::Y * f64::from(rest.z)).distance(place.as_dvec3());
                assert!(off < 1e-5, "{name} {span}: particle {i} is off by {off}");
            }
        }
    }
}

#[test]
fn hung_where_it_lies_it_stays() {
    // Corners as far apart as at rest: all curves are taut, and the sheet is flat.
    for (name, topology) in lattice_and_mesh(1.0, 33) {
        let rest = topology.rest_positions();
        let points: Vec<_> = [0, 32, 1056, 1088].iter().map(|&i| point(i, rest[i])).collect();
        let places = hung(&topology, &points);
        check_at_most(&format!("{name}: off [m]"), farthest(&places, rest), 1e-6);
    }
}

#[test]
fn hung_from_more_points_its_threads_are_near_their_length() {
    let flat = |i: usize, topology: &Topology| topology.rest_positions()[i];
    for (name, topology) in lattice_and_mesh(1.0, 33) {
        // Four corners drawn together, as a hammock; three; and one of them higher.
        let drawn = |i: usize, by: f32| point(i, flat(i, &topology) * Vec3::new(by, 1.0, by));
        let four = [0, 32, 1056, 1088].map(|i| drawn(i, 0.8));
        check_strains(
            &format!("{name}, four corners"),
            &topology,
            &hung(&topology, &four),
            0.21,
            1.0,
        );
        let three = [0, 32, 1056].map(|i| drawn(i, 0.8));
        check_strains(&format!("{name}, three"), &topology, &hung(&topology, &three), 0.23, 0.85);
        let middle = [drawn(0, 0.8), drawn(32, 0.8), point(16 * 33 + 16, flat(544, &topology))];
        check_strains(&format!("{name}, middle"), &topology, &hung(&topology, &middle), 0.24, 0.8);
        // Two opposite corners: both sides hang from the diagonal.
        let diagonal = [drawn(0, 0.9), drawn(1088, 0.9)];
        check_strains(
            &format!("{name}, diagonal"),
            &topology,
            &hung(&topology, &diagonal),
            0.18,
            0.45,
        );
        // Two points inside: cloth on all sides.
        let inside = [drawn(16 * 33 + 8, 0.9), drawn(16 * 33 + 24, 0.9)];
        check_strains(&format!("{name}, inside"), &topology, &hung(&topology, &inside), 0.13, 0.85);
    }
}

#[test]
fn of_two_curves_that_cross_the_higher_is_kept() {
    // Two opposite corners are raised: the diagonal between them is the ridge.
    let lattice = sheet(Vec2::ONE, 33, 33, MassLumping::Lumped);
    let topology = Topology::from(lattice);
    let rest = topology.rest_positions();
    for high in [[0, 1088], [32, 1056]] {
        let points: Vec<_> = [0, 32, 1056, 1088]
            .iter()
            .map(|&i| point(i, rest[i] * 0.9 + Vec3::Y * if high.contains(&i) { 0.2 } else { 0.0 }))
            .collect();
        let places = hung(&topology, &points);
        let [a, b] = high.map(|i| places[i].as_dvec3());
        let ridge = Catenary::new(a, b, 2.0_f64.sqrt(), DVec3::NEG_Y).unwrap();
        let middle = places[544].as_dvec3();
        check("height of the middle", middle.y, ridge.at(0.5 * 2.0_f64.sqrt()).y, 1e-6);
    }
}

#[test]
fn it_turns_with_the_scene_and_with_gravity() {
    let topology = Topology::from(sheet(Vec2::ONE, 17, 17, MassLumping::Lumped));
    let turn = Quat::from_axis_angle(Vec3::new(0.3, 1.0, -0.2).normalize(), 1.1);
    let rest = topology.rest_positions();
    let places: Vec<_> = [0, 16, 280].iter().map(|&i| (i, rest[i] * 0.85)).collect();
    let points: Vec<_> = places.iter().map(|&(i, p)| point(i, p)).collect();
    let turned: Vec<_> = places.iter().map(|&(i, p)| point(i, turn * p + Vec3::X)).collect();
    let upright = hang(&topology, rest, &points, 0.0, DOWN).unwrap();
    let other = hang(&topology, rest, &turned, 0.0, turn * DOWN * 9.81).unwrap();
    let expected: Vec<_> = upright.iter().map(|&p| turn * p + Vec3::X).collect();
    check_at_most("off [m]", farthest(&other, &expected), 2e-5);
}

#[test]
fn a_curved_cloth_is_spread_out_first() {
    // Three quarters of a tube: its ways along the cloth are those of a rectangle of 1 x 1.
    let (rows, columns) = (25, 25);
    let turn = 1.5 * std::f32::consts::PI;
    let radius = 1.0 / turn;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            let angle = c as f32 / 24.0 * turn;
            positions.push(Vec3::new(radius * angle.sin(), -radius * angle.cos(), r as f32 / 24.0));
            if r + 1 < rows && c + 1 < columns {
                let at = (r * columns + c) as u32;
                let (b, c, d) = (at + 1, at + columns as u32, at + columns as u32 + 1);
                triangles.extend([[at, c, d], [at, d, b]]);
            }
        }
    }
    let tube = Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap();
    let topology = Topology::from(Arc::new(tube));
    let points = [point(0, Vec3::ZERO), point(24, Vec3::X * 0.7)];
    // Ways over edges and diagonals are up to 8 % longer than straight ones.
    let places = hung(&topology, &points);
    check_strains("tube, two corners", &topology, &places, 0.1, 0.7);
    let lowest = places.iter().map(|p| p.y).fold(0.0, f32::min);
    check("depth [m]", f64::from(-lowest), 1.0 + 0.32, 0.15);
}

#[test]
fn pieces_that_nothing_joins_are_hung_on_their_own() {
    let (mut positions, mut triangles) = jittered(9, 9, 0.1, 0.0, 3);
    for piece in 1..3 {
        let first = positions.len() as u32;
        let (more, theirs) = jittered(9, 9, 0.1, 0.0, 3);
        positions.extend(more.iter().map(|p| p + Vec3::X * 2.0 * piece as f32));
        triangles.extend(theirs.iter().map(|t| t.map(|v| v + first)));
    }
    let graph = Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap();
    let topology = Topology::from(Arc::new(graph));
    // Two points of the first piece, one of the second, none of the third.
    let points = [point(0, Vec3::ZERO), point(8, Vec3::X * 0.6), point(81, Vec3::Y)];
    let places = hung(&topology, &points);
    assert_eq!(places[162..], topology.rest_positions()[162..], "what nothing holds stays");
    let rest = topology.rest_positions();
    for (place, at_rest) in places[81..162].iter().zip(&rest[81..162]) {
        let (off, way) = (place.distance(Vec3::Y), at_rest.distance(rest[81]));
        assert!((off - way).abs() < 1e-5 && place.y <= 1.0, "{off} of {way}");
    }
    check_strains("three pieces", &topology, &places, 0.07, 0.9);
}

#[test]
fn many_points_are_no_trouble() {
    // A whole row, drawn together and waved; and all of the border.
    let topology = Topology::from(sheet(Vec2::ONE, 65, 65, MassLumping::Lumped));
    let rest = topology.rest_positions();
    let row: Vec<_> = (0..65)
        .map(|i| point(i, Vec3::new(0.5 * rest[i].x, 0.0, 0.005 * (i as f32).sin())))
        .collect();
    check_strains("a row", &topology, &hung(&topology, &row), 0.28, 0.6);
    let border: Vec<_> = (0..65 * 65)
        .filter(|i| [0, 64].contains(&(i / 65)) || [0, 64].contains(&(i % 65)))
        .map(|i| point(i, rest[i]))
        .collect();
    let places = hung(&topology, &border);
    check_at_most("border: off [m]", farthest(&places, rest), 1e-5);
    let all: Vec<_> = rest.iter().enumerate().map(|(i, &p)| point(i, p)).collect();
    assert_eq!(hung(&topology, &all), rest);
}
