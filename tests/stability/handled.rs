//! Cloth that is wrung, drawn through a funnel, and pulled off a table. Truths: the box that the motion of
//! the pins gives, the strain limit a second after the hands are still, and the surfaces of the colliders.

use crate::support::{kinds::*, solver::*};
use bevy::math::{
    Quat, Vec3,
    primitives::{Cuboid, Torus},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, Pose},
};

const N: usize = 17;

fn side(first: usize, step: usize) -> Vec<u32> {
    (0..N).map(|i| (first + i * step) as u32).collect()
}

/// Held by two opposite sides, one of them turned about the axis between their middles; then back again.
#[test]
fn h19_wrung_by_up_to_three_turns() {
    for kind in kinds(1.0, N) {
        for half_turns in [1, 2, 4, 6] {
            let what = format!("{}, {half_turns} half turns", kind.what);
            let mut solver = kind.solver(Quat::IDENTITY, Vec3::ZERO);
            let (left, right) = (side(0, N), side(N - 1, N));
            solver.set_pins(&[left, right].concat()).unwrap();
            let angle = half_turns as f32 * std::f32::consts::PI;
            // Wrung in four seconds, held for two, unwrung in four. The sides come together as the threads
            // of the border, which go round, need it.
            let path = |p: Vec3, t: f32| {
                let part = (t / 4.0).min(1.0).min(((10.0 - t) / 4.0).max(0.0));
                let turned =
                    if p.x > 0.0 { Quat::from_rotation_x(angle * part) } else { Quat::IDENTITY };
                let way = 0.5 * angle * part;
                let apart = (1.0 - way * way).max(0.0).sqrt().max(0.05);
                let p = turned * p;
                Vec3::new(p.x * apart, p.y, p.z)
            };
            let led = Led::new(&solver, &path);
            let within = Within::cube(1.3);
            let mut most = 0.0_f64;
            for tick in 0..TEN_SECONDS {
                step(&mut solver, &what, within, GRAVITY, &led.motions(tick), &[]);
                most = most.max(strain(&solver));
            }
            println!(
                "{what}: most strain {most:.3}, fastest at the end {:.2} m/s",
                fastest(&solver)
            );
            for tick in 0..SECOND {
                step(&mut solver, &what, within, GRAVITY, &led.motions(TEN_SECONDS + tick), &[]);
            }
            check_at_most(&format!("{what}: strain 1 s later"), strain(&solver), 0.2);
        }
    }
}

fn deepest(solver: &ClothSolver, shape: &dyn SignedDistance, pose: Pose) -> f64 {
    let depth = |p: Vec3| -shape.distance(pose.rotation.inverse() * (p - pose.translation));
    positions(solver).into_iter().map(depth).fold(f32::NEG_INFINITY, f32::max).into()
}

/// Drawn by its middle through a ring, whose hole is a fifth of the cloth's width.
#[test]
fn h19_drawn_through_a_ring() {
    let ring = Torus { minor_radius: 0.1, major_radius: 0.2 };
    for kind in kinds(1.0, N) {
        let what = format!("{}, through a ring", kind.what);
        let mut solver = kind.solver(Quat::IDENTITY, Vec3::Y * 0.2);
        solver.set_pins(&[(N * N / 2) as u32]).unwrap();
        let path = |p: Vec3, t: f32| p + Vec3::NEG_Y * 1.3 * (t / 5.0).min(1.0);
        let led = Led::new(&solver, &path);
        let colliders = [Collider::new(&ring, Pose::IDENTITY)];
        let within = Within(Vec3::new(-1.0, -2.2, -1.0), Vec3::new(1.0, 1.0, 1.0));
        let mut most = 0.0_f64;
        for tick in 0..TEN_SECONDS {
            step(&mut solver, &what, within, GRAVITY, &led.motions(tick), &colliders);
            most = most.max(strain(&solver));
        }
        println!("{what}: most strain {most:.3}, highest {:.3}", solver.bounds().1.y);
        check_at_most(&format!("{what}: strain at the end"), strain(&solver), 0.2);
        check_at_most(&format!("{what}: depth [m]"), deepest(&solver, &ring, Pose::IDENTITY), 1e-4);
    }
}

/// A tablecloth that hangs over all edges, pulled off by one side. It and the table are smooth: as particles
/// collide, and not the cloth between them, one may hook behind an edge that it rubs.
#[test]
fn h19_a_tablecloth_pulled_off() {
    let table = Cuboid::new(0.6, 0.1, 0.6);
    let pose = Pose::from_translation(Vec3::NEG_Y * 0.06);
    let n = 33;
    for mut kind in kinds(1.0, n) {
        kind.material.friction = 0.0;
        for speed in [0.5_f32, 2.0, 8.0] {
            let what = format!("{}, pulled at {speed} m/s", kind.what);
            let mut solver = kind.solver(Quat::IDENTITY, Vec3::ZERO);
            let colliders = [Collider::new(&table, pose).with_friction(0.0)];
            let away = 2.0;
            let within = Within(Vec3::new(-1.0, -1.6, -1.0), Vec3::new(2.0 + away, 1.5, 1.0));
            steps(&mut solver, &what, 2 * SECOND, within, GRAVITY, &colliders);
            let pins: Vec<_> = (0..n).map(|i| ((i + 1) * n - 1) as u32).collect();
            solver.set_pins(&pins).unwrap();
            let path = |p: Vec3, t: f32| p + Vec3::X * (speed * t).min(away);
            let led = Led::new(&solver, &path);
            let mut most = 0.0_f64;
            let pulled = (away / speed / TICK).ceil() as usize;
            for tick in 0..pulled {
                step(&mut solver, &what, within, GRAVITY, &led.motions(tick), &colliders);
                most = most.max(strain(&solver));
            }
            println!("{what}: most strain {most:.3}, fastest {:.2}", fastest(&solver));
            for tick in pulled..pulled + SECOND {
                step(&mut solver, &what, within, GRAVITY, &led.motions(tick), &colliders);
            }
            check_at_most(&format!("{what}: strain 1 s later"), strain(&solver), 0.2);
            check_at_most(&format!("{what}: depth [m]"), deepest(&solver, &table, pose), 1e-4);
        }
    }
}
