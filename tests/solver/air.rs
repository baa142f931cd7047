//! Drag and lift, held to closed forms (terminal speed, the hyperbolic tangent of a fall under drag, a
//! constant wind on a cloth that has no mass to speak of), to what air can never do (give energy,
//! carry a cloth past the wind, prefer a direction of space), and to bit equality.

use bevy::math::{DVec3, Quat, Vec2, Vec3, primitives::Cuboid, primitives::Sphere};
use bevy_drape::solver::{
    Air, ClothSolver, Gusts, Isa, MassLumping, Material, Pose, Settings, SolverError, StepInput,
    StretchMethod, Wind, WindFlow, WindShape, Zone,
};

use crate::support::solver::*;

/// Takes ticks in a wind, with the pins where they are.
fn blow(solver: &mut ClothSolver, ticks: usize, gravity: Vec3, wind: Wind<'_>) {
    let pins = still(solver);
    for _ in 0..ticks {
        let input = StepInput {
            dt: TICK,
            gravity,
            pins: &pins,
            colliders: &[],
            wind,
            ..StepInput::default()
        };
        solver.tick(&input).unwrap();
    }
}

fn steady(velocity: Vec3) -> Wind<'static> {
    Wind { velocity, ..Wind::default() }
}

fn drag_alone() -> Air {
    Air { lift: 0.0, ..Air::default() }
}

/// A flat sheet in the xz plane, in air.
fn flat(air: Air, material: Material, form: StretchMethod, substeps: u32) -> ClothSolver {
    let lattice = sheet(Vec2::new(1.2, 0.8), 9, 20, MassLumping::Lumped);
    let settings = Settings { max_speed: 1e5, ..settings(form, substeps) };
    let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
    solver.set_air(Some(air)).unwrap();
    solver
}

/// Points in all directions with numbers of no particular size.
fn crumpled(air: Air, material: Material, seed: u64, speed: f32) -> ClothSolver {
    let lattice = sheet(Vec2::new(1.2, 0.8), 9, 20, MassLumping::Lumped);
    let mut dice = Dice(seed);
    let start: Vec<_> = lattice.rest_positions().iter().map(|&p| p + dice.vector() * 0.2).collect();
    let settings = Settings {
        max_speed: 1e5,
        provot_passes: 0,
        ..settings(StretchMethod::ExplicitSprings, 1)
    };
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    for i in 0..180 {
        solver.set_velocity(i, dice.vector() * speed).unwrap();
    }
    solver.set_air(Some(air)).unwrap();
    solver
}

/// Nothing but air acts.
fn loose(area_density: f32) -> Material {
    Material { area_density, thread_stiffness: 0.0, ..plain() }
}

#[test]
fn a_level_sheet_falls_at_its_terminal_speed() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for substeps in [1, 4, 16] {
            // With more lift than drag a level fall is unstable, as that of paper is.
            for lift in [0.0, 0.6] {
                for (area_density, drag) in [(0.2, 1.2), (0.05, 0.7)] {
                    let air = Air { drag, lift, ..Air::default() };
                    let material = Material { area_density, thread_stiffness: 50.0, ..plain() };
                    let mut solver = flat(air, material, form, substeps);
                    run(&mut solver, 200, GRAVITY, &[]);
                    let exact =
                        (2.0 * f64::from(area_density) * 9.81 / (1.225 * f64::from(drag))).sqrt();
                    let fall = mean_velocity(&solver);
                    let what = format!("{form:?} x{substeps}, lift {lift}");
                    check(&format!("{what}, terminal speed [m/s]"), -fall.y, exact, 1e-3 * exact);
                    check(&format!("{what}, sideways [m/s]"), fall.x.hypot(fall.z), 0.0, 1e-3);
                }
            }
        }
    }
}

