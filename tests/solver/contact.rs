//! Contact, held to Coulomb's law, to the gap it must keep and to giving no speed of its own.

use bevy::math::{
    Quat, Vec2, Vec3,
    bounding::Aabb3d,
    primitives::{InfinitePlane3d, Sphere},
};
use bevy_drape::{
    sdf::{SdfSample, SignedDistance},
    solver::{
        ClothSolver, Collider, MassLumping, Material, PinMotion, Pose, Settings, StepInput,
        StretchMethod,
    },
};

use crate::support::solver::*;

fn fixed<'a>(shape: &'a dyn SignedDistance, pose: Pose, friction: f32) -> Collider<'a> {
    Collider::new(shape, pose).with_friction(friction)
}

#[test]
fn no_particle_ends_a_tick_inside_a_sphere() {
    let ball = Sphere::new(0.5);
    for (lumping, thread_stiffness) in [(MassLumping::Lumped, 2000.0), (MassLumping::Equal, 10.0)] {
        let lattice = sheet(Vec2::splat(1.6), 40, 40, lumping);
        let material = Material {
            thread_stiffness,
            shear_stiffness: 0.01 * thread_stiffness,
            drag: 1.0,
            friction: 0.4,
            max_strain: 0.05,
            ..plain()
        };
        let settings = Settings { lumping, ..Settings::default() };
        let mut solver = at_rest(&lattice, Vec3::Y * 0.605, material, settings);
        let collider = fixed(&ball, Pose::IDENTITY, 0.4);
        let mut nearest = f64::INFINITY;
        let mut touched = 0;
        for _ in 0..320 {
            let report = run(&mut solver, 1, GRAVITY, &[collider]);
            touched = touched.max(report.contact_count);
            for p in positions(&solver) {
                nearest = nearest.min(p.as_dvec3().length() - 0.5 - f64::from(material.thickness));
            }
        }
        assert!(touched > 100, "only {touched} contacts");
        check_at_most(&format!("{}, deepest below epsilon [m]", solver.plan()), -nearest, 1e-6);
        // Held by friction and damped by the air, it lies still, all but its free hem.
        check_at_most(
            "speed left of the pole [m/s]",
            solver.velocity(20 * 40 + 20).length().into(),
            1e-3,
        );
        let (low, high) = solver.bounds();
        assert!(low.y > -1.2 && high.y < 0.52, "slid off: {low} {high}");
    }
}

#[test]
fn being_pushed_out_gives_no_speed() {
    let floor = InfinitePlane3d::new(Vec3::Y);
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for gravity in [Vec3::ZERO, GRAVITY] {
            let lattice = sheet(Vec2::splat(0.4), 9, 9, MassLumping::Lumped);
            let material = Material { thread_stiffness: 50.0, ..plain() };
            let start = Vec3::Y * 0.5 * material.thickness;
            let mut solver = at_rest(&lattice, start, material, settings(form, 8));
            let mut fastest_up = f64::NEG_INFINITY;
            for _ in 0..64 {
                run(&mut solver, 1, gravity, &[fixed(&floor, Pose::IDENTITY, 0.0)]);
                let up = velocities(&solver).iter().map(|v| v.y).fold(f32::NEG_INFINITY, f32::max);
                fastest_up = fastest_up.max(up.into());
            }
            check_at_most(&format!("{form:?}, upward speed [m/s]"), fastest_up, 1e-5);
            let height = positions(&solver).iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
            check("height at rest [m]", height.into(), 0.005, 1e-7);
        }
    }
}

/// How far a patch slides in a time down a plane of a slope, `high` above the world's origin.
fn slide(slope: f32, mu: f32, high: f32, substeps: u32, ticks: usize) -> f64 {
    let angle = slope.atan();
    let turn = Quat::from_rotation_z(-angle);
    let floor = InfinitePlane3d::new(Vec3::Y);
    let pose = Pose { translation: Vec3::Y * high, rotation: turn, scale: 1.0 };
    let lattice = sheet(Vec2::splat(0.2), 5, 5, MassLumping::Lumped);
    let material = Material { friction: mu, ..plain() };
    let start: Vec<_> = lattice
        .rest_positions()
        .iter()
        .map(|&p| turn * (p + Vec3::Y * material.thickness) + pose.translation)
        .collect();
    let settings = settings(StretchMethod::ImplicitThreads, substeps);
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    run(&mut solver, ticks, GRAVITY, &[fixed(&floor, pose, mu)]);
    let down = (turn * Vec3::X).as_dvec3();
    (solver.position(12) - start[12]).as_dvec3().dot(down)
}

