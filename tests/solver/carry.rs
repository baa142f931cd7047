//! What corrections carry on, where it could be felt: a hung cloth that is touched stays where it hangs, and how
//! far it stretches at its pins is what the guide says (`accuracy`).

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::{
    ClothMaterial,
    solver::{ClothSolver, Collider, MassLumping, Material, Pose, StretchMethod},
};

use crate::support::solver::*;

const N: usize = 48;

/// A square metre of the default material that hangs from two corners, at rest.
fn hung(substeps: u32) -> ClothSolver {
    let lattice = curtain(Vec2::ONE, N, N, MassLumping::Lumped);
    let material = Material { drag: 2.0, ..ClothMaterial::default().into() };
    let settings = settings(StretchMethod::ImplicitThreads, substeps);
    let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
    solver.set_pins(&[0, N as u32 - 1]).unwrap();
    // Out of its plane first: a flat curtain stands on an edge between two rests.
    run(&mut solver, 60, GRAVITY + Vec3::Z, &[]);
    run(&mut solver, 3000, GRAVITY, &[]);
    solver
}

#[test]
fn a_touch_moves_nothing_but_what_is_touched() {
    // Were nothing carried on by a cloth that touches something, all of it would look for another rest.
    let mut solver = hung(19);
    let before = positions(&solver);
    let ball = Sphere::new(0.05);
    let reach = 0.05 + solver.material().thickness - 1e-4;
    let at = before[N * N - N / 2] + Vec3::Z * reach;
    let colliders = [Collider::new(&ball, Pose::from_translation(at))];
    let (mut touched, mut off) = (0, 0.0_f32);
    for _ in 0..64 {
        touched += run(&mut solver, 1, GRAVITY, &colliders).contact_count;
        let now = positions(&solver);
        off = now.iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(off, f32::max);
    }
    assert!(touched > 0, "never touched");
    check_at_most("moved by a touch of 0.1 mm [m]", off.into(), 3e-4);
}

#[test]
fn what_hangs_from_points_stretches_there_by_the_substep() {
    let strain = |substeps| f64::from(hung(substeps).strain().max);
    check("strain at the pins, 20 substeps", strain(20), 0.035, 0.005);
    check("strain at the pins, 8 substeps", strain(8), 0.10, 0.005);
}