#[test]
fn the_way_to_the_terminal_speed_is_of_second_order() {
    // v = v_t tanh(g t / v_t), and the way is v_t^2 / g ln cosh(g t / v_t).
    let exact_speed = (2.0 * 0.2 * 9.81 / (1.225 * 1.2_f64)).sqrt();
    let t = 16.0 / 64.0;
    let exact = exact_speed * exact_speed / 9.81 * (9.81 * t / exact_speed).cosh().ln();
    let error = |substeps| {
        let mut solver = flat(drag_alone(), plain(), StretchMethod::ImplicitThreads, substeps);
        run(&mut solver, 16, GRAVITY, &[]);
        (-f64::from(solver.position(90).y) - exact).abs()
    };
    let (coarse, fine) = (error(1), error(4));
    check_at_most("way at one substep, error [m]", coarse, 2e-3);
    check("order of the way", (coarse / fine).log2() / 2.0, 2.0, 0.15);
}

#[test]
fn a_wind_from_all_sides_does_not_depend_on_the_substeps() {
    let air = Air { lift: 0.9, ..Air::default() };
    let end = |substeps| {
        let lattice = curtain(Vec2::ONE, 13, 13, MassLumping::Lumped);
        let material = Material { shear_stiffness: 30.0, damping: 0.02, ..plain() };
        let mut solver = at_rest(
            &lattice,
            Vec3::ZERO,
            material,
            settings(StretchMethod::ExplicitSprings, substeps),
        );
        solver.set_pins(&[0, 6, 12]).unwrap();
        solver.set_air(Some(air)).unwrap();
        blow(&mut solver, 16, GRAVITY, steady(Vec3::new(2.0, 1.0, 5.0)));
        positions(&solver)
    };
    let (coarse, middle, fine) = (end(32), end(64), end(512));
    let start = curtain(Vec2::ONE, 13, 13, MassLumping::Lumped);
    let moved = farthest(&fine, start.rest_positions());
    assert!(moved > 0.2, "nothing happened: {moved}");
    let (first, second) = (farthest(&coarse, &fine), farthest(&middle, &fine));
    // First order, with a small constant: the matrix of drag and lift is that of the last kick.
    check_at_most("32 substeps against 512 [m]", first, 1e-3);
    check_at_most("and 64, in parts of that", second / first, 0.5);
}

#[test]
fn still_air_leaves_what_rests_alone() {
    for lift in [0.0, 1.0] {
        let mut solver = crumpled(Air { lift, ..Air::default() }, loose(0.1), 5, 0.0);
        let before = positions(&solver);
        run(&mut solver, 20, Vec3::ZERO, &[]);
        assert!(positions(&solver) == before && fastest(&solver) == 0.0);
    }
}

#[test]
fn a_wind_along_the_sheet_does_nothing() {
    for lift in [0.0, 1.0] {
        let air = Air { lift, ..Air::default() };
        let mut solver = flat(air, plain(), StretchMethod::ImplicitThreads, 2);
        let before = bits(&solver);
        blow(&mut solver, 20, Vec3::ZERO, steady(Vec3::new(7.0, 0.0, -3.0)));
        assert_eq!(bits(&solver), before);
    }
}

/// Force of the wind on a flat sheet at rest [N], from the momentum that it takes up in an instant.
fn force_on(turned: Quat, air: Air, wind: Vec3) -> DVec3 {
    let lattice = sheet(Vec2::new(1.2, 0.8), 9, 20, MassLumping::Lumped);
    let start: Vec<_> = lattice.rest_positions().iter().map(|&p| turned * p).collect();
    let settings = settings(StretchMethod::ExplicitSprings, 1);
    let mut solver = ClothSolver::new(lattice, &start, loose(1.0), settings).unwrap();
    solver.set_air(Some(air)).unwrap();
    let dt = 1e-4;
    let input = StepInput { dt, wind: steady(wind), ..StepInput::default() };
    solver.tick(&input).unwrap();
    // The first kick lasts half a step.
    momenta(&solver).0 / (0.5 * f64::from(dt))
}

