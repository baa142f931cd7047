//! Colliders that are fast, many, or stand where the cloth is. Held to what cannot be: no particle
//! goes through, none is faster than allowed, momentum is kept, and what is far changes no bit. Fast
//! balls are among the hard cases (tests/stability).

use bevy::math::{
    DVec3, Quat, Vec2, Vec3,
    primitives::{Cuboid, InfinitePlane3d, Sphere},
};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{ClothSolver, Collider, MassLumping, Material, Pose, Settings, StepInput},
};

use crate::support::solver::*;

/// A collider's pose at a time \[s\].
pub type Path<'a> = &'a dyn Fn(f32) -> Pose;

/// Part of the way along which a particle's way past a collider is looked at.
const LOOKS: usize = 32;

/// Runs a cloth past a moving shape, a substep at a time, and returns the deepest place of any
/// particle's way, straight as seen from the shape \[m\].
pub fn deepest_way(
    solver: &mut ClothSolver,
    shape: &dyn SignedDistance,
    path: Path,
    ticks: usize,
) -> f32 {
    let pins: Vec<_> = still(solver);
    let count = solver.topology().particle_count();
    let mut deepest = f32::NEG_INFINITY;
    for tick in 0..ticks {
        let (from, to) = (path(tick as f32 * TICK), path((tick + 1) as f32 * TICK));
        let colliders = [Collider::new(shape, from).moving_to(to)];
        let input = StepInput {
            dt: TICK,
            gravity: Vec3::ZERO,
            pins: &pins,
            colliders: &colliders,
            ..StepInput::default()
        };
        let substeps = solver.begin_tick(&input).unwrap();
        for substep in 0..substeps {
            let pose = |at: u32| from.interpolate(&to, at as f32 / substeps as f32);
            let seen = |solver: &ClothSolver, pose: Pose, i: usize| {
                pose.rotation.inverse() * (solver.position(i) - pose.translation) / pose.scale
            };
            let before: Vec<_> = (0..count).map(|i| seen(solver, pose(substep), i)).collect();
            solver.accumulate_forces(&input);
            solver.integrate(&input);
            solver.correct();
            solver.collide(&input);
            for (i, &before) in before.iter().enumerate() {
                let after = seen(solver, pose(substep + 1), i);
                for look in 0..=LOOKS {
                    let at = before.lerp(after, look as f32 / LOOKS as f32);
                    deepest = deepest.max(-shape.distance(at));
                }
            }
        }
        solver.end_tick().unwrap();
    }
    deepest
}

fn free_sheet(n: usize) -> ClothSolver {
    let material = Material { shear_stiffness: 100.0, max_strain: 0.1, friction: 0.5, ..plain() };
    let lattice = sheet(Vec2::splat(1.0), n, n, MassLumping::Lumped);
    at_rest(&lattice, Vec3::ZERO, material, Settings::default())
}

#[test]
fn a_fast_sheet_goes_through_no_thin_wall() {
    let wall = Cuboid::new(4.0, 0.004, 4.0);
    for speed in [10.0, 60.0] {
        let mut solver = free_sheet(16);
        for i in 0..256 {
            solver.set_velocity(i, Vec3::NEG_Y * speed).unwrap();
        }
        let path = |_| Pose::from_translation(Vec3::NEG_Y * 0.3);
        let deepest = deepest_way(&mut solver, &wall, &path, 32);
        check_at_most(&format!("{speed} m/s: deepest way [m]"), deepest.into(), 1e-5);
        assert!(solver.bounds().0.y > -0.3, "went through");
    }
}

#[test]
fn a_fast_bar_that_turns_goes_through_no_particle() {
    // Its ends go at 40 m/s, 3 cm a substep, and it is 4 cm thick.
    let bar = Cuboid::new(2.0, 0.04, 0.04);
    let mut solver = free_sheet(32);
    let path = |t: f32| Pose {
        translation: Vec3::new(-0.9, -0.1, 0.0),
        rotation: Quat::from_rotation_z(-0.4 + 40.0 * t),
        scale: 1.0,
    };
    let deepest = deepest_way(&mut solver, &bar, &path, 8);
    // Seen from what turns, a straight way is none: it is s omega h / 8 deep, some 0.1 mm.
    check_at_most("deepest way [m]", deepest.into(), 1e-3);
}

