//! Pushes, held to the closed forms of a free body: `v = F t / m`, `x = F t^2 / 2 m`, `v = J / m`, with linear
//! drag `v = F / (m c) (1 - exp(-c t))`; to momentum, linear and angular; to statics, `F = k x`; and to bits
//! where nothing may change.

use bevy::math::{DVec3, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, Integrator, Isa, MassLumping, Material, ParameterError, PinMotion, PushOn,
    PushWith, Settings, SoftPin, SolverError, StepInput, StretchMethod, Topology,
};

use crate::support::solver::*;

const FORCE: Vec3 = Vec3::new(0.3, -0.2, 0.5);

fn topologies() -> [(&'static str, Topology); 2] {
    let lattice = sheet(Vec2::new(1.0, 0.8), 9, 13, MassLumping::Lumped);
    [("lattice", lattice.into()), ("mesh", mesh(9, 13, 0.08, 0.2).into())]
}

/// Ticks without gravity, each with a force on the whole cloth.
fn pushed(solver: &mut ClothSolver, force: Vec3, ticks: usize) {
    for _ in 0..ticks {
        solver.push(PushOn::All, PushWith::Force(force)).unwrap();
        tick(solver);
    }
}

fn tick(solver: &mut ClothSolver) {
    let pins = still(solver);
    let input = StepInput { dt: TICK, pins: &pins, ..StepInput::default() };
    solver.tick(&input).unwrap();
}

#[test]
fn a_free_cloth_under_a_force_moves_with_its_share_of_mass() {
    for (what, topology) in topologies() {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            // At rest before, and already in ticks: a force that begins between two kicks is as long.
            for (substeps, ticks_before) in [(1, 0), (8, 0), (8, 3), (40, 3)] {
                let soft = Material { thread_stiffness: 1.0, ..plain() };
                let mut solver = at_rest(&topology, Vec3::ZERO, soft, settings(form, substeps));
                for _ in 0..ticks_before {
                    tick(&mut solver);
                }
                let (start, m) = (centre(&solver), mass(&solver));
                pushed(&mut solver, FORCE, 10);
                let t = 10.0 * f64::from(TICK);
                let expected = FORCE.as_dvec3() * (t * t / (2.0 * m));
                let what = format!("{what} {form:?} x{substeps} after {ticks_before}");
                let error = (centre(&solver) - start - expected).length();
                check_at_most(&format!("{what}, way [m]"), error, 2e-6);
                let (p, _) = momenta(&solver);
                check_at_most(
                    &format!("{what}, momentum [N s]"),
                    (p - FORCE.as_dvec3() * t).length(),
                    1e-6,
                );
                // And no longer than that.
                for _ in 0..5 {
                    tick(&mut solver);
                }
                let (after, _) = momenta(&solver);
                check_at_most(&format!("{what}, after [N s]"), (after - p).length(), 1e-6);
            }
        }
    }
}

#[test]
fn a_force_and_drag_come_to_the_closed_form() {
    let c = 3.0;
    let material = Material { drag: c as f32, ..plain() };
    let (_, topology) = &topologies()[0];
    for ticks_before in [0, 2] {
        let settings = settings(StretchMethod::ImplicitThreads, 16);
        let mut solver = at_rest(topology, Vec3::ZERO, material, settings);
        for _ in 0..ticks_before {
            tick(&mut solver);
        }
        let m = mass(&solver);
        let start = centre(&solver);
        pushed(&mut solver, FORCE, 32);
        let t = 32.0 * f64::from(TICK);
        let way = (t - (1.0 - (-c * t).exp()) / c) / (m * c) * f64::from(FORCE.length());
        check("way [m]", (centre(&solver) - start).length(), way, 2e-4 * way);
    }
}