#[test]
fn drag_is_along_the_wind_and_lift_across_it() {
    let (size, rho, wind) = (0.96, 1.225, Vec3::new(0.0, 0.0, 10.0));
    let lift_and_drag = Air { drag: 1.2, lift: 0.9, ..Air::default() };
    for angle in [0.1_f32, 0.5, 1.0, 1.4] {
        // The sheet faces up; turned about x its normal leans into the wind or out of it.
        let turned = Quat::from_rotation_x(angle);
        let seen = f64::from(angle.sin());
        let pressure = 0.5 * rho * 100.0 * size * seen;
        let drag = force_on(turned, drag_alone(), wind);
        check("drag along the wind [N]", drag.z, 1.2 * pressure, 1e-3 * pressure);
        check("and across it [N]", drag.x.hypot(drag.y), 0.0, 1e-4);
        let both = force_on(turned, lift_and_drag, wind);
        check("drag beside lift [N]", both.z, 1.2 * pressure, 1e-3 * pressure);
        // The wind pushes on the side that it meets: the lee side of this one looks up.
        let across = 0.9 * pressure * f64::from(angle.cos());
        check("lift [N]", both.y, across, 2e-3 * pressure);
        check("and aside [N]", both.x, 0.0, 1e-4);
        // The two sides of a cloth are alike.
        let back =
            force_on(turned * Quat::from_rotation_x(std::f32::consts::PI), lift_and_drag, wind);
        check("the other side out [N]", back.distance(both), 0.0, 1e-3);
    }
}

#[test]
fn a_turned_scene_turns_alike() {
    let turn = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.4, -1.1, 2.3);
    let run_one = |turn: Quat| {
        let lattice = sheet(Vec2::new(1.2, 0.8), 9, 20, MassLumping::Lumped);
        let mut dice = Dice(9);
        let start: Vec<_> =
            lattice.rest_positions().iter().map(|&p| turn * (p + dice.vector() * 0.02)).collect();
        let settings = settings(StretchMethod::ExplicitSprings, 8);
        let material = Material { thread_stiffness: 20.0, ..plain() };
        let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
        solver.set_air(Some(Air { lift: 0.9, ..Air::default() })).unwrap();
        blow(&mut solver, 16, turn * GRAVITY, steady(turn * Vec3::new(3.0, 2.0, -1.0)));
        positions(&solver).into_iter().map(|p| turn.inverse() * p).collect::<Vec<_>>()
    };
    let (plain, turned) = (run_one(Quat::IDENTITY), run_one(turn));
    check_at_most("a scene and its like, turned [m]", farthest(&plain, &turned), 2e-4);
}

#[test]
fn the_wind_carries_a_free_sheet_along_and_no_faster() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let mut solver = flat(drag_alone(), plain(), form, 4);
        let wind = Vec3::new(0.0, 6.0, 0.0);
        let mut last = 0.0;
        for _ in 0..300 {
            blow(&mut solver, 1, Vec3::ZERO, steady(wind));
            let speed = mean_velocity(&solver).y;
            assert!(speed >= last - 1e-4 && speed <= 6.0 + 1e-4, "{last} to {speed}");
            last = speed;
        }
        // v = W - W / (1 + c W t), with c = rho C_d / (2 sigma).
        let c = 1.225 * 1.2 / (2.0 * 0.2);
        let exact = 6.0 - 6.0 / (1.0 + c * 6.0 * 300.0 / 64.0);
        check("speed after 300 ticks [m/s]", last, exact, 2e-3);
    }
}

/// Kinetic energy relative to a wind [J].
fn energy(solver: &ClothSolver, wind: Vec3) -> f64 {
    (0..solver.topology().particle_count())
        .map(|i| {
            let u = solver.velocity(i).as_dvec3() - wind.as_dvec3();
            0.5 * f64::from(solver.mass(i)) * u.length_squared()
        })
        .sum()
}