#[test]
fn an_incline_holds_below_the_angle_of_friction() {
    for high in [0.005, 2.0] {
        for substeps in [4, 16, 64] {
            for mu in [0.2_f32, 0.6] {
                let what = format!("mu {mu} at {high} m x{substeps}");
                let creep = slide(0.95 * mu, mu, high, substeps, 640);
                check_at_most(&format!("{what}, creep in 10 s [m]"), creep.abs(), 1e-4);
            }
        }
    }
}

#[test]
fn an_incline_is_slid_down_with_coulombs_acceleration() {
    for high in [0.005, 2.0] {
        for substeps in [4, 16, 64] {
            for mu in [0.2_f32, 0.6] {
                for factor in [1.05_f32, 1.5] {
                    let slope = factor * mu;
                    let angle = f64::from(slope.atan());
                    let expected = 9.81 * (angle.sin() - f64::from(mu) * angle.cos());
                    let way = slide(slope, mu, high, substeps, 64);
                    let what =
                        format!("mu {mu} x{factor} at {high} m x{substeps}, acceleration [m/s2]");
                    check(&what, 2.0 * way, expected, 0.02 * expected);
                }
            }
        }
    }
}

#[test]
fn the_pair_has_the_geometric_mean_of_both_frictions() {
    // 0.9 and 0.4 make 0.6: held at 0.57, sliding at 0.63.
    let slide = |slope: f32| {
        let turn = Quat::from_rotation_z(-slope.atan());
        let floor = InfinitePlane3d::new(Vec3::Y);
        let pose = Pose { rotation: turn, ..Pose::IDENTITY };
        let lattice = sheet(Vec2::splat(0.2), 5, 5, MassLumping::Lumped);
        let material = Material { friction: 0.9, ..plain() };
        let start: Vec<_> =
            lattice.rest_positions().iter().map(|&p| turn * (p + Vec3::Y * 0.005)).collect();
        let mut solver = ClothSolver::new(
            lattice,
            &start,
            material,
            settings(StretchMethod::ImplicitThreads, 8),
        )
        .unwrap();
        run(&mut solver, 64, GRAVITY, &[fixed(&floor, pose, 0.4)]);
        f64::from(solver.position(12).distance(start[12]))
    };
    check_at_most("way at 0.95 of the mean's slope [m]", slide(0.57), 1e-4);
    assert!(slide(0.63) > 0.05);
}

#[test]
fn a_moving_collider_carries_the_cloth() {
    let floor = InfinitePlane3d::new(Vec3::Y);
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let material = Material { thread_stiffness: 50.0, friction: 0.8, ..plain() };
        let lattice = sheet(Vec2::splat(0.4), 9, 9, MassLumping::Lumped);
        let mut solver = at_rest(&lattice, Vec3::Y * 0.005, material, settings(form, 8));
        let start = positions(&solver);
        // Sideways, and lifted: the cloth must go along both ways.
        let speed = Vec3::new(0.5, 0.25, 0.0);
        let mut nearest = f64::INFINITY;
        for tick in 0..64 {
            let at = |tick: i32| Pose::from_translation(speed * (tick as f32 * TICK));
            let collider =
                Collider::new(&floor, at(tick)).moving_to(at(tick + 1)).with_friction(0.8);
            run(&mut solver, 1, GRAVITY, &[collider]);
            let height = at(tick + 1).translation.y;
            let low = positions(&solver).iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
            nearest = nearest.min(f64::from(low - height));
        }
        check(&format!("{form:?}, least gap [m]"), nearest, 0.005, 1e-6);
        let error =
            velocities(&solver).iter().map(|v| f64::from(v.distance(speed))).fold(0.0, f64::max);
        check_at_most(&format!("{form:?}, from the collider's velocity [m/s]"), error, 2e-3);
        // Being struck at 0.25 m/s gives it mu 0.25 of the 0.5 m/s at once; until friction has
        // given
        // the rest it lags: v^2 / (2 mu g).
        let way = f64::from(solver.position(40).x - start[40].x);
        let rest: f64 = 0.5 - 0.8 * 0.25;
        check(&format!("{form:?}, way [m]"), way, 0.5 - rest.powi(2) / (2.0 * 0.8 * 9.81), 1e-3);
    }
}

#[test]
fn a_turning_collider_carries_the_cloth_round() {
    // A turntable of 1 rad/s: friction holds the patch (omega^2 r = 0.2 m/s2 against 8).
    let floor = InfinitePlane3d::new(Vec3::Y);
    let material = Material { friction: 0.8, ..plain() };
    let lattice = sheet(Vec2::splat(0.2), 5, 5, MassLumping::Lumped);
    let offset = Vec3::new(0.2, 0.005, 0.0);
    let mut solver =
        at_rest(&lattice, offset, material, settings(StretchMethod::ImplicitThreads, 16));
    for i in 0..25 {
        let v = Vec3::Y.cross(solver.position(i));
        solver.set_velocity(i, v).unwrap();
    }
    for tick in 0..64 {
        let at = |tick: i32| Pose {
            rotation: Quat::from_rotation_y(tick as f32 * TICK),
            ..Pose::IDENTITY
        };
        let collider = Collider::new(&floor, at(tick)).moving_to(at(tick + 1)).with_friction(0.8);
        run(&mut solver, 1, GRAVITY, &[collider]);
    }
    let expected = Quat::from_rotation_y(1.0) * offset;
    check_at_most(
        "from where the turntable took it [m]",
        solver.position(12).distance(expected).into(),
        2e-3,
    );
}

