//! Cloth between two colliders that are closer to each other than twice the distance it keeps: nowhere can it
//! be where both let it. Truth: it is let out no faster than the settings say, moves no more and more, and
//! where the colliders part again it is a cloth again.

use crate::support::{kinds::*, solver::*};
use bevy::math::{
    Quat, Vec3,
    primitives::{Cuboid, InfinitePlane3d, Sphere},
};
use bevy_drape::solver::{ClothSolver, Collider, Pose};

const N: usize = 13;

/// Surfaces this far apart: overlapping, touching, less than twice and just twice the thickness.
const GAPS: [f32; 5] = [-0.002, 0.0, 0.004, 0.0099, 0.01];

/// Lying on the floor for a while, then between the floor and a plate.
#[test]
fn h23_between_two_plates() {
    let (floor, plate) = (InfinitePlane3d::new(Vec3::Y), Cuboid::new(3.0, 0.5, 3.0));
    for kind in kinds(1.0, N) {
        for gap in GAPS {
            let what = format!("{}, between plates {gap} m apart", kind.what);
            let mut solver = kind.solver(Quat::IDENTITY, Vec3::Y * 0.5 * gap.max(0.0));
            let colliders = [
                Collider::new(&floor, Pose::IDENTITY),
                Collider::new(&plate, Pose::from_translation(Vec3::Y * (0.25 + gap))),
            ];
            check_growth(&mut solver, &what, &colliders);
        }
    }
}

/// In the wedge between two balls that touch.
#[test]
fn h23_between_two_balls() {
    let ball = Sphere::new(0.5);
    for kind in kinds(1.0, N) {
        for gap in GAPS {
            let what = format!("{}, between balls {gap} m apart", kind.what);
            let mut solver = kind.solver(Quat::IDENTITY, Vec3::ZERO);
            let at = |side: f32| Pose::from_translation(Vec3::Y * side * (0.5 + 0.5 * gap));
            let colliders = [Collider::new(&ball, at(-1.0)), Collider::new(&ball, at(1.0))];
            check_growth(&mut solver, &what, &colliders);
        }
    }
}

/// Ten seconds: what moves in the last two is no more than before, but for chance: between colliders
/// that contradict each other it trembles, more or less of it.
fn check_growth(solver: &mut ClothSolver, what: &str, colliders: &[Collider<'_>]) {
    let within = Within::cube(1.6);
    let mut most_of = |ticks| {
        (0..ticks).fold(0.0, |most: f64, _| {
            steps(solver, what, 1, within, GRAVITY, colliders);
            most.max(solver.largest_move().into())
        })
    };
    let (first, last) = (most_of(8 * SECOND), most_of(2 * SECOND));
    check_at_most(&format!("{what}: most moved in a tick, later [m]"), last, 1.25 * first + 1e-4);
}

/// A plate that comes down on it, goes through the floor's surface, and up again.
#[test]
fn h23_between_plates_that_close() {
    let (floor, plate) = (InfinitePlane3d::new(Vec3::Y), Cuboid::new(3.0, 0.5, 3.0));
    for kind in kinds(1.0, N) {
        for speed in [0.1_f32, 1.0, 10.0] {
            let what = format!("{}, closing at {speed} m/s", kind.what);
            let mut solver = kind.solver(Quat::IDENTITY, Vec3::Y * 0.1);
            let lowest = -0.01;
            let height = |t: f32| {
                let down = (0.4 - speed * (t - 1.0).max(0.0)).max(lowest);
                if t < 8.0 { down } else { (down + speed * (t - 8.0)).min(0.4) }
            };
            let pose = |t: f32| Pose::from_translation(Vec3::Y * (0.25 + height(t)));
            let within = Within::cube(1.6);
            let (mut fast, mut most) = (0.0_f64, 0.0_f64);
            for tick in 0..TEN_SECONDS {
                let t = tick as f32 * TICK;
                let colliders = [
                    Collider::new(&floor, Pose::IDENTITY),
                    Collider::new(&plate, pose(t)).moving_to(pose(t + TICK)),
                ];
                steps(&mut solver, &what, 1, within, GRAVITY, &colliders);
                fast = fast.max(fastest(&solver));
                most = most.max(strain(&solver));
            }
            println!(
                "{what}: fastest {fast:.2} m/s, most strain {most:.3}, at the end {:.3}",
                strain(&solver)
            );
            let colliders = [Collider::new(&floor, Pose::IDENTITY)];
            steps(&mut solver, &what, SECOND, within, GRAVITY, &colliders);
            check_at_most(&format!("{what}: strain 1 s later"), strain(&solver), 0.2);
            let lowest = solver.bounds().0.y;
            check_at_most(&format!("{what}: below the floor [m]"), f64::from(-lowest), 1e-4);
        }
    }
}
