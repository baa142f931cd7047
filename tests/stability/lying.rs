//! Sheets and meshes of 64 x 64 that have been dropped on solids with edges and tips, as a user has them. Truth: after twenty
//! seconds a cloth hardly moves, and no thread is longer than its strain limit allows.

use crate::support::{kinds::*, sheets::mesh, solver::*};
use bevy::math::{
    Vec2, Vec3,
    primitives::{Cone, Cuboid, Cylinder, InfinitePlane3d, Sphere},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, MassLumping, Pose, Settings, Substeps, Topology},
};

const N: usize = 64;

/// Drops a sheet on a solid that stands on the ground, and checks that it has come to rest: to an rms `speed` at most \[m/s\].
fn drop_on(
    solid: &dyn SignedDistance,
    middle: f32,
    side: f32,
    from: f32,
    budget: u32,
    speed: f64,
) -> ClothSolver {
    let sheet = sheet(Vec2::splat(side), N, N, MassLumping::Lumped);
    let solver = drop(sheet.into(), solid, middle, |p| p + Vec3::Y * from, budget, speed);
    let [p99, largest] = strains(&solver);
    check_at_most("strain of 99 in 100", p99, 0.01);
    check_at_most("largest strain", largest, 0.11);
    solver
}

/// Drops an irregular mesh as [`drop_on`] drops a sheet. What is at rest is stretched by 6 in 100 at most.
fn drop_mesh_on(
    solid: &dyn SignedDistance,
    middle: f32,
    side: f32,
    from: f32,
    budget: u32,
    speed: f64,
) -> ClothSolver {
    let mesh = mesh(N, N, side / (N - 1) as f32, 0.3);
    let to_middle = Vec3::new(-0.5 * side, from, -0.5 * side);
    let solver = drop(mesh.into(), solid, middle, |p| p + to_middle, budget, speed);
    check_at_most("strain of 99 in 100", strains(&solver)[0], 0.06);
    solver
}

fn drop(
    topology: Topology,
    solid: &dyn SignedDistance,
    middle: f32,
    place: impl Fn(Vec3) -> Vec3,
    budget: u32,
    speed: f64,
) -> ClothSolver {
    let start: Vec<_> = topology.rest_positions().iter().map(|&p| place(p)).collect();
    let settings = Settings { substeps: Substeps::Automatic { budget }, ..Settings::default() };
    let mut solver = ClothSolver::new(topology, &start, usual(), settings).unwrap();
    let floor = InfinitePlane3d::new(Vec3::Y);
    let colliders = [
        Collider::new(&floor, Pose::IDENTITY),
        Collider::new(solid, Pose::from_translation(Vec3::Y * middle)),
    ];
    run(&mut solver, 19 * SECOND, GRAVITY, &colliders);
    check_lies(&mut solver, &colliders, speed);
    solver
}

/// Looks at the twentieth second.
fn check_lies(solver: &mut ClothSolver, colliders: &[Collider<'_>], speed: f64) {
    let mut squares = 0.0;
    let mut before = positions(solver);
    for _ in 0..SECOND {
        run(solver, 1, GRAVITY, colliders);
        let now = positions(solver);
        let moved = before.iter().zip(&now).map(|(a, b)| f64::from(a.distance_squared(*b)));
        squares += moved.sum::<f64>();
        before = now;
    }
    let rms = (squares / (SECOND * N * N) as f64).sqrt() * SECOND as f64;
    check_at_most("rms speed [m/s]", rms, speed);
}

/// The strain that 99 in 100 springs stay below, and the largest.
fn strains(solver: &ClothSolver) -> [f64; 2] {
    let places = positions(solver);
    let mut strains: Vec<f64> = solver
        .topology()
        .structural_springs()
        .map(|(a, b, rest)| f64::from(places[a].distance(places[b]) / rest) - 1.0)
        .collect();
    strains.sort_by(f64::total_cmp);
    [strains[strains.len() * 99 / 100], strains[strains.len() - 1]]
}

#[test]
fn on_a_cube() {
    drop_on(&Cuboid::new(0.8, 0.8, 0.8), 0.4, 2.0, 1.2, 8, 1.5e-3);
}

/// Chains of few substeps leave much to do, and shake the cloth where nothing is carried on.
#[test]
fn a_mesh_on_a_cube() {
    drop_mesh_on(&Cuboid::new(0.8, 0.8, 0.8), 0.4, 2.0, 1.2, 8, 6e-4);
}

#[test]
fn a_mesh_on_a_cone() {
    let solver = drop_mesh_on(&Cone { radius: 0.5, height: 0.8 }, 0.4, 1.6, 1.3, 20, 3e-4);
    assert!(solver.bounds().1.y > 0.75, "it slid off: {}", solver.bounds().1);
}

#[test]
fn on_a_cylinder() {
    drop_on(&Cylinder::new(0.5, 0.8), 0.4, 1.6, 1.3, 8, 6e-4);
}

/// Its tip carries all of the cloth on a particle or two. With few substeps it is stretched the most, and there it swings
/// the longest: 0.00 to 1.3 mm/s are left, as the drop comes out.
#[test]
fn on_a_cone() {
    let solver = drop_on(&Cone { radius: 0.5, height: 0.8 }, 0.4, 1.6, 1.3, 8, 1.5e-3);
    assert!(solver.bounds().1.y > 0.75, "it slid off: {}", solver.bounds().1);
}

/// A small ball under a cloth that lies on the ground.
#[test]
fn on_a_small_ball() {
    for budget in [20, 8] {
        drop_on(&Sphere::new(0.05), 0.05, 1.6, 1.3, budget, 2e-4);
    }
}