/// Limbs of one body that overlap: what the first does to a particle must not hide its way from the second.
#[test]
fn a_fast_body_of_several_solids_goes_through_no_particle() {
    let ball = Sphere::new(0.15);
    let mut solver = free_sheet(33);
    let at = |x: f32, height: f32| Pose {
        translation: Vec3::new(x, height - ball.radius - 0.011, 0.03),
        ..Pose::IDENTITY
    };
    let places = [-0.1, 0.0, 0.1];
    for tick in 0..4 {
        // At rest, then at 50 m/s.
        let height = |tick: i32| 50.0 * TICK * (tick - 1).max(0) as f32;
        let moving =
            |x: f32| Collider::new(&ball, at(x, height(tick))).moving_to(at(x, height(tick + 1)));
        let colliders = places.map(moving);
        let input = StepInput { dt: TICK, colliders: &colliders, ..StepInput::default() };
        solver.tick(&input).unwrap();
        let deepest = (0..33 * 33).map(|i| {
            let gaps = places.map(|x| {
                let centre = at(x, height(tick + 1)).translation;
                solver.position(i).distance(centre) - ball.radius
            });
            -gaps.into_iter().fold(f32::INFINITY, f32::min)
        });
        check_at_most("inside", deepest.fold(f32::NEG_INFINITY, f32::max).into(), 1e-3);
    }
}

#[test]
fn friction_of_the_sweep_is_coulombs() {
    // A patch that meets the floor at 20 m/s both down and along loses mu times the one of the other.
    let floor = InfinitePlane3d::new(Vec3::Y);
    for mu in [0.0_f32, 0.25, 2.0] {
        let lattice = sheet(Vec2::splat(0.2), 5, 5, MassLumping::Lumped);
        let material = Material { friction: mu, ..plain() };
        let mut solver = at_rest(&lattice, Vec3::Y * 0.1, material, Settings::default());
        for i in 0..25 {
            solver.set_velocity(i, Vec3::new(20.0, -20.0, 0.0)).unwrap();
        }
        run(&mut solver, 4, Vec3::ZERO, &[Collider::new(&floor, Pose::IDENTITY).with_friction(mu)]);
        let expected = f64::from((20.0 - mu * 20.0).max(0.0));
        let v = solver.velocity(12);
        check(&format!("mu {mu}: speed along [m/s]"), v.x.into(), expected, 1e-3);
        check(&format!("mu {mu}: speed down [m/s]"), v.y.into(), 0.0, 1e-3);
    }
}

#[test]
fn what_starts_inside_comes_out_no_faster_than_set() {
    let ball = Sphere::new(0.4);
    for limit in [0.5_f32, 2.0] {
        let material = Material {
            drag: 2.0,
            shear_stiffness: 50.0,
            max_strain: 0.1,
            friction: 0.3,
            ..plain()
        };
        let lattice = sheet(Vec2::splat(1.0), 24, 24, MassLumping::Lumped);
        let settings = Settings { max_depenetration_speed: limit, ..Settings::default() };
        // Half of the sheet is inside, none of it at the centre, where no way out is the nearest.
        let mut solver = at_rest(&lattice, Vec3::new(0.3, 0.1, 0.0), material, settings);
        let collider = [Collider::new(&ball, Pose::IDENTITY)];
        let (mut inside, mut after) = (0.0_f64, 0.0_f64);
        for _ in 0..192 {
            run(&mut solver, 1, Vec3::ZERO, &collider);
            let speeds = velocities(&solver).into_iter().map(|v| f64::from(v.length()));
            let fastest = speeds.fold(0.0, f64::max);
            if positions(&solver).iter().any(|p| p.length() < 0.39) {
                inside = inside.max(fastest);
            } else {
                after = after.max(fastest);
            }
        }
        check_at_most(
            "fastest particle while any is inside [m/s]",
            inside,
            f64::from(limit) * 1.001,
        );
        // Free again, the hem of a sheet that comes to rest whips.
        check_at_most("fastest particle afterwards [m/s]", after, f64::from(limit) * 2.25);
        let nearest = positions(&solver).iter().map(|p| p.length()).fold(f32::INFINITY, f32::min);
        check_at_most("left inside epsilon [m]", f64::from(0.405 - nearest), 1e-4);
    }
}

fn momentum(solver: &ClothSolver) -> DVec3 {
    let of = |i| solver.velocity(i).as_dvec3() * f64::from(solver.mass(i));
    (0..solver.topology().particle_count()).map(of).sum()
}

/// Runs a tick without gravity, and returns the momentum that the collider was given, and how much less that is than what the
/// cloth lost.
fn give(solver: &mut ClothSolver, collider: Collider) -> (DVec3, DVec3) {
    let colliders = [collider.measured()];
    let input = StepInput {
        dt: TICK,
        gravity: Vec3::ZERO,
        pins: &[],
        colliders: &colliders,
        ..StepInput::default()
    };
    let before = momentum(solver);
    solver.tick(&input).unwrap();
    let given = solver.impulse(0).linear.as_dvec3();
    (given, before - momentum(solver) - given)
}