#[test]
fn an_impulse_gives_its_momentum_wherever_it_strikes() {
    for (what, topology) in topologies() {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            for (where_, on) in [
                ("all", PushOn::All),
                ("one", PushOn::Particle(17)),
                (
                    "ball",
                    PushOn::Within { centre: Vec3::new(0.1, 0.0, 0.1), radius: 0.3, falloff: 0.2 },
                ),
            ] {
                let mut solver = at_rest(&topology, Vec3::ZERO, plain(), settings(form, 30));
                let impulse = Vec3::new(0.002, 0.003, -0.001);
                let reached = solver.push(on, PushWith::Impulse(impulse)).unwrap();
                let what = format!("{what} {form:?} {where_}, {reached} particles");
                let moved = velocities(&solver).iter().filter(|v| **v != Vec3::ZERO).count();
                assert_eq!(moved, reached, "{what}");
                let (p, l) = momenta(&solver);
                let error = (p - impulse.as_dvec3()).length();
                check_at_most(&format!("{what}, given [N s]"), error, 1e-8);
                if let PushOn::Particle(particle) = on {
                    let arm = solver.position(particle as usize).as_dvec3();
                    let error = (l - arm.cross(impulse.as_dvec3())).length();
                    check_at_most(&format!("{what}, turned [N m s]"), error, 1e-8);
                    let v = solver.velocity(particle as usize) * solver.mass(particle as usize);
                    assert!(v.distance(impulse) < 1e-8, "J / m of its own mass");
                }
                for _ in 0..4 {
                    tick(&mut solver);
                }
                let (after, _) = momenta(&solver);
                let error = (after - impulse.as_dvec3()).length();
                check_at_most(&format!("{what}, kept [N s]"), error, 2e-7);
            }
        }
    }
}

#[test]
fn a_force_on_a_part_gives_its_momentum_in_every_integrator() {
    let (_, topology) = &topologies()[0];
    for integrator in [Integrator::Verlet, Integrator::Euler, Integrator::Midpoint] {
        let settings = Settings { integrator, ..settings(StretchMethod::ExplicitSprings, 40) };
        let soft = Material { thread_stiffness: 10.0, ..plain() };
        let mut solver = at_rest(topology, Vec3::ZERO, soft, settings);
        for _ in 0..6 {
            let ball =
                PushOn::Within { centre: centre(&solver).as_vec3(), radius: 0.2, falloff: 0.0 };
            solver.push(ball, PushWith::Force(FORCE * 0.1)).unwrap();
            solver.push(PushOn::Particle(0), PushWith::Force(FORCE * -0.1)).unwrap();
            solver.push(PushOn::Particle(5), PushWith::Force(Vec3::X * 0.01)).unwrap();
            tick(&mut solver);
        }
        let expected = DVec3::X * 0.01 * 6.0 * f64::from(TICK);
        let (p, _) = momenta(&solver);
        check_at_most(&format!("{integrator:?}, momentum [N s]"), (p - expected).length(), 1e-7);
        assert!(fastest(&solver) > 0.1, "they push it apart");
    }
}

#[test]
fn a_ball_reaches_what_is_in_it_and_fades_smoothly() {
    let (_, topology) = &topologies()[0];
    let mut solver = at_rest(topology, Vec3::new(3.0, 2.0, 1.0), plain(), Settings::default());
    let centre = solver.position(58);
    let on = PushOn::Within { centre, radius: 0.35, falloff: 0.35 };
    let reached = solver.push(on, PushWith::Velocity(Vec3::Y)).unwrap();
    let near = |p: Vec3| p.distance(centre) < 0.35;
    assert_eq!(reached, positions(&solver).into_iter().filter(|p| near(*p)).count());
    assert!((10..90).contains(&reached));
    assert_eq!(solver.velocity(58), Vec3::Y, "whole in the middle");
    let mut seen: Vec<_> = (0..solver.topology().particle_count())
        .map(|i| (solver.position(i).distance(centre), solver.velocity(i)))
        .collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    for pair in seen.windows(2) {
        let [(r0, v0), (r1, v1)] = pair else { unreachable!() };
        assert!(v1.y <= v0.y + 1e-6, "falls with the distance");
        // No steeper than the steepest of the cubic between 0 and 1: 1.5 over its length.
        assert!(v0.y - v1.y <= 1.5 / 0.35 * (r1 - r0) + 1e-5);
    }
    // A hard border, and a falloff that is deeper than the ball: whole in the middle still.
    for falloff in [0.0, 100.0] {
        let mut solver = at_rest(topology, Vec3::ZERO, plain(), Settings::default());
        let centre = solver.position(58);
        let on = PushOn::Within { centre, radius: 0.35, falloff };
        solver.push(on, PushWith::Velocity(Vec3::Y)).unwrap();
        assert_eq!(solver.velocity(58), Vec3::Y);
        let whole = velocities(&solver).iter().filter(|v| **v == Vec3::Y).count();
        assert_eq!(whole, if falloff == 0.0 { reached } else { 1 });
    }
    let nowhere = PushOn::Within { centre: Vec3::X * 99.0, radius: 1.0, falloff: 0.5 };
    let before = bits(&solver);
    assert_eq!(solver.push(nowhere, PushWith::Velocity(Vec3::Y)), Ok(0));
    assert_eq!(bits(&solver), before);
}

