//! Carrying a cloth: invariants. Shape, strain and relative velocities are what they were, to the bit
//! where the way is a multiple of 1/16 m; a cloth that is carried and goes on is one that went on and
//! was carried.

use bevy::math::{Quat, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, MassLumping, Material, Pose, RigidMotion, SolverError, StretchMethod,
};

use crate::support::solver::*;

/// A sheet that swings from two corners and is far from flat.
fn swinging() -> ClothSolver {
    let lattice = sheet(Vec2::new(1.0, 1.3), 14, 21, MassLumping::Lumped);
    let material =
        Material { flexural_rigidity: 1e-5, shear_stiffness: 20.0, drag: 0.3, ..plain() };
    let mut solver =
        at_rest(&lattice, Vec3::Y * 3.0, material, settings(StretchMethod::ImplicitThreads, 12));
    solver.set_pins(&[0, 20]).unwrap();
    run(&mut solver, 40, GRAVITY, &[]);
    solver
}

fn carried(solver: &ClothSolver, to: Pose) -> ClothSolver {
    let mut solver = solver.clone();
    solver.carry(&Pose::IDENTITY, &to).unwrap();
    solver
}

#[test]
fn a_way_of_whole_sixteenths_changes_no_bit() {
    let solver = swinging();
    for way in [Vec3::new(10.0, 0.0, 0.0), Vec3::new(-123.0625, 7.5, 4096.0)] {
        let mut moved = carried(&solver, Pose::from_translation(way));
        assert_eq!(bits(&moved), bits(&solver));
        assert_eq!(moved.origin(), solver.origin() + way);
        let mut stayed = solver.clone();
        assert_eq!(moved.largest_move(), stayed.largest_move());
        run(&mut moved, 20, GRAVITY, &[]);
        run(&mut stayed, 20, GRAVITY, &[]);
        let (a, b) = (positions(&moved), positions(&stayed));
        let b: Vec<_> = b.iter().map(|&p| p + way).collect();
        // Far away, pins are where the world's coordinates can say.
        check_at_most("apart after 20 ticks [m]", farthest(&a, &b), 2e-3);
    }
}

#[test]
fn strain_and_relative_velocities_are_what_they_were() {
    let solver = swinging();
    let turn = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 2.0);
    for translation in [Vec3::new(10.3, -2.7, 0.1), Vec3::splat(3e4)] {
        for rotation in [Quat::IDENTITY, turn] {
            let moved = carried(&solver, Pose { translation, rotation, scale: 1.0 });
            let what = format!("{translation} turned {}", rotation != Quat::IDENTITY);
            let worst = thread_strains(&solver)
                .iter()
                .zip(thread_strains(&moved))
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            check_at_most(&format!("{what}: strain changed by"), worst, 3e-5);
            let turned: Vec<_> = velocities(&solver).iter().map(|&v| rotation * v).collect();
            let apart = farthest(&turned, &velocities(&moved));
            check_at_most(&format!("{what}: velocity changed by [m/s]"), apart, 1e-5);
            assert!(fastest(&moved) > 0.1);
        }
    }
}

#[test]
fn carried_and_gone_on_is_gone_on_and_carried() {
    let pose = Pose {
        translation: Vec3::new(8.0, 1.0, -3.0),
        rotation: Quat::from_axis_angle(Vec3::new(0.0, 0.6, 0.8), 1.2),
        scale: 1.0,
    };
    let solver = swinging();
    let mut first = carried(&solver, pose);
    run(&mut first, 10, pose.rotation * GRAVITY, &[]);
    let mut later = solver.clone();
    run(&mut later, 10, GRAVITY, &[]);
    let later = carried(&later, pose);
    check_at_most("apart [m]", farthest(&positions(&first), &positions(&later)), 2e-4);
}

#[test]
fn what_rides_was_where_it_was_and_what_teleports_was_not() {
    let solver = swinging();
    let way = Vec3::new(1.0, 0.25, 0.0);
    let started = |s: &ClothSolver| s.origin() + s.local_start_position(150);
    let mut rides = solver.clone();
    let motion = RigidMotion::between(&Pose::IDENTITY, &Pose::from_translation(way));
    rides.ride(&motion).unwrap();
    let jumped = carried(&solver, Pose::from_translation(way));
    assert_eq!(positions(&rides), positions(&jumped));
    assert_eq!(bits(&rides), bits(&jumped));
    assert!(started(&rides).distance(started(&solver)) < 1e-6);
    assert!(started(&jumped).distance(started(&solver) + way) < 1e-6);
}

