//! A rest shape spread out flat: where each particle is in the cloth.

use bevy_math::{DVec2, DVec3};

use crate::solver::Topology;

/// How far from a plane the particles of a flat cloth may be, relative to its size.
const FLAT: f64 = 1e-4;
/// Particles whose ways along the cloth to all others are measured, at most.
const LANDMARKS: usize = 32;

/// Flat coordinates of all particles \[m\], and the piece of cloth that each belongs to, from 0.
pub(super) struct Flattened {
    pub at: Vec<DVec2>,
    pub piece: Vec<usize>,
}

/// Spreads a rest shape out. A flat one is laid into its own plane, with no distance changed. Of any other
/// piece the ways along the cloth become distances in the plane as nearly as may be (landmark
/// multidimensional scaling: de Silva and Tenenbaum 2004).
pub(super) fn flatten(topology: &Topology) -> Flattened {
    let rest: Vec<DVec3> = topology.rest_positions().iter().map(|p| p.as_dvec3()).collect();
    let (piece, count) = pieces(topology);
    let mut at = vec![DVec2::ZERO; rest.len()];
    for number in 0..count {
        let members: Vec<usize> = (0..rest.len()).filter(|&i| piece[i] == number).collect();
        let places = in_plane(&rest, &members).unwrap_or_else(|| by_ways(topology, &members));
        for (&particle, place) in members.iter().zip(places) {
            at[particle] = place;
        }
    }
    Flattened { at, piece }
}

/// The piece of every particle, and how many there are: what springs join is one piece.
fn pieces(topology: &Topology) -> (Vec<usize>, usize) {
    fn root(parent: &mut [usize], mut of: usize) -> usize {
        while parent[of] != of {
            parent[of] = parent[parent[of]];
            of = parent[of];
        }
        of
    }
    let mut parent: Vec<usize> = (0..topology.particle_count()).collect();
    for (a, b, _) in topology.structural_springs() {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        // The lowest particle stands for its piece.
        parent[a.max(b)] = a.min(b);
    }
    let mut number = vec![0; parent.len()];
    let mut count = 0;
    for particle in 0..parent.len() {
        let of = root(&mut parent, particle);
        if of == particle {
            number[particle] = count;
            count += 1;
        } else {
            number[particle] = number[of];
        }
    }
    (number, count)
}

/// Coordinates in the plane of the particles; `None` where they are in none.
fn in_plane(rest: &[DVec3], members: &[usize]) -> Option<Vec<DVec2>> {
    let from = rest[members[0]];
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        let ways = members.iter().map(|&i| (measure(rest[i] - from), rest[i] - from));
        ways.fold((0.0, DVec3::ZERO), |best, way| if way.0 > best.0 { way } else { best })
    };
    let (size, along) = farthest(&|way| way.length());
    let along = along.normalize_or_zero();
    let off_axis = |way: DVec3| way - along * way.dot(along);
    let (_, across) = farthest(&|way| off_axis(way).length());
    let across = off_axis(across).normalize_or_zero();
    let normal = along.cross(across);
    let flat = members.iter().all(|&i| (rest[i] - from).dot(normal).abs() <= FLAT * size);
    let place = |&i: &usize| {
        let way = rest[i] - from;
        DVec2::new(way.dot(along), way.dot(across))
    };
    flat.then(|| members.iter().map(place).collect())
}

/// Coordinates from ways along the cloth.
fn by_ways(topology: &Topology, members: &[usize]) -> Vec<DVec2> {
    let landmarks = landmarks(topology, members);
    let count = landmarks.len();
    let square = |i: usize, particle: usize| {
        let way = f64::from(landmarks[i].1[particle]);
        way * way
    };
    // A way back need not be rounded as the way there.
    let between =
        |i: usize, j: usize| 0.5 * (square(i, landmarks[j].0) + square(j, landmarks[i].0));
    let mean_of = |i: usize| (0..count).map(|j| between(i, j)).sum::<f64>() / count as f64;
    let means: Vec<f64> = (0..count).map(mean_of).collect();
    let mean = means.iter().sum::<f64>() / count as f64;
    // Products of the landmarks' places about their middle, as their distances tell them.
    let product = |i: usize, j: usize| -0.5 * (between(i, j) - means[i] - means[j] + mean);
    let mut products: Vec<Vec<f64>> =
        (0..count).map(|i| (0..count).map(|j| product(i, j)).collect()).collect();
    let axes = [largest_axis(&mut products), largest_axis(&mut products)];
    let place = |&particle: &usize| {
        let coordinate = |(value, axis): &(f64, Vec<f64>)| {
            if *value <= 0.0 {
                return 0.0;
            }
            let sum = |(i, part): (usize, &f64)| part * (means[i] - square(i, particle));
            0.5 * axis.iter().enumerate().map(sum).sum::<f64>() / value.sqrt()
        };
        DVec2::new(coordinate(&axes[0]), coordinate(&axes[1]))
    };
    members.iter().map(place).collect()
}

/// Particles far from each other, and the ways from each to all.
fn landmarks(topology: &Topology, members: &[usize]) -> Vec<(usize, Vec<f32>)> {
    let mut nearest = topology.ways_from(members[0]);
    let mut chosen: Vec<(usize, Vec<f32>)> = Vec::new();
    while chosen.len() < LANDMARKS.min(members.len()) {
        let further = |best: usize, i: usize| if nearest[i] > nearest[best] { i } else { best };
        let next = members.iter().copied().fold(members[0], further);
        let ways = topology.ways_from(next);
        for &i in members {
            // The first particle is where the search begins, and no landmark itself.
            nearest[i] = if chosen.is_empty() { ways[i] } else { nearest[i].min(ways[i]) };
        }
        chosen.push((next, ways));
    }
    chosen
}

/// The largest eigenvalue of a symmetric matrix and its unit vector, by repeated multiplication; they are
/// taken out of the matrix.
fn largest_axis(matrix: &mut [Vec<f64>]) -> (f64, Vec<f64>) {
    let count = matrix.len();
    // Begins with the column of the largest diagonal entry, which has a part along the axis.
    let largest =
        (0..count).fold(0, |best, i| if matrix[i][i] > matrix[best][best] { i } else { best });
    let mut axis = matrix[largest].clone();
    let mut value = 0.0;
    for _ in 0..200 {
        let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length == 0.0 {
            return (0.0, axis);
        }
        axis.iter_mut().for_each(|x| *x /= length);
        let times = |row: &Vec<f64>| row.iter().zip(&axis).map(|(a, b)| a * b).sum::<f64>();
        let next: Vec<f64> = matrix.iter().map(times).collect();
        value = axis.iter().zip(&next).map(|(a, b)| a * b).sum();
        axis = next;
    }
    let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length == 0.0 {
        return (0.0, axis);
    }
    axis.iter_mut().for_each(|x| *x /= length);
    for (row, a) in matrix.iter_mut().zip(&axis) {
        for (entry, b) in row.iter_mut().zip(&axis) {
            *entry -= value * a * b;
        }
    }
    (value, axis)
}