#[test]
fn what_is_held_does_not_move_and_its_pin_bears_its_share() {
    for (what, topology) in topologies() {
        let mut solver = at_rest(&topology, Vec3::ZERO, plain(), Settings::default());
        solver.set_pins(&[0, 1, 30]).unwrap();
        let held = [0, 1, 30].map(|i| solver.position(i));
        for on in [PushOn::All, PushOn::Particle(30)] {
            solver.push(on, PushWith::Force(FORCE)).unwrap();
            solver.push(on, PushWith::Impulse(FORCE * 0.01)).unwrap();
            solver.push(on, PushWith::Velocity(FORCE)).unwrap();
        }
        let whole = FORCE * (0.01 / mass(&solver)) as f32 + FORCE;
        let free = solver.velocity(40);
        assert!(free.distance(whole) < 1e-5, "{what}: {free} of {whole}");
        tick(&mut solver);
        assert_eq!([0, 1, 30].map(|i| solver.position(i)), held, "{what}");
        assert!(solver.position(40).distance(topology.rest_positions()[40]) > 1e-3, "{what}");
    }
}

/// A curtain on soft pins, its lower end pulled down: its pins carry its weight and the force.
#[test]
fn a_lasting_force_is_carried_as_a_weight_is() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let lattice = curtain(Vec2::ONE, 17, 17, MassLumping::Lumped);
        let material = Material { drag: 4.0, ..plain() };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings(form, 24));
        let stiffness = 50.0;
        let pins: Vec<_> = (0..17)
            .map(|particle| SoftPin { particle, stiffness, damping: 0.1 * stiffness })
            .collect();
        solver.set_soft_pins(&pins).unwrap();
        let targets: Vec<_> = positions(&solver)[..17].to_vec();
        let motions: Vec<_> = targets.iter().map(|&p| PinMotion::still(p)).collect();
        let input =
            StepInput { dt: TICK, gravity: GRAVITY, pins: &motions, ..StepInput::default() };
        for _ in 0..600 {
            for particle in 16 * 17..17 * 17 {
                let force = PushWith::Force(Vec3::NEG_Y * (3.0 / 17.0));
                solver.push(PushOn::Particle(particle), force).unwrap();
            }
            solver.tick(&input).unwrap();
        }
        let force: f64 =
            (0..17).map(|i| f64::from((targets[i].y - solver.position(i).y) * stiffness)).sum();
        check(&format!("{form:?}, force [N]"), force, 0.2 * 9.81 + 3.0, 5e-3);
    }
}

/// A hem pulled by a hundred times the cloth's weight stretches it as its threads give; the tethers make room.
#[test]
fn tethers_make_room_for_forces() {
    let lattice = curtain(Vec2::ONE, 17, 17, MassLumping::Lumped);
    let material = Material { drag: 4.0, thread_stiffness: 2000.0, ..plain() };
    let mut solver =
        at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ImplicitThreads, 24));
    solver.set_pins(&(0..17).collect::<Vec<_>>()).unwrap();
    let (force, weight) = (200.0_f64, 0.2 * 9.81);
    let pins = still(&solver);
    let input = StepInput { dt: TICK, gravity: GRAVITY, pins: &pins, ..StepInput::default() };
    for _ in 0..600 {
        for particle in 16 * 17..17 * 17 {
            // Border threads are half as strong.
            let part = if particle == 16 * 17 || particle == 17 * 17 - 1 { 0.5 } else { 1.0 };
            let force = PushWith::Force(Vec3::NEG_Y * (force as f32 * part / 16.0));
            solver.push(PushOn::Particle(particle), force).unwrap();
        }
        solver.tick(&input).unwrap();
    }
    let longer = -1.0 - f64::from(solver.position(16 * 17 + 8).y);
    check("longer by [m]", longer, (force + 0.5 * weight) / 2000.0, 3e-3);
}