#[test]
fn air_takes_energy_and_never_gives_any() {
    let wind = Vec3::new(1e3, -200.0, 30.0);
    for (drag, lift) in [(1.2, 0.0), (1.2, 0.6), (0.5, 2.0), (0.0, 3.0)] {
        let air = Air { drag, lift, ..Air::default() };
        // From a heavy cloth in a breeze to a film in a storm, a substep a tick.
        for (area_density, speed, wind) in [
            (1.0, 1.0, Vec3::ZERO),
            (0.1, 30.0, Vec3::ZERO),
            (1e-3, 300.0, Vec3::ZERO),
            (1e-3, 50.0, wind),
        ] {
            for seed in 1..4 {
                let mut solver = crumpled(air, loose(area_density), seed, speed);
                let first = energy(&solver, wind);
                let mut last = first;
                for tick in 0..60 {
                    blow(&mut solver, 1, Vec3::ZERO, steady(wind));
                    let now = energy(&solver, wind);
                    assert!(
                        now <= last * (1.0 + 1e-5) + 1e-9 * first,
                        "drag {drag}, lift {lift}, {area_density} kg/m2, tick {tick}: {last} to {now}"
                    );
                    last = now;
                }
                assert!(drag == 0.0 || last < 0.9 * first, "{first} to {last}");
            }
        }
    }
}

#[test]
fn a_film_in_a_storm_stays_whole() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for lift in [0.0, 0.6, 2.0] {
            for pinned in [false, true] {
                let air = Air { lift, ..Air::default() };
                let material = Material { area_density: 1e-3, max_strain: 0.1, ..plain() };
                let lattice = curtain(Vec2::ONE, 17, 17, MassLumping::Lumped);
                let settings = Settings { max_speed: 1e5, ..settings(form, 1) };
                let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
                if pinned {
                    solver.set_pins(&[0, 16]).unwrap();
                }
                solver.set_air(Some(air)).unwrap();
                let wind = Vec3::new(600.0, 0.0, 800.0);
                for _ in 0..200 {
                    blow(&mut solver, 1, GRAVITY, steady(wind));
                    let what = format!("{form:?}, lift {lift}, pinned {pinned}: speed [m/s]");
                    assert!(fastest(&solver) <= 1.05e3, "{what}: {}", fastest(&solver));
                }
                let mut after = solver.clone();
                blow(&mut after, 200, GRAVITY, steady(Vec3::ZERO));
                let what =
                    format!("{form:?}, lift {lift}, pinned {pinned}: strain after the storm");
                // One substep a tick leaves it soft, springs the more, and what lifts it lets it swing on.
                let most = if form == StretchMethod::ExplicitSprings { 1.0 } else { 0.5 };
                check_at_most(&what, after.strain().max.into(), most);
                if !pinned && lift <= air.drag {
                    let carried = mean_velocity(&solver).dot(wind.as_dvec3()) / 1e3;
                    check("carried by the storm [m/s]", carried, 1e3, 20.0);
                }
            }
        }
    }
}

#[test]
fn without_air_the_wind_is_nothing() {
    let scene = |air: Option<Air>, wind: Wind<'_>| {
        let lattice = curtain(Vec2::ONE, 9, 9, MassLumping::Lumped);
        let mut solver =
            at_rest(&lattice, Vec3::ZERO, plain(), settings(StretchMethod::ImplicitThreads, 4));
        solver.set_pins(&[0, 8]).unwrap();
        solver.set_air(air).unwrap();
        blow(&mut solver, 20, GRAVITY, wind);
        bits(&solver)
    };
    let storm = steady(Vec3::new(f32::NAN, 5.0, 0.0));
    let calm = scene(None, Wind::default());
    assert_eq!(calm, scene(None, storm), "not even a wind that is none");
    let thin = Air { density: 0.0, ..Air::default() };
    let error = farthest_bits(&calm, &scene(Some(thin), steady(Vec3::Z * 9.0)));
    check_at_most("in air of no density, apart [m]", error, 1e-5);
}