#[test]
fn motions_undo_and_add_up() {
    let from = Pose {
        translation: Vec3::new(1.0, 2.0, 3.0),
        rotation: Quat::from_rotation_x(0.4),
        scale: 1.0,
    };
    let to = Pose {
        translation: Vec3::new(-4.0, 0.5, 2.0),
        rotation: Quat::from_rotation_z(1.4),
        scale: 1.0,
    };
    let motion = RigidMotion::between(&from, &to);
    let point = Vec3::new(0.3, -0.7, 1.9);
    let local = from.rotation.inverse() * (point - from.translation);
    assert!(motion.apply(point).distance(to.translation + to.rotation * local) < 1e-5);
    assert!(motion.inverse().apply(motion.apply(point)).distance(point) < 1e-5);
    let end = motion.apply_to_pose(&from);
    assert!(end.translation.distance(to.translation) < 1e-5);
    assert!(end.rotation.angle_between(to.rotation) < 1e-3);
    assert!(motion.part(0.0, 0.0).is_none());
    assert_eq!(motion.part(1.0, 1.0), motion);
    assert!(RigidMotion::between(&from, &from).is_none());
    let half = motion.part(0.5, 0.5);
    assert!(half.apply(half.pivot).distance(half.pivot + motion.shift * 0.5) < 1e-6);
    let turned = half.rotation.angle_between(Quat::IDENTITY);
    assert!((turned * 2.0 - motion.rotation.angle_between(Quat::IDENTITY)).abs() < 1e-3);
}

#[test]
fn a_reset_cloth_is_a_new_one() {
    let solver = swinging();
    let pose = Pose {
        translation: Vec3::new(2.0, 7.0, 1.0),
        rotation: Quat::from_rotation_y(0.5),
        scale: 3.0,
    };
    let mut again = solver.clone();
    again.reset(&pose).unwrap();
    again.set_pins(&[]).unwrap();
    let start: Vec<_> = solver
        .topology()
        .rest_positions()
        .iter()
        .map(|&p| pose.rotation * p + pose.translation)
        .collect();
    check_at_most("from the rest shape [m]", farthest(&positions(&again), &start), 1e-6);
    assert_eq!((fastest(&again), again.has_moved()), (0.0, false));
    let mut new =
        ClothSolver::new(solver.topology().clone(), &start, *solver.material(), *solver.settings())
            .unwrap();
    run(&mut again, 30, GRAVITY, &[]);
    run(&mut new, 30, GRAVITY, &[]);
    check_at_most("from a new one [m]", farthest(&positions(&again), &positions(&new)), 1e-5);
    check_at_most("its speed too [m/s]", (fastest(&again) - fastest(&new)).abs(), 1e-5);
}

#[test]
fn bounds_follow_what_is_put_elsewhere() {
    let mut solver = swinging();
    for particle in 0..solver.topology().particle_count() {
        let place = solver.position(particle) + Vec3::X * 900.0;
        solver.set_position(particle, place).unwrap();
    }
    let (min, max) = solver.bounds();
    for p in positions(&solver) {
        assert!(p.cmpge(min - 1e-3).all() && p.cmple(max + 1e-3).all());
    }
    assert!(max.x - min.x < 2.0 && min.x > 800.0);
    assert!(solver.has_moved());
    // The origin has followed before positions lose bits.
    run(&mut solver, 1, Vec3::ZERO, &[]);
    assert!(solver.local_position(0).length() < 64.0);
}

#[test]
fn poses_that_cannot_be_used_are_refused_and_nothing_moves() {
    let solver = swinging();
    let nan = Pose::from_translation(Vec3::NAN);
    let far = Pose::from_translation(Vec3::X * 1e8);
    let flat = Pose { rotation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..Pose::IDENTITY };
    for bad in [nan, far, flat] {
        let mut tried = solver.clone();
        assert_eq!(tried.carry(&Pose::IDENTITY, &bad), Err(SolverError::Motion));
        assert_eq!(tried.reset(&bad), Err(SolverError::Motion));
        let motion =
            RigidMotion { pivot: Vec3::ZERO, rotation: bad.rotation, shift: bad.translation };
        assert_eq!(tried.ride(&motion), Err(SolverError::Motion));
        assert_eq!(bits(&tried), bits(&solver));
    }
}