#[test]
fn every_instruction_set_agrees_and_no_push_is_none() {
    for (what, topology) in topologies() {
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            let run = |isa: Isa, pushes: bool| {
                let mut solver = at_rest(&topology, Vec3::ZERO, plain(), settings(form, 9));
                solver.set_isa(isa);
                solver.set_pins(&[3]).unwrap();
                for _ in 0..12 {
                    if pushes {
                        let ball = PushOn::Within { centre: Vec3::ZERO, radius: 0.4, falloff: 0.3 };
                        solver.push(ball, PushWith::Force(FORCE)).unwrap();
                        solver.push(PushOn::All, PushWith::Impulse(FORCE * 1e-3)).unwrap();
                    } else {
                        let none = PushWith::Force(Vec3::ZERO);
                        solver.push(PushOn::All, none).unwrap();
                    }
                    tick(&mut solver);
                }
                bits(&solver)
            };
            let reference = run(Isa::Baseline, true);
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
                assert_eq!(run(isa, true), reference, "{what} {form:?} {isa:?}");
            }
            let mut alone = at_rest(&topology, Vec3::ZERO, plain(), settings(form, 9));
            alone.set_pins(&[3]).unwrap();
            for _ in 0..12 {
                tick(&mut alone);
            }
            assert_eq!(run(Isa::detect(), false), bits(&alone), "{what} {form:?}");
        }
    }
}

#[test]
fn what_cannot_be_pushed_is_refused_and_nothing_is() {
    let (_, topology) = &topologies()[0];
    let mut solver = at_rest(topology, Vec3::ZERO, plain(), Settings::default());
    tick(&mut solver);
    let before = bits(&solver);
    let count = solver.topology().particle_count();
    let ball = |centre: Vec3, radius: f32, falloff: f32| PushOn::Within { centre, radius, falloff };
    let parameter = |name: &str, problem: SolverError| matches!(problem, SolverError::Parameter(ParameterError { name: n, .. }) if n == name);
    let x = PushWith::Velocity(Vec3::X);
    let nowhere = SolverError::NoSuchParticle { particle: count, count };
    assert_eq!(solver.push(PushOn::Particle(count as u32), x), Err(nowhere));
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(parameter("radius", solver.push(ball(Vec3::ZERO, radius, 0.0), x).unwrap_err()));
    }
    for falloff in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(parameter("falloff", solver.push(ball(Vec3::ZERO, 1.0, falloff), x).unwrap_err()));
    }
    let refused = solver.push(ball(Vec3::splat(f32::NAN), 1.0, 0.0), x);
    assert_eq!(refused, Err(SolverError::Push { what: "centre" }));
    for bad in [Vec3::splat(f32::NAN), Vec3::X * f32::INFINITY, Vec3::Y * 1e9] {
        for (what, with) in [
            ("force", PushWith::Force(bad)),
            ("impulse", PushWith::Impulse(bad)),
            ("velocity", PushWith::Velocity(bad)),
        ] {
            let refused = solver.push(PushOn::All, with);
            assert_eq!(refused, Err(SolverError::Push { what }), "{bad}");
        }
    }
    // Good numbers, and too much for one light particle: no NaN comes of it.
    let heavy = solver.push(PushOn::Particle(0), PushWith::Force(Vec3::X * 9e6));
    assert_eq!(heavy, Err(SolverError::Push { what: "force" }));
    let fast = solver.push(PushOn::Particle(0), PushWith::Impulse(Vec3::X * 9e6));
    assert_eq!(fast, Err(SolverError::Push { what: "velocity" }));
    assert_eq!(bits(&solver), before);
    let mut other = at_rest(topology, Vec3::ZERO, plain(), Settings::default());
    tick(&mut other);
    tick(&mut other);
    tick(&mut solver);
    assert_eq!(bits(&solver), bits(&other), "nothing is left of it");
    // What is allowed is survived.
    for _ in 0..20 {
        solver.push(PushOn::All, PushWith::Force(Vec3::X * 1e7)).unwrap();
        solver.push(PushOn::All, PushWith::Velocity(Vec3::Y * 1e5)).unwrap();
        tick(&mut solver);
    }
    assert!(positions(&solver).iter().all(|p| p.is_finite()));
}

