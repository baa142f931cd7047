//! Where a cloth is, and which way it and its grid are turned, must not matter: free fall is exact
//! (`x0 + g t^2 / 2`) but for rounding whatever the height and the substeps, and a scene that is turned moves
//! as the scene did.

use bevy::math::{DVec3, Quat, Vec3};
use bevy_drape::solver::{ClothSolver, Lattice, MassLumping, PinMotion, StepInput, StretchMethod};

use super::reference::{Fabric, Method, Motion};
use super::scenes::*;
use crate::support::solver::*;

#[test]
fn the_reference_falls_by_the_closed_form() {
    let sheet = Sheet::square(4, 0.5);
    let fabric =
        Fabric { thread: 20.0, shear: 5.0, rigidity: 1e-4, damping: 0.01, ..Fabric::default() };
    for axial in [false, true] {
        let model = sheet.model(&Fabric { axial, ..fabric }, &[], GRAVITY.as_dvec3());
        let mut motion = Motion::at_rest(&sheet.rest());
        model.steps(&mut motion, Method::Verlet, 1.0 / 960.0, 960);
        let fallen: Vec<_> = sheet.rest().iter().map(|p| *p + GRAVITY.as_dvec3() * 0.5).collect();
        check_at_most("reference, from the closed form [m]", apart(&motion.x, &fallen), 1e-12);
    }
}

#[test]
fn a_fall_of_a_second_is_as_good_at_a_kilometre_and_15360_substeps() {
    let sheet = Sheet::square(8, 0.5);
    for height in [0.0, 10.0, 100.0, 1000.0] {
        for substeps in [16, 64, 256] {
            let material = material(&Fabric { thread: 5.0, ..Fabric::default() });
            let settings = settings(StretchMethod::ExplicitSprings, substeps);
            let lattice = sheet.lattice(MassLumping::Lumped);
            let mut solver = at_rest(&lattice, Vec3::Y * height as f32, material, settings);
            let input = StepInput { dt: 1.0 / 60.0, gravity: GRAVITY, ..StepInput::default() };
            (0..60).for_each(|_| {
                solver.tick(&input).unwrap();
            });
            let mut worst = 0.0_f64;
            for (i, rest) in sheet.rest().iter().enumerate() {
                let here = solver.origin().as_dvec3() + solver.local_position(i).as_dvec3();
                let exact = *rest + DVec3::Y * height + GRAVITY.as_dvec3() * 0.5;
                worst = worst.max(here.distance(exact));
            }
            // Each substep rounds a displacement that grows and a place of some metres.
            let rounding = 2e-6 * f64::from(substeps).max(4.0);
            let what = format!("from {height} m, {} steps a second", 60 * substeps);
            check_at_most(&format!("{what}: from the closed form [m]"), worst, rounding);
        }
    }
}

fn fabric() -> Fabric {
    Fabric { thread: 40.0, shear: 10.0, rigidity: 1e-3, damping: 0.01, ..Fabric::default() }
}

/// Half a second of a sheet that falls, held at two corners, in a world turned by `turn`; places are
/// turned back.
fn turned(turn: Quat, form: StretchMethod, graph: bool) -> Vec<DVec3> {
    let sheet = Sheet::square(12, 1.0);
    let fabric = fabric();
    let settings = settings_for(&fabric, Method::Verlet, settings(form, 16));
    let middle = Vec3::new(0.5, 0.0, 0.5);
    let rest: Vec<_> = sheet.rest().iter().map(|p| turn * (p.as_vec3() - middle)).collect();
    let lattice = Lattice::new(13, 13, &rest, MassLumping::Lumped).unwrap();
    let mut solver = if graph {
        ClothSolver::new(sheet.graph(MassLumping::Lumped), &rest, material(&fabric), settings)
    } else {
        ClothSolver::new(std::sync::Arc::new(lattice), &rest, material(&fabric), settings)
    }
    .unwrap();
    solver.set_pins(&[0, 12]).unwrap();
    let pins: Vec<PinMotion> = still(&solver);
    let gravity = turn * GRAVITY;
    let input = StepInput { dt: TICK, gravity, pins: &pins, ..StepInput::default() };
    (0..32).for_each(|_| {
        solver.tick(&input).unwrap();
    });
    let back = turn.as_dquat().inverse();
    places(&solver).into_iter().map(|p| back * p).collect()
}

#[test]
fn a_turned_scene_moves_as_the_scene_did() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for graph in [false, true] {
            let upright = turned(Quat::IDENTITY, form, graph);
            assert!(upright.iter().any(|p| p.y < -0.3), "nothing happened");
            for turn in [
                Quat::from_rotation_y(0.5),
                Quat::from_rotation_y(std::f32::consts::FRAC_PI_4),
                Quat::from_axis_angle(Vec3::new(1.0, -2.0, 0.5).normalize(), 2.0),
            ] {
                // f32 has the turned places and gravity to 6e-8 alone.
                let off = apart(&turned(turn, form, graph), &upright);
                let what = format!("{form:?}, graph {graph}: turned, from the upright one [m]");
                check_at_most(&what, off, 2e-5);
            }
        }
    }
}

/// The same with rows and columns exchanged: half a second, held at the particles of two corners.
fn exchanged(exchange: bool, form: StretchMethod, substeps: u32) -> Vec<DVec3> {
    let sheet = Sheet { cells: [12, 9], cell: bevy::math::DVec2::splat(0.08) };
    let (rows, columns) = (sheet.rows(), sheet.columns());
    let place = |i: usize| {
        if exchange { (i % rows) * columns + i / rows } else { i }
    };
    let rest = sheet.rest();
    let positions: Vec<_> = (0..sheet.count()).map(|i| rest[place(i)].as_vec3()).collect();
    let (r, c) = if exchange { (columns, rows) } else { (rows, columns) };
    let lattice = Lattice::new(r, c, &positions, MassLumping::Lumped).unwrap();
    let fabric = fabric();
    let settings = settings_for(&fabric, Method::Verlet, settings(form, substeps));
    let mut solver =
        ClothSolver::new(std::sync::Arc::new(lattice), &positions, material(&fabric), settings)
            .unwrap();
    let held = [0, rows * columns - 1];
    let pins: Vec<_> =
        (0..sheet.count()).filter(|&i| held.contains(&place(i))).map(|i| i as u32).collect();
    solver.set_pins(&pins).unwrap();
    run(&mut solver, 32, GRAVITY, &[]);
    let found = places(&solver);
    let mut out = vec![DVec3::ZERO; found.len()];
    (0..found.len()).for_each(|i| out[place(i)] = found[i]);
    out
}

#[test]
fn rows_and_columns_are_alike() {
    let springs = |exchange| exchanged(exchange, StretchMethod::ExplicitSprings, 16);
    let off = apart(&springs(false), &springs(true));
    check_at_most("springs, rows and columns exchanged [m]", off, 2e-5);
    // Weft threads are solved before warp: what that makes is of first order in the substep.
    let off = [8, 32].map(|substeps| {
        let threads = |exchange| exchanged(exchange, StretchMethod::ImplicitThreads, substeps);
        apart(&threads(false), &threads(true))
    });
    println!("threads, rows and columns exchanged, x8 and x32: {off} m", off = list(&off));
    check_at_most("threads, rows and columns exchanged x32 [m]", off[1], 1e-2);
    check_at_most("of four times the substeps, relative", off[1] / off[0], 0.5);
}