fn farthest_bits(a: &[[u32; 6]], b: &[[u32; 6]]) -> f64 {
    let place = |bits: &[u32; 6]| Vec3::from_array([0, 1, 2].map(|i| f32::from_bits(bits[i])));
    let places = |of: &[[u32; 6]]| of.iter().map(place).collect::<Vec<_>>();
    farthest(&places(a), &places(b))
}

#[test]
fn mirror_images_stay_mirror_images_to_the_bit() {
    const SIDE: usize = 21;
    let lattice = sheet(Vec2::ONE, SIDE, SIDE, MassLumping::Lumped);
    let material = Material { thread_stiffness: 30.0, shear_stiffness: 10.0, ..plain() };
    let mut solver =
        at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ExplicitSprings, 16));
    let n = SIDE as u32;
    solver.set_pins(&[0, n - 1, n * (n - 1), n * n - 1]).unwrap();
    solver.set_air(Some(Air { lift: 2.0, ..Air::default() })).unwrap();
    blow(&mut solver, 32, GRAVITY, steady(Vec3::Y * 7.0));
    let at = |r: usize, c: usize| solver.position(r * SIDE + c);
    assert!(at(SIDE / 2, SIDE / 2).y > 0.05, "nothing happened");
    for r in 0..SIDE {
        for c in 0..SIDE {
            let p = at(r, c);
            assert_eq!(at(r, SIDE - 1 - c), Vec3::new(-p.x, p.y, p.z), "across, {r} {c}");
            assert_eq!(at(SIDE - 1 - r, c), Vec3::new(p.x, p.y, -p.z), "along, {r} {c}");
            let turned = at(c, r);
            let exchanged = turned.distance(Vec3::new(p.z, p.y, p.x));
            assert!(exchanged < 1e-5, "rows and columns, {r} {c}: {exchanged}");
        }
    }
}

fn gusts(seed: u64) -> Gusts {
    Gusts { strength: 5.0, scale: 0.4, period: 0.3, seed }
}

fn zones() -> [Zone; 3] {
    let ball = Zone {
        shape: WindShape::from(Sphere::new(0.6)),
        flow: WindFlow::Radial(4.0),
        falloff: 0.2,
        pose: Pose::from_translation(Vec3::new(-0.3, 0.1, 0.2)),
    };
    let tilted = Pose { rotation: Quat::from_rotation_z(0.7), scale: 1.5, ..ball.pose };
    let block = WindShape::from(Cuboid::new(0.5, 0.4, 0.8));
    let cone = WindShape::from(bevy::math::primitives::Cone { radius: 0.5, height: 1.2 });
    let flow = WindFlow::Directional(Vec3::new(1.0, -6.0, 2.0));
    [ball, Zone { shape: block, flow, pose: tilted, ..ball }, Zone { shape: cone, ..ball }]
}

