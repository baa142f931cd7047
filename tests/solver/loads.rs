//! A cloth that hangs from a point of a collider, on a lattice and on a mesh that is no grid. Truths: the
//! strain that the cloth is held to, and the momentum that it and the collider share.

use bevy::math::{DVec3, Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{ClothSolver, Collider, MassLumping, Material, Pose, Settings, Topology};

use crate::support::solver::*;

const TIP: f32 = 0.03;
const THICKNESS: f32 = 0.02;

/// Sheets of a square metre and a half.
fn both() -> [Topology; 2] {
    let n = 48;
    let woven = sheet(Vec2::splat(1.5), n, n, MassLumping::Lumped);
    [woven.into(), mesh(n, n, 1.5 / (n - 1) as f32, 0.2).into()]
}

/// Above the tip, its middle there.
fn above_tip(topology: &Topology, height: f32) -> ClothSolver {
    let material = Material {
        shear_stiffness: 100.0,
        flexural_rigidity: 1e-5,
        max_strain: 0.1,
        friction: 0.4,
        thickness: THICKNESS,
        ..plain()
    };
    let offset = Vec3::Y * (TIP + THICKNESS + height) - middle(topology);
    at_rest(topology, offset, material, Settings::default())
}

#[test]
fn a_cloth_that_drops_onto_a_point_keeps_near_its_strain_limit() {
    let tip = Sphere::new(TIP);
    // The peak of one fall tells little: from 0.22 to 0.37 m it is between 1.1 and 1.7 for threads. A mesh
    // has none that are solved whole.
    for (topology, bound) in both().into_iter().zip([1.45, 2.1]) {
        let mut peaks = 0.0;
        for fall in 0..16 {
            let mut solver = above_tip(&topology, 0.22 + 0.01 * fall as f32);
            let colliders = [Collider::new(&tip, Pose::from_translation(Vec3::ZERO))];
            let mut peak = 0.0_f32;
            for _ in 0..90 {
                peak = peak.max(run(&mut solver, 1, GRAVITY, &colliders).max_strain);
            }
            peaks += f64::from(peak / solver.material().max_strain) / 16.0;
        }
        check_at_most("peak strain over its limit, mean of the falls", peaks, bound);
    }
}

#[test]
fn what_the_cloth_loses_the_point_that_it_hangs_from_is_given() {
    let tip = Sphere::new(TIP);
    for topology in both() {
        let mut solver = above_tip(&topology, 0.0);
        let collider = Collider::new(&tip, Pose::from_translation(Vec3::ZERO));
        let collider = Collider { measured: true, ..collider };
        let mass = mass(&solver);
        let (mut given, mut fallen) = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..120 {
            run(&mut solver, 1, GRAVITY, &[collider]);
            given += solver.impulse(0).linear.as_dvec3();
            fallen += GRAVITY.as_dvec3() * mass * f64::from(TICK);
        }
        // The velocity is half a substep behind: half of its weight is still to come.
        let left = momenta(&solver).0 + given;
        check_at_most("momentum that is lost", left.distance(fallen), 5e-4 * fallen.length());
        assert!(given.y < 0.9 * fallen.y, "it hangs from the point: {given}");
    }
}