#[test]
fn a_scaled_and_turned_collider_is_where_its_pose_says() {
    let ball = Sphere::new(0.25);
    let pose = Pose {
        translation: Vec3::new(0.1, -0.2, 0.05),
        rotation: Quat::from_rotation_x(0.7),
        scale: 2.0,
    };
    let lattice = sheet(Vec2::splat(0.6), 13, 13, MassLumping::Lumped);
    let mut solver =
        at_rest(&lattice, Vec3::Y * 0.35, plain(), settings(StretchMethod::ImplicitThreads, 8));
    let mut nearest = f64::INFINITY;
    for _ in 0..32 {
        run(&mut solver, 1, GRAVITY, &[fixed(&ball, pose, 0.0)]);
        for p in positions(&solver) {
            nearest = nearest.min(f64::from(p.distance(pose.translation)) - 0.5);
        }
    }
    check("least gap [m]", nearest, 0.005, 1e-6);
}

/// A floor that claims to be up to 3 cm further than it is.
#[derive(Debug)]
struct Overestimated;

impl SignedDistance for Overestimated {
    fn sample(&self, point: Vec3) -> SdfSample {
        let far = if point.y > 0.02 { 0.03 } else { 0.0 };
        SdfSample { distance: point.y + far, normal: Vec3::Y }
    }

    fn bounds(&self) -> Option<Aabb3d> {
        None
    }

    fn overestimate(&self) -> f32 {
        0.03
    }
}

#[test]
fn skipping_far_particles_skips_no_contact() {
    // Fast sheets at all heights: the gap that is skipped must be spent before the floor is
    // reached.
    for speed in [1.0, 10.0, 60.0] {
        let lattice = sheet(Vec2::new(1.0, 0.4), 9, 21, MassLumping::Lumped);
        let mut solver =
            at_rest(&lattice, Vec3::Y * 0.5, plain(), settings(StretchMethod::ImplicitThreads, 4));
        for i in 0..9 * 21 {
            solver
                .set_velocity(i, Vec3::NEG_Y * speed * (1.0 + 0.3 * (i % 21) as f32 / 20.0))
                .unwrap();
        }
        for _ in 0..32 {
            run(&mut solver, 1, GRAVITY, &[fixed(&Overestimated, Pose::IDENTITY, 0.5)]);
            let low = positions(&solver).iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
            assert!(low >= 0.005 - 1e-6, "{low} m at {speed} m/s");
        }
    }
}

#[test]
fn a_pin_goes_where_it_is_led_and_takes_the_cloth_along() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let lattice = curtain(Vec2::new(0.5, 0.5), 11, 11, MassLumping::Lumped);
        let material = Material { thread_stiffness: 40.0, drag: 1.0, ..plain() };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings(form, 16));
        let pinned: Vec<u32> = (0..11).collect();
        solver.set_pins(&pinned).unwrap();
        let home: Vec<_> = pinned.iter().map(|&p| solver.position(p as usize)).collect();
        for tick in 0..128 {
            // Up and aside at 0.5 m/s for a second, then still.
            let at =
                |tick: i32, p: Vec3| p + Vec3::new(0.3, 0.4, 0.0) * (tick.min(64) as f32 * TICK);
            let pins: Vec<_> = home
                .iter()
                .map(|&p| PinMotion { start: at(tick, p), end: at(tick + 1, p) })
                .collect();
            solver
                .tick(&StepInput {
                    dt: TICK,
                    gravity: GRAVITY,
                    pins: &pins,
                    colliders: &[],
                    ..StepInput::default()
                })
                .unwrap();
            for (&p, pin) in pinned.iter().zip(&pins) {
                assert!(solver.position(p as usize).distance(pin.end) < 1e-6, "{form:?}");
            }
            if tick == 32 {
                let speed = solver.velocity(0);
                assert!(
                    speed.distance(Vec3::new(0.3, 0.4, 0.0)) < 1e-3,
                    "{form:?} pin's velocity {speed}"
                );
            }
        }
        let hem = solver.position(10 * 11 + 5);
        check(&format!("{form:?}, the hem went along x [m]"), hem.x.into(), 0.3, 0.05);
        assert!(hem.y > -0.5 + 0.4 - 0.06 && hem.y < -0.05, "{form:?} hem {hem}");
    }
}
