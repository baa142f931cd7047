//! Solids that are thinner than the particles are apart. Truth: the cloth hangs on them, or has slid off as a whole, and
//! what struck it does not stay hooked in it.

use crate::support::{dice::Dice, kinds::*, sheets::lattice_and_mesh, solver::*};
use bevy::math::{
    Quat, Vec2, Vec3,
    primitives::{Capsule3d, Cone, Cuboid, Cylinder, InfinitePlane3d},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, MassLumping, Pose, Settings, StepInput, Substeps, Topology},
};

const N: usize = 32;

/// Drops a sheet of 1.6 m on a solid above the ground, and tells how high it lies after five seconds.
fn highest_on(solid: &dyn SignedDistance, pose: Pose, speed: f32) -> f32 {
    dropped_on::<N>(solid, pose, speed).bounds().1.y
}

/// Drops a sheet of `N` x `N` particles on a solid above the ground; the cloth after five seconds.
fn dropped_on<const N: usize>(solid: &dyn SignedDistance, pose: Pose, speed: f32) -> ClothSolver {
    let sheet = sheet(Vec2::splat(1.6), N, N, MassLumping::Lumped);
    // Off the middle, so that no row lies on the solid by chance.
    let start: Vec<_> =
        sheet.rest_positions().iter().map(|&p| p + Vec3::new(0.01, 1.2, 0.007)).collect();
    let mut solver = ClothSolver::new(sheet, &start, usual(), Settings::default()).unwrap();
    for i in 0..N * N {
        solver.set_velocity(i, Vec3::NEG_Y * speed).unwrap();
    }
    let floor = InfinitePlane3d::new(Vec3::Y);
    let colliders = [Collider::new(&floor, Pose::IDENTITY), Collider::new(solid, pose)];
    run(&mut solver, 5 * SECOND, GRAVITY, &colliders);
    let strain = f64::from(solver.strain().max);
    check_at_most("largest strain", strain, 0.2);
    solver
}

/// How deep any place of any cell is inside, split along either diagonal \[m\].
fn deepest<const N: usize>(solver: &ClothSolver, solid: &dyn SignedDistance, pose: Pose) -> f64 {
    const LOOKS: usize = 10;
    let at = positions(solver);
    let mut least = f32::INFINITY;
    for first in (0..(N - 1) * N).filter(|i| i % N + 1 < N) {
        let [a, b, c, d] = [0, 1, N, N + 1].map(|hop| at[first + hop]);
        for [a, b, c] in [[a, c, d], [a, d, b], [a, c, b], [b, c, d]] {
            for i in 0..=LOOKS {
                for j in 0..=LOOKS - i {
                    let [u, v] = [i, j].map(|part| part as f32 / LOOKS as f32);
                    let place = a + (b - a) * u + (c - a) * v;
                    least = least.min(solid.distance(place - pose.translation));
                }
            }
        }
    }
    f64::from(-least)
}

/// A vertex of a solid meets a face of the cloth, between its edges.
#[test]
fn no_vertex_shows_through() {
    let pose = Pose::from_translation(Vec3::Y * 0.4);
    let (cube, cone) = (Cuboid::new(0.8, 0.8, 0.8), Cone::new(0.5, 0.8));
    let coarse = dropped_on::<16>(&cube, pose, 0.0);
    check_at_most("cube, 16 a side: depth [m]", deepest::<16>(&coarse, &cube, pose), 1e-3);
    let finer = dropped_on::<32>(&cube, pose, 0.0);
    check_at_most("cube, 32 a side: depth [m]", deepest::<32>(&finer, &cube, pose), 5e-4);
    let coarse = dropped_on::<16>(&cone, pose, 0.0);
    check_at_most("cone, 16 a side: depth [m]", deepest::<16>(&coarse, &cone, pose), 5e-3);
}

fn lying(height: f32) -> Pose {
    let rotation = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    Pose { rotation, ..Pose::from_translation(Vec3::Y * height) }
}

#[test]
fn a_rod_of_one_centimetre_carries_a_cloth_of_five_centimetres_spacing() {
    for speed in [0.0, 3.0] {
        let top = highest_on(&Cylinder::new(0.01, 2.4), lying(0.7), speed);
        assert!(top > 0.69, "fell through at {speed} m/s: {top}");
    }
}

#[test]
fn a_line_of_half_a_centimetre_carries_it_too() {
    let top = highest_on(&Cylinder::new(0.005, 2.4), lying(0.7), 3.0);
    assert!(top > 0.69, "fell through: {top}");
}

#[test]
fn a_post_of_two_centimetres_carries_it() {
    let top = highest_on(&Cylinder::new(0.02, 0.8), Pose::from_translation(Vec3::Y * 0.4), 3.0);
    assert!(top > 0.78, "fell through: {top}");
}

#[test]
fn a_plate_of_half_a_centimetre_on_edge_carries_it() {
    let plate = Cuboid::new(0.8, 0.8, 0.005);
    let top = highest_on(&plate, Pose::from_translation(Vec3::Y * 0.4), 0.0);
    assert!(top > 0.78, "fell through: {top}");
}