#[test]
fn every_form_and_instruction_set_gives_the_same_bits() {
    let zones = zones();
    let run_one = |isa: Isa, staged: bool, seed: u64, lift: f32| {
        let lattice = sheet(Vec2::new(1.3, 0.9), 19, 37, MassLumping::Lumped);
        let mut solver =
            at_rest(&lattice, Vec3::Y * 0.3, plain(), settings(StretchMethod::ImplicitThreads, 4));
        solver.set_pins(&[0, 36]).unwrap();
        solver.set_air(Some(Air { lift, ..Air::default() })).unwrap();
        solver.set_isa(isa);
        let pins = still(&solver);
        for tick in 0..24 {
            let time = f64::from(tick) / 64.0;
            let wind = Wind {
                velocity: Vec3::new(1.0, 0.5, 3.0),
                gusts: gusts(seed),
                time,
                zones: &zones,
            };
            let input = StepInput {
                dt: TICK,
                gravity: GRAVITY,
                pins: &pins,
                colliders: &[],
                wind,
                ..StepInput::default()
            };
            if staged {
                for _ in 0..solver.begin_tick(&input).unwrap() {
                    solver.accumulate_forces(&input);
                    solver.integrate(&input);
                    solver.correct();
                    solver.collide(&input);
                }
                solver.end_tick().unwrap();
            } else {
                solver.tick(&input).unwrap();
            }
        }
        bits(&solver)
    };
    for lift in [0.0, 0.6, 2.0] {
        let first = run_one(Isa::Baseline, false, 1, lift);
        assert_eq!(first, run_one(Isa::Baseline, false, 1, lift), "twice");
        assert_eq!(first, run_one(Isa::Baseline, true, 1, lift), "by stages");
        assert!(first != run_one(Isa::Baseline, false, 2, lift), "another seed");
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            assert!(first == run_one(isa, false, 1, lift), "{isa:?}");
        }
    }
}

#[test]
fn a_far_zone_changes_no_bit() {
    let scene = |zones: &[Zone]| {
        let mut solver = flat(Air::default(), plain(), StretchMethod::ImplicitThreads, 4);
        let wind = Wind { velocity: Vec3::Y, zones, ..Wind::default() };
        blow(&mut solver, 8, GRAVITY, wind);
        bits(&solver)
    };
    let [near, ..] = zones();
    let far = Zone { pose: Pose::from_translation(Vec3::X * 50.0), ..near };
    assert_eq!(scene(&[]), scene(&[far]));
    assert!(scene(&[]) != scene(&[far, near]));
}

#[test]
fn what_a_zone_blows_is_what_a_cloth_feels() {
    // A zone that holds the whole cloth is a uniform wind.
    let scene = |wind: Wind<'_>| {
        let mut solver = flat(Air::default(), plain(), StretchMethod::ImplicitThreads, 4);
        blow(&mut solver, 24, GRAVITY, wind);
        positions(&solver)
    };
    let velocity = Vec3::new(1.0, 4.0, -2.0);
    let turned = Quat::from_rotation_y(0.8);
    let zone = Zone {
        shape: WindShape::from(Cuboid::new(50.0, 50.0, 50.0)),
        flow: WindFlow::Directional(turned.inverse() * velocity),
        falloff: 1.0,
        pose: Pose { rotation: turned, ..Pose::IDENTITY },
    };
    let zones = [zone];
    let apart =
        farthest(&scene(steady(velocity)), &scene(Wind { zones: &zones, ..Wind::default() }));
    check_at_most("in a zone and in a wind, apart [m]", apart, 1e-5);
}

#[test]
fn a_scrap_goes_with_the_gust_of_its_place() {
    for place in [Vec3::ZERO, Vec3::new(1000.25, 5.0, -77.5)] {
        let lattice = sheet(Vec2::splat(0.01), 3, 3, MassLumping::Lumped);
        let gusts = Gusts { strength: 5.0, scale: 3.0, period: 1e3, seed: 4 };
        for time in [10.0, 4e3, 1e6] {
            let settings = settings(StretchMethod::ExplicitSprings, 16);
            let mut solver = at_rest(&lattice, place, loose(1e-5), settings);
            solver.set_air(Some(drag_alone())).unwrap();
            let wind = Wind { gusts, time, ..Wind::default() };
            blow(&mut solver, 4, Vec3::ZERO, wind);
            let here = wind.at(solver.position(4)).as_dvec3();
            assert!(here.length() > 0.1);
            let apart = mean_velocity(&solver).distance(here);
            check_at_most("a scrap and the gust, apart [m/s]", apart, 0.05 * here.length());
        }
    }
}