/// Closed forms: `x = F t^2 / 2 m` while a limited spring is far, `m g / k` where it is near enough.
#[test]
fn a_limited_soft_pin_pulls_with_its_limit_and_no_more() {
    let lattice = sheet(Vec2::splat(0.2), 2, 2, MassLumping::Lumped);
    let most = 0.05_f32;
    for substeps in [4, 32] {
        let mut solver = at_rest(
            &lattice,
            Vec3::ZERO,
            plain(),
            settings(StretchMethod::ImplicitThreads, substeps),
        );
        let m = f64::from(solver.mass(0));
        let soft = (0..4).map(|particle| SoftPin { particle, stiffness: 100.0, damping: 0.0 });
        solver.set_soft_pins(&soft.collect::<Vec<_>>()).unwrap();
        (0..4).for_each(|particle| solver.limit_soft_pin(particle, most));
        let start = positions(&solver);
        let pins: Vec<_> = start.iter().map(|&p| PinMotion::still(p + Vec3::X * 50.0)).collect();
        let input = StepInput { dt: TICK, pins: &pins, ..StepInput::default() };
        for tick in 1..=20 {
            solver.tick(&input).unwrap();
            let t = f64::from(TICK) * f64::from(tick);
            let way = f64::from(most) / m * t * t / 2.0;
            let measured = f64::from(solver.position(0).x - start[0].x);
            check(&format!("x{substeps}, way [m]"), measured, way, 1e-3 * way);
        }
    }
    // Four hands that hold it, and four that do not.
    let weight = 0.2 * 0.04 * 9.81;
    for (share, holds) in [(1.3, true), (0.7, false)] {
        let mut solver =
            at_rest(&lattice, Vec3::ZERO, plain(), settings(StretchMethod::ImplicitThreads, 8));
        let soft = (0..4).map(|particle| SoftPin { particle, stiffness: 100.0, damping: 0.5 });
        solver.set_soft_pins(&soft.collect::<Vec<_>>()).unwrap();
        (0..4).for_each(|particle| solver.limit_soft_pin(particle, share * weight / 4.0));
        let pins = still(&solver);
        let start = solver.position(0);
        let input = StepInput { dt: TICK, gravity: GRAVITY, pins: &pins, ..StepInput::default() };
        for _ in 0..128 {
            solver.tick(&input).unwrap();
        }
        let below = f64::from(start.y - solver.position(0).y);
        if holds {
            check("hangs below [m]", below, f64::from(weight) / 400.0, 1e-6);
        } else {
            check("falls by [m]", below, 0.3 * 9.81 * 2.0 * 2.0 / 2.0, 0.1);
        }
    }
}

/// Where threads pull on it, a spring at its limit is as heavy as its particle: it does not hold on.
#[test]
fn a_pulled_hem_bears_no_more_than_the_limit() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let lattice = curtain(Vec2::ONE, 9, 9, MassLumping::Lumped);
        let material = Material { drag: 3.0, ..plain() };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings(form, 24));
        // Held softly above, so that what the pins carry can be read.
        let (above, below) = (0..9, 72..81);
        let pins: Vec<_> = above
            .clone()
            .map(|particle| SoftPin { particle, stiffness: 100.0, damping: 5.0 })
            .chain(below.clone().map(|p| SoftPin { particle: p, stiffness: 1e4, damping: 5.0 }))
            .collect();
        solver.set_soft_pins(&pins).unwrap();
        below.clone().for_each(|particle| solver.limit_soft_pin(particle, 0.2));
        let start = positions(&solver);
        let motions: Vec<_> = above
            .map(|i| PinMotion::still(start[i as usize]))
            .chain(below.map(|i| PinMotion::still(start[i as usize] + Vec3::NEG_Y * 30.0)))
            .collect();
        let input = StepInput { dt: TICK, pins: &motions, ..StepInput::default() };
        for _ in 0..600 {
            solver.tick(&input).unwrap();
        }
        let carried: f64 =
            (0..9).map(|i| f64::from(start[i].y - solver.position(i).y) * 100.0).sum();
        check(&format!("{form:?}, carried [N]"), carried, 9.0 * 0.2, 0.02);
    }
}