/// How long the longest spring of a curtain is, 4 s after a box began to move into it.
fn strain_after(speed: f32, yaw: f32, budget: u32) -> f64 {
    const ROWS: usize = 64;
    const FRAME: f32 = 1.0 / 60.0;
    let solid = Cuboid::new(0.3, 0.3, 0.05);
    let sheet = curtain(Vec2::ONE, ROWS, ROWS, MassLumping::Lumped);
    let settings = Settings { substeps: Substeps::Automatic { budget }, ..Settings::default() };
    let mut solver = at_rest(&sheet, Vec3::ZERO, usual(), settings);
    solver.set_pins(&(0..ROWS as u32).collect::<Vec<_>>()).unwrap();
    let [_, end] = strains_while(solver, &solid, FRAME, 4 * SECOND, |tick| {
        let z = (speed * tick as f32 * FRAME - 1.0).min(0.5);
        let rotation = Quat::from_rotation_y(yaw);
        Pose { rotation, ..Pose::from_translation(Vec3::new(0.05, -0.5, z)) }
    });
    end
}

/// The largest strain at the end of any tick while a solid goes its way past a cloth whose pins stay, and at the end of all.
fn strains_while(
    mut solver: ClothSolver,
    solid: &dyn SignedDistance,
    dt: f32,
    ticks: usize,
    pose: impl Fn(usize) -> Pose,
) -> [f64; 2] {
    let pins = still(&solver);
    let mut peak = 0.0;
    for tick in 0..ticks {
        let colliders = [Collider::new(solid, pose(tick)).moving_to(pose(tick + 1))];
        let (gravity, pins, colliders) = (GRAVITY, &pins[..], &colliders[..]);
        let input = StepInput { dt, gravity, pins, colliders, ..StepInput::default() };
        solver.tick(&input).unwrap();
        peak = solver.strain().max.max(peak);
    }
    [peak.into(), solver.strain().max.into()]
}

/// Threads that it spans from side to side pass through it. With few substeps, friction at its corners may hold one a little
/// beyond the limit of 10 %: to 16 % in four of 81 runs.
#[test]
fn a_box_that_moves_into_a_curtain_does_not_stay_hooked_in_it() {
    for (budget, most) in [(20, 0.12), (8, 0.18)] {
        for yaw in [0.3, 0.5, 0.7] {
            for speed in [1.0, 2.0, 5.0, 10.0, 20.0] {
                let strain = strain_after(speed, yaw, budget);
                let what = format!("budget {budget}, turned by {yaw}, {speed} m/s: largest strain");
                check_at_most(&what, strain, most);
            }
        }
    }
}

/// A square metre held at its first row, by particles so many apart.
fn hung(topology: &Topology, every: usize) -> ClothSolver {
    let rest = topology.rest_positions();
    let start: Vec<_> = rest.iter().map(|p| Vec3::new(p.x, -p.z, 0.0)).collect();
    let settings = Settings { substeps: Substeps::Fixed(20), ..Settings::default() };
    let mut solver = ClothSolver::new(topology.clone(), &start, usual(), settings).unwrap();
    let is_top = |&i: &u32| start[i as usize].y == start[0].y;
    let top: Vec<_> = (0..rest.len() as u32).filter(is_top).step_by(every).collect();
    solver.set_pins(&top).unwrap();
    solver
}

/// Threads that are hooked in a capsule pass through it, and it takes none of them along: a spring was ten times too long.
#[test]
fn what_flies_through_a_curtain_takes_no_thread_along() {
    let capsule = Capsule3d::new(0.022, 0.054);
    for (name, topology) in lattice_and_mesh(1.0, 24) {
        let mut dice = Dice(5);
        for throw in 0..16 {
            let cloth = hung(&topology, 1);
            let to =
                centre(&cloth).as_vec3() + Vec3::new(0.4 * dice.roll(), 0.4 * dice.roll(), 0.0);
            let velocity =
                Vec3::new(2.0 * dice.roll(), 2.0 * dice.roll(), -9.0 + 3.0 * dice.roll());
            let (axis, turn) = (dice.direction().as_vec3(), Quat::from_rotation_x(dice.roll()));
            let strains = strains_while(cloth, &capsule, TICK, SECOND, |tick| {
                let t = tick as f32 * TICK;
                let rotation = Quat::from_axis_angle(axis, 8.0 * t) * turn;
                Pose { rotation, ..Pose::from_translation(to + velocity * (t - 0.05)) }
            });
            let what = format!("{name}, throw {throw}");
            check_at_most(&format!("{what}: largest strain"), strains[0], 2.0);
            check_at_most(&format!("{what}: strain at the end"), strains[1], 0.12);
        }
    }
}

/// A thread through a thin disc is never deep inside it. Where the disc stays in a fold, a spring is at 8 to 28 %.
#[test]
fn a_thin_disc_that_comes_down_on_a_hem_does_not_stay_hooked_in_it() {
    let disc = Cylinder::new(0.28, 0.012);
    for (name, topology) in lattice_and_mesh(1.0, 48) {
        let cloth = hung(&topology, 47);
        let middle = centre(&cloth).as_vec3();
        let [_, end] = strains_while(cloth, &disc, TICK, 4 * SECOND, |tick| {
            let at = middle + Vec3::Y * (0.9 - (tick as f32 * TICK).min(1.0));
            Pose { rotation: Quat::from_rotation_z(0.3), ..Pose::from_translation(at) }
        });
        check_at_most(&format!("{name}: strain at the end"), end, 0.35);
    }
}
