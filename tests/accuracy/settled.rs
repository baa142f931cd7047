//! What a cloth comes to rest at does not depend on the step, on the passes of Provot's correction where
//! nothing passes its limit, or on how it was started: springs end at the equilibrium of the reference,
//! found by Newton's method, to rounding; threads at one that is off by their substep's square.

use bevy::math::{DVec3, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, MassLumping, Pose, Settings, StretchMethod, Topology,
};

use super::reference::{Fabric, Method};
use super::scenes::*;
use crate::support::solver::*;

const CELLS: usize = 12;

fn fabric() -> Fabric {
    Fabric { thread: 20.0, shear: 5.0, drag: 6.0, ..Fabric::default() }
}

fn frame(sheet: &Sheet) -> Vec<usize> {
    let (rows, columns) = (sheet.rows(), sheet.columns());
    let on = |i: &usize| {
        let (r, c) = (i / columns, i % columns);
        r == 0 || c == 0 || r + 1 == rows || c + 1 == columns
    };
    (0..sheet.count()).filter(on).collect()
}

/// A sheet held all round, at rest under gravity.
fn sagged(topology: Topology, form: StretchMethod, substeps: u32, passes: u32) -> Vec<DVec3> {
    let fabric = fabric();
    let settings = settings_for(&fabric, Method::Verlet, settings(form, substeps));
    let settings = Settings { provot_passes: passes, ..settings };
    let mut solver = at_rest(&topology, Vec3::ZERO, material(&fabric), settings);
    let pins: Vec<_> = frame(&Sheet::square(CELLS, 1.0)).iter().map(|&i| i as u32).collect();
    solver.set_pins(&pins).unwrap();
    settle(&mut solver, GRAVITY, 1e-7, 448);
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    places(&solver)
}

#[test]
fn springs_come_to_rest_at_the_references_equilibrium_whatever_the_step() {
    let sheet = Sheet::square(CELLS, 1.0);
    let model = sheet.model(&fabric(), &frame(&sheet), GRAVITY.as_dvec3());
    let exact = model.equilibrium(&sheet.rest());
    let lattice = sheet.lattice(MassLumping::Lumped);
    let graph = sheet.graph(MassLumping::Lumped);
    for (substeps, passes) in [(8, 1), (16, 1), (32, 1), (8, 2), (8, 4)] {
        for (what, topology) in
            [("lattice", Topology::from(lattice.clone())), ("graph", Topology::from(graph.clone()))]
        {
            let off =
                apart(&sagged(topology, StretchMethod::ExplicitSprings, substeps, passes), &exact);
            let what = format!("{what} x{substeps}, {passes} passes: from the equilibrium [m]");
            check_at_most(&what, off, 3e-6);
        }
    }
}

#[test]
fn threads_come_to_rest_as_near_as_the_square_of_their_substep() {
    let sheet = Sheet::square(CELLS, 1.0);
    let model = sheet.model(&fabric(), &frame(&sheet), GRAVITY.as_dvec3());
    let exact = model.equilibrium(&sheet.rest());
    let lattice = sheet.lattice(MassLumping::Lumped);
    let off = [4, 8, 16, 32].map(|substeps| {
        apart(&sagged(lattice.clone().into(), StretchMethod::ImplicitThreads, substeps, 1), &exact)
    });
    println!("threads x4, x8, x16, x32: from the equilibrium {off} m", off = list(&off));
    check("order", (off[0] / off[2]).log2() / 2.0, 2.0, 0.3);
    check_at_most("x32: from the equilibrium [m]", off[3], 1e-3);
}

#[test]
fn on_a_smooth_ball_too_rest_does_not_depend_on_the_step() {
    let sheet = Sheet::square(CELLS, 1.0);
    let fabric = fabric();
    let lattice = sheet.lattice(MassLumping::Lumped);
    let settled = |substeps: u32| {
        let settings = settings_for(
            &fabric,
            Method::Verlet,
            settings(StretchMethod::ExplicitSprings, substeps),
        );
        // What holds the particles is measured.
        let settings = Settings { edges: false, ..settings };
        let mut solver: ClothSolver = at_rest(&lattice, Vec3::ZERO, material(&fabric), settings);
        let pins: Vec<_> = frame(&sheet).iter().map(|&i| i as u32).collect();
        solver.set_pins(&pins).unwrap();
        let ball = Sphere::new(0.3);
        let pose = Pose::from_translation(Vec3::new(0.5, -0.35, 0.5));
        let report = run(&mut solver, 448, GRAVITY, &[Collider::new(&ball, pose)]);
        assert!(report.contact_count > 5, "{report:?}");
        let centre = DVec3::new(0.5, -0.35, 0.5);
        let least = places(&solver)
            .iter()
            .map(|p| p.distance(centre) - 0.305)
            .fold(f64::INFINITY, f64::min);
        check(&format!("x{substeps}: least gap beyond epsilon [m]"), least, 0.0, 2e-7);
        places(&solver)
    };
    let [coarse, middle, fine] = [8, 16, 32].map(settled);
    check_at_most("x8 from x32 [m]", apart(&coarse, &fine), 1e-5);
    check_at_most("x16 from x32 [m]", apart(&middle, &fine), 1e-5);
}
