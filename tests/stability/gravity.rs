//! Gravity that is none, turned round, or a hundred times what it is. Truths: momentum under no force, bounds
//! of a cloth that hangs, and the strain limit once gravity is itself again.

use crate::support::{kinds::*, solver::*};
use bevy::math::{Vec3, primitives::Sphere};
use bevy_drape::solver::{Collider, Pose};

const N: usize = 13;
const CORNERS: [u32; 2] = [0, N as u32 - 1];

/// Held by two corners, a metre wide and long: nothing is further from a corner than the diagonal and what
/// twice the strain limit adds, once gravity is at most that of the Earth.
fn reach(kind: &Kind) -> Within {
    let limit = 2.0 * kind.material.max_strain;
    Within::cube(0.5 + (2.0_f32).sqrt() * (1.0 + limit))
}

#[test]
fn h16_no_gravity_moves_nothing() {
    for kind in kinds(1.0, N) {
        for pins in [&CORNERS[..], &[]] {
            let mut solver = kind.hanging();
            solver.set_pins(pins).unwrap();
            let before = positions(&solver);
            steps(&mut solver, &kind.what, TEN_SECONDS, reach(&kind), Vec3::ZERO, &[]);
            // A cloth in its rest shape feels no force but that of rounding.
            let moved = farthest(&before, &positions(&solver));
            check_at_most(&format!("{}: moved in 10 s [m]", kind.what), moved, 1e-4);
        }
    }
}

#[test]
fn h16_gravity_turned_round_over_and_over() {
    for kind in kinds(1.0, N) {
        // Each tick, four times a second, every second.
        for period in [1, 16, 64] {
            let what = format!("{}, turned every {period} ticks", kind.what);
            let mut solver = kind.hanging();
            solver.set_pins(&CORNERS).unwrap();
            let mut most = 0.0_f64;
            for tick in 0..TEN_SECONDS {
                let gravity = if (tick / period).is_multiple_of(2) { -GRAVITY } else { GRAVITY };
                steps(&mut solver, &what, 1, reach(&kind), gravity, &[]);
                most = most.max(strain(&solver));
            }
            println!("{what}: most strain {most:.3}");
            steps(&mut solver, &what, SECOND, reach(&kind), GRAVITY, &[]);
            check_at_most(&format!("{what}: strain after 1 s"), strain(&solver), 0.2);
        }
    }
}

#[test]
fn h16_a_hundred_times_the_gravity() {
    let ball = Sphere::new(0.4);
    for kind in kinds(1.0, N) {
        for on_ball in [false, true] {
            let what = format!("{}, on a ball {on_ball}", kind.what);
            let (mut solver, colliders) = if on_ball {
                let solver = kind.solver(bevy::math::Quat::IDENTITY, Vec3::Y * 0.5);
                (solver, vec![Collider::new(&ball, Pose::IDENTITY)])
            } else {
                let mut solver = kind.hanging();
                solver.set_pins(&CORNERS).unwrap();
                (solver, Vec::new())
            };
            // Without a limit on its strain it would hang some metres lower.
            let within = if on_ball {
                // It trembles on the ball by 8 m/s, and leaps by that when the gravity ends.
                Within(Vec3::new(-5.0, -1e4, -5.0), Vec3::new(5.0, 4.0, 5.0))
            } else {
                Within::cube(3.0)
            };
            let mut most = 0.0_f64;
            for _ in 0..TEN_SECONDS {
                steps(&mut solver, &what, 1, within, GRAVITY * 100.0, &colliders);
                most = most.max(strain(&solver));
            }
            println!("{what}: most strain {most:.3}, at the end {:.3}", strain(&solver));
            steps(&mut solver, &what, SECOND, within, GRAVITY, &colliders);
            check_at_most(&format!("{what}: strain 1 s later"), strain(&solver), 0.2);
        }
    }
}
