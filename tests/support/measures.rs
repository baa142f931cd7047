//! Where the particles of a solver are, how fast and how stretched, in `f64` where sums are taken.

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{ClothSolver, Topology};

pub fn positions(solver: &ClothSolver) -> Vec<Vec3> {
    (0..solver.topology().particle_count()).map(|i| solver.position(i)).collect()
}

pub fn velocities(solver: &ClothSolver) -> Vec<Vec3> {
    (0..solver.topology().particle_count()).map(|i| solver.velocity(i)).collect()
}

/// The mean of the rest positions.
pub fn middle(topology: &Topology) -> Vec3 {
    let rest = topology.rest_positions();
    rest.iter().sum::<Vec3>() / rest.len() as f32
}

/// The mass of all particles \[kg\].
pub fn mass(solver: &ClothSolver) -> f64 {
    (0..solver.topology().particle_count()).map(|i| f64::from(solver.mass(i))).sum()
}

/// The centre of mass.
pub fn centre(solver: &ClothSolver) -> DVec3 {
    let count = solver.topology().particle_count();
    let weighted = |i: usize| solver.position(i).as_dvec3() * f64::from(solver.mass(i));
    (0..count).map(weighted).sum::<DVec3>() / mass(solver)
}

/// Of the centre of mass.
pub fn mean_velocity(solver: &ClothSolver) -> DVec3 {
    momenta(solver).0 / mass(solver)
}

pub fn farthest(a: &[Vec3], b: &[Vec3]) -> f64 {
    let apart = |(a, b): (&Vec3, &Vec3)| a.as_dvec3().distance(b.as_dvec3());
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}

pub fn fastest(solver: &ClothSolver) -> f64 {
    velocities(solver).iter().map(|v| v.as_dvec3().length()).fold(0.0, f64::max)
}

/// Linear and angular momentum about the world's origin. The velocity is that of the last substep's
/// middle, but along it the lever does not change.
pub fn momenta(solver: &ClothSolver) -> (DVec3, DVec3) {
    let count = solver.topology().particle_count();
    (0..count).fold((DVec3::ZERO, DVec3::ZERO), |(linear, angular), i| {
        let p = solver.velocity(i).as_dvec3() * f64::from(solver.mass(i));
        (linear + p, angular + solver.position(i).as_dvec3().cross(p))
    })
}

/// Strains of the structural springs, from positions relative to the origin: far away the world's round.
pub fn thread_strains(solver: &ClothSolver) -> Vec<f64> {
    let places: Vec<_> =
        (0..solver.topology().particle_count()).map(|i| solver.local_position(i)).collect();
    thread_strains_at(solver.topology(), &places)
}

/// Strains of the structural springs of particles in these places.
pub fn thread_strains_at(topology: &Topology, places: &[Vec3]) -> Vec<f64> {
    let strain = |(a, b, rest): (usize, usize, f32)| {
        places[a].as_dvec3().distance(places[b].as_dvec3()) / f64::from(rest) - 1.0
    };
    topology.structural_springs().map(strain).collect()
}

/// Strains of structural and shear springs of a lattice, from rest shape and positions alone.
pub fn strains(solver: &ClothSolver) -> Vec<f64> {
    let lattice = solver.lattice().unwrap();
    let (rows, columns) = (lattice.rows(), lattice.columns());
    let rest = lattice.rest_positions();
    let mut out = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            for (dr, dc) in [(0, 1), (1, 0), (1, 1), (1, -1)] {
                let (r2, c2) = (r + dr, c as isize + dc);
                if r2 < rows && c2 >= 0 && (c2 as usize) < columns {
                    let (i, j) = (r * columns + c, r2 * columns + c2 as usize);
                    let length =
                        solver.position(i).as_dvec3().distance(solver.position(j).as_dvec3());
                    out.push(length / rest[i].as_dvec3().distance(rest[j].as_dvec3()) - 1.0);
                }
            }
        }
    }
    out
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Corners of the box around some places.
pub fn extent(places: &[Vec3]) -> (Vec3, Vec3) {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    places.iter().fold(none, |(low, high), &p| (low.min(p), high.max(p)))
}