#[test]
fn what_the_cloth_loses_the_collider_is_given() {
    let ball = Sphere::new(0.3);
    for speed in [2.0, 40.0] {
        let mut solver = free_sheet(24);
        for i in 0..24 * 24 {
            solver.set_velocity(i, Vec3::new(0.3, -1.0, 0.1) * speed).unwrap();
        }
        let before = momentum(&solver);
        let pose = Pose::from_translation(Vec3::new(0.05, -0.35, 0.02));
        let mut missing = DVec3::ZERO;
        for _ in 0..32 {
            missing += give(&mut solver, Collider::new(&ball, pose)).1;
        }
        let lost = before - momentum(&solver);
        assert!(lost.length() > 0.1 * before.length(), "hardly touched: {lost}");
        check_at_most(
            &format!("{speed} m/s: momentum lost less impulse, relative"),
            missing.length() / before.length(),
            // What is carried on is borne a half at a time, and rounded each time.
            1e-4,
        );
    }
}

#[test]
fn what_a_cloth_loses_that_is_let_through_the_collider_is_given() {
    // A bar that appears in a free sheet lets it out to both sides: threads between them are hooked in it.
    let bar = Cuboid::new(0.2, 0.2, 0.5);
    let mut hooked = 0;
    for at in [0.07, 0.1, 0.17, 0.24, 0.29] {
        let pose = Pose::from_translation(Vec3::new(at, 0.03, 0.02 - 0.3 * (at - 0.07)));
        let mut solver = free_sheet(24);
        let (mut given, mut missing, mut strain) = (0.0_f64, 0.0_f64, 0.0_f32);
        for _ in 0..90 {
            let tick = give(&mut solver, Collider::new(&bar, pose));
            given = given.max(tick.0.length());
            missing = missing.max(tick.1.length());
            strain = strain.max(solver.strain().max);
        }
        println!(
            "at {at}: {missing:.1e} of {given:.1e}, {strain}, at the end {}",
            solver.strain().max
        );
        hooked += u32::from(strain > 1.0);
        assert!(solver.strain().max < 0.5, "at {at}: {}", solver.strain().max);
        let what = format!("at {at}: momentum lost less impulse in a tick, relative");
        check_at_most(&what, missing / given, 1e-4);
    }
    assert!(hooked > 2, "hooked, and let through, {hooked} times");
}

#[test]
fn far_colliders_and_other_layers_change_no_bit() {
    let (ball, floor) = (Sphere::new(0.3), InfinitePlane3d::new(Vec3::Y));
    let near = Collider::new(&ball, Pose::from_translation(Vec3::Y * -0.31));
    let far = |i: usize| {
        let place = Vec3::new(5.0 + i as f32, -3.0, (i % 7) as f32);
        Collider::new(&ball, Pose::from_translation(place))
    };
    let elsewhere = Collider::new(&floor, Pose::IDENTITY).in_layers(0b10);
    let result = |colliders: &[Collider]| {
        let mut solver = free_sheet(20);
        solver.set_settings(Settings { layers: 0b101, ..Settings::default() }).unwrap();
        run(&mut solver, 60, GRAVITY, colliders);
        (bits(&solver), solver.bounds().0.y)
    };
    let (alone, low) = result(&[near]);
    assert!(low < -0.4, "held up at {low}");
    let mut many: Vec<_> = (0..300).map(far).collect();
    many.insert(100, elsewhere);
    many.insert(200, near);
    assert!(alone == result(&many).0);
    // And the floor does hold it where they share a layer.
    let (_, low) = result(&[near, elsewhere.in_layers(0b110)]);
    assert!(low > 0.0, "fell to {low}");
}

#[test]
fn a_collider_far_off_is_met_in_time() {
    // It falls 4.9 m in a second, over colliders that wake one after the other.
    let ball = Sphere::new(0.6);
    let mut solver = free_sheet(12);
    let colliders: Vec<_> = (0..20)
        .map(|i| {
            Collider::new(&ball, Pose::from_translation(Vec3::NEG_Y * (4.0 + 30.0 * i as f32)))
        })
        .collect();
    let mut nearest = f32::INFINITY;
    for _ in 0..96 {
        run(&mut solver, 1, GRAVITY, &colliders);
        for p in positions(&solver) {
            nearest = nearest.min((p + Vec3::Y * 4.0).length() - 0.6);
        }
    }
    check("least gap [m]", nearest.into(), 0.005, 2e-4);
}
