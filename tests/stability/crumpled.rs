//! Irregular meshes that fall in a heap, turned at random, and collide with themselves. Truth: after fifteen seconds they are as good as
//! still.

use bevy::math::{
    Quat, Vec3,
    primitives::{Cone, Cuboid, Cylinder, InfinitePlane3d},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, Material, Pose, SelfCollision, Settings, Substeps},
};

use crate::lying::speed_of;
use crate::support::{checks::check_at_most, dice::Dice, materials::usual, runs::*, sheets::mesh};

const SIDE: usize = 40;

/// Lets a mesh fall in a heap. Returns its rms speed in the fifteenth second \[m/s\].
fn speed_of_heap(scene: usize) -> f64 {
    let mut dice = Dice(31 + 977 * scene as u64);
    let size = 0.6 + 0.1 * (scene % 3) as f32;
    let topology = mesh(SIDE, SIDE, size / (SIDE - 1) as f32, 0.3);
    let turn = Quat::from_scaled_axis(dice.vector() * 3.0);
    let middle = Vec3::new(0.5, 0.0, 0.5) * size;
    let start = topology.rest_positions().iter().map(|&p| turn * (p - middle) + Vec3::Y);
    let start: Vec<_> = start.collect();
    let material = Material { area_density: [0.1, 0.2, 0.4][scene % 3], ..usual() };
    let substeps = Substeps::Automatic { budget: [8, 20][scene % 2] };
    let settings = Settings { substeps, ..Settings::default() };
    let mut solver = ClothSolver::new(topology, &start, material, settings).unwrap();
    solver.set_self_collision(Some(SelfCollision::default())).unwrap();

    let floor = InfinitePlane3d::new(Vec3::Y);
    let solids: [Box<dyn SignedDistance>; 3] = [
        Box::new(Cylinder::new(0.12, 0.2)),
        Box::new(Cone::new(0.15, 0.3)),
        Box::new(Cuboid::new(0.3, 0.12, 0.2)),
    ];
    let place = Pose::from_translation(Vec3::new(0.1, 0.1, 0.0));
    let colliders =
        [Collider::new(&floor, Pose::IDENTITY), Collider::new(&*solids[scene / 2 % 3], place)];
    run(&mut solver, 14 * 64, GRAVITY, &colliders);
    speed_of(&mut solver, &colliders)
}

/// Where springs that are pushed together are asked to be longer and longer, some push themselves about for ever.
#[test]
fn meshes_in_heaps_come_to_rest() {
    for scene in 0..12 {
        check_at_most(&format!("rms speed of heap {scene} [m/s]"), speed_of_heap(scene), 3e-3);
    }
}
