//! Friction inside the fabric. Truths: it does no work on a free cloth but takes energy, and leaves its momentum and its
//! spin; a swing ends; without it nothing changes.

use crate::support::solver::*;
use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, MassLumping, Material, Pose, StretchMethod, Topology,
};

const N: usize = 24;

/// A wavy cloth that flies and spins, as a sheet and as a mesh.
fn flying(friction: f32) -> [ClothSolver; 2] {
    let cell = 1.0 / (N - 1) as f32;
    let lattice: Topology = sheet(Vec2::ONE, N, N, MassLumping::Lumped).into();
    let graph: Topology = mesh(N, N, cell, 0.25).into();
    [lattice, graph].map(|topology| {
        let rest = topology.rest_positions().to_vec();
        let wave = |p: Vec3| p + Vec3::Y * (0.05 * (7.0 * p.x).sin() * (5.0 * p.z).cos());
        let start: Vec<_> = rest.iter().map(|&p| wave(p)).collect();
        let material = Material { shear_stiffness: 100.0, bending_friction: friction, ..plain() };
        let settings = settings(StretchMethod::ImplicitThreads, 16);
        let mut solver = ClothSolver::new(topology, &start, material, settings).unwrap();
        for (i, p) in start.iter().enumerate() {
            let flutter = Vec3::Y * (9.0 * p.x).cos();
            let spin = Vec3::new(0.3, 1.0, 0.2).cross(*p);
            solver.set_velocity(i, Vec3::X + spin + flutter).unwrap();
        }
        solver
    })
}

fn kinetic(solver: &ClothSolver) -> f64 {
    let of = |i| 0.5 * f64::from(solver.mass(i)) * solver.velocity(i).as_dvec3().length_squared();
    (0..solver.topology().particle_count()).map(of).sum()
}

#[test]
fn a_free_cloth_keeps_its_momentum_and_its_spin() {
    for (what, mut solver) in ["sheet", "mesh"].into_iter().zip(flying(1e-2)) {
        let (before, spin_before) = momenta(&solver);
        let energy = kinetic(&solver);
        run(&mut solver, 32, Vec3::ZERO, &[]);
        let (after, spin_after) = momenta(&solver);
        let error = before.distance(after) / before.length();
        check_at_most(&format!("{what}: momentum, relative"), error, 1e-5);
        let error = spin_before.distance(spin_after) / spin_before.length();
        check_at_most(&format!("{what}: spin, relative"), error, 2e-3);
        assert!(kinetic(&solver) < 0.95 * energy, "{what}: nothing was braked");
    }
}

/// What hangs from a ball sways. Its drag of 0.2 /s alone leaves a third of its speed after ten seconds.
#[test]
fn a_dropped_cloth_is_still_after_ten_seconds() {
    let speed = |friction: f32| {
        let lattice = sheet(Vec2::ONE, N, N, MassLumping::Lumped);
        let material = Material {
            thread_stiffness: 2000.0,
            shear_stiffness: 100.0,
            flexural_rigidity: 1e-5,
            bending_friction: friction,
            drag: 0.2,
            max_strain: 0.1,
            friction: 0.5,
            ..plain()
        };
        let mut solver =
            at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ImplicitThreads, 16));
        let (ball, pose) = (Sphere::new(0.3), Pose::from_translation(Vec3::NEG_Y * 0.4));
        run(&mut solver, 640, GRAVITY, &[Collider::new(&ball, pose)]);
        (2.0 * kinetic(&solver) / 0.2).sqrt()
    };
    let (without, with) = (speed(0.0), speed(2.3e-4));
    println!("speed after ten seconds: {without:.2e} m/s without friction, {with:.2e} with it");
    assert!(without > 2e-3, "it does not sway without friction either: {without}");
    check_at_most("speed after ten seconds [m/s]", with, 0.25 * without);
}

#[test]
fn a_flat_cloth_in_flight_is_not_braked() {
    let fall = |friction: f32| {
        let lattice = sheet(Vec2::ONE, N, N, MassLumping::Lumped);
        let material = Material { bending_friction: friction, ..plain() };
        let mut solver =
            at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ImplicitThreads, 8));
        run(&mut solver, 16, GRAVITY, &[]);
        bits(&solver)
    };
    assert_eq!(fall(0.0), fall(1.0));
}