#[test]
fn tethers_do_not_hold_what_the_wind_stretches() {
    // A sail of a fiftieth of its load in weight: by its threads alone, and with tethers.
    let sail = |tethers: bool| {
        let lattice = curtain(Vec2::ONE, 17, 17, MassLumping::Lumped);
        let material = Material {
            area_density: 0.1,
            thread_stiffness: 2000.0,
            shear_stiffness: 200.0,
            damping: 0.05,
            max_strain: 0.5,
            ..plain()
        };
        let settings = Settings { tethers, ..settings(StretchMethod::ImplicitThreads, 32) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
        solver.set_pins(&[0, 16, 272, 288]).unwrap();
        solver.set_air(Some(drag_alone())).unwrap();
        blow(&mut solver, 200, GRAVITY, steady(Vec3::Z * 12.0));
        (solver.position(144).z, solver.strain().p99)
    };
    let ((free, strain), (tethered, _)) = (sail(false), sail(true));
    assert!(strain > 0.03, "the wind hardly stretches it: {strain}");
    check("depth of the sail [m]", tethered.into(), free.into(), 0.01 * f64::from(free));
}

#[test]
fn bad_air_and_wind_are_refused() {
    let mut solver = flat(Air::default(), plain(), StretchMethod::ImplicitThreads, 1);
    type Set = fn(&mut Air, f32);
    let fields: [(&str, Set); 3] = [
        ("density", |air, v| air.density = v),
        ("drag", |air, v| air.drag = v),
        ("lift", |air, v| air.lift = v),
    ];
    for (name, set) in fields {
        for value in [-1.0, 1e6, f32::NAN, f32::INFINITY] {
            let mut air = Air::default();
            set(&mut air, value);
            assert_eq!(solver.set_air(Some(air)).unwrap_err().name, name);
            assert_eq!(solver.air(), Some(&Air::default()));
        }
    }
    let refused = |wind: Wind<'_>| {
        let mut solver = solver.clone();
        let before = format!("{solver:?}");
        let error = solver.tick(&StepInput { dt: TICK, wind, ..StepInput::default() }).unwrap_err();
        assert_eq!(format!("{solver:?}"), before, "{error}");
        assert!(solver.tick(&StepInput { dt: TICK, ..StepInput::default() }).is_ok());
        error
    };
    let name = |error: SolverError| match error {
        SolverError::Wind(problem) => problem.name,
        other => panic!("{other}"),
    };
    for bad in [f32::NAN, f32::INFINITY, 2e5] {
        assert_eq!(name(refused(steady(Vec3::new(0.0, 0.0, bad)))), "velocity");
        for gusts in [
            Gusts { strength: bad, ..gusts(0) },
            Gusts { scale: bad * 10.0, ..gusts(0) },
            Gusts { period: bad * 10.0, ..gusts(0) },
            Gusts { scale: 0.0, ..gusts(0) },
            Gusts { period: -1.0, ..gusts(0) },
        ] {
            let error = refused(Wind { gusts, ..Wind::default() });
            assert!(["strength", "scale", "period"].contains(&name(error)));
        }
        assert_eq!(name(refused(Wind { time: f64::NAN, ..Wind::default() })), "time");
        let [good, ..] = zones();
        for zone in [
            Zone { flow: WindFlow::Radial(bad), ..good },
            Zone { flow: WindFlow::Directional(Vec3::Y * bad), ..good },
            Zone { falloff: -1.0, ..good },
            Zone { falloff: f32::NAN, ..good },
            Zone { shape: WindShape::from(Sphere::new(bad * 100.0)), ..good },
            Zone { shape: WindShape::from(Sphere::new(0.0)), ..good },
            Zone { pose: Pose { scale: -1.0, ..good.pose }, ..good },
            Zone { pose: Pose::from_translation(Vec3::NAN), ..good },
        ] {
            let zones = [good, zone];
            assert_eq!(refused(Wind { zones: &zones, ..Wind::default() }), SolverError::Zone(1));
        }
    }
}
