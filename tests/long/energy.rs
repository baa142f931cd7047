//! Sheets of 32 x 32 without any damping, dropped on solids with edges and tips. Truth: over a minute, no second gives
//! them energy.

use crate::support::{kinds::*, solver::*};
use bevy::math::{
    Vec2, Vec3,
    primitives::{Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, MassLumping, Material, Pose, Settings, Substeps},
};

/// Energy of motion, height and threads \[J\].
fn energy(solver: &ClothSolver, stiffness: f32) -> f64 {
    let particle = |i: usize| {
        let (mass, at, velocity) = (solver.mass(i), solver.position(i), solver.velocity(i));
        f64::from(mass) * f64::from(0.5 * velocity.length_squared() - GRAVITY.dot(at))
    };
    let thread = |(a, b, rest): (usize, usize, f32)| {
        // Cells are squares, and a thread stands for one's width.
        let stretch = f64::from(solver.position(a).distance(solver.position(b)) - rest);
        0.5 * f64::from(stiffness) * stretch * stretch
    };
    let count = solver.topology().particle_count();
    (0..count).map(particle).sum::<f64>()
        + solver.topology().structural_springs().map(thread).sum::<f64>()
}

/// No second gives a cloth energy that lies on what is still, though nothing damps it but contact.
#[test]
fn energy_only_falls() {
    const N: usize = 32;
    let solids: [(&str, Box<dyn SignedDistance>, f32); 4] = [
        ("cube", Box::new(Cuboid::new(0.8, 0.8, 0.8)), 0.4),
        ("cylinder", Box::new(Cylinder::new(0.5, 0.8)), 0.4),
        ("cone", Box::new(Cone::new(0.5, 0.8)), 0.4),
        ("ball", Box::new(Sphere::new(0.05)), 0.05),
    ];
    let material = Material { drag: 0.0, damping: 0.0, bending_friction: 0.0, ..usual() };
    let floor = InfinitePlane3d::new(Vec3::Y);
    for (name, solid, middle) in solids {
        for budget in [20, 8] {
            let sheet = sheet(Vec2::splat(1.6), N, N, MassLumping::Lumped);
            let start: Vec<_> = sheet.rest_positions().iter().map(|&p| p + Vec3::Y * 1.2).collect();
            let substeps = Substeps::Automatic { budget };
            let settings = Settings { substeps, ..Settings::default() };
            let mut solver = ClothSolver::new(sheet, &start, material, settings).unwrap();
            let colliders = [
                Collider::new(&floor, Pose::IDENTITY),
                Collider::new(&*solid, Pose::from_translation(Vec3::Y * middle)),
            ];
            let mut before = energy(&solver, material.thread_stiffness);
            let mut gained = 0.0_f64;
            for _ in 0..60 {
                run(&mut solver, SECOND, GRAVITY, &colliders);
                let now = energy(&solver, material.thread_stiffness);
                gained = gained.max(now - before);
                before = now;
            }
            // It fell by some 3 J.
            check_at_most(
                &format!("{name}, budget {budget}: energy gained in a second [J]"),
                gained,
                3e-3,
            );
        }
    }
}
