//! Real units: one physical sheet at 16, 32, 64 and 128 cells a side, as a lattice and as a mesh, of springs
//! and of threads, sags and droops alike, within the order of convergence. Held to the elastic catenary and
//! to the reference's equilibrium.

use bevy::math::{DVec2, DVec3, Vec3};
use bevy_drape::solver::{MassLumping, StretchMethod, Topology};

use super::catenary::elastic;
use super::reference::{Fabric, Method};
use super::scenes::*;
use crate::support::solver::*;

const FORMS: [StretchMethod; 2] = [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads];

fn topologies(sheet: &Sheet) -> [(&'static str, Topology); 2] {
    [
        ("lattice", sheet.lattice(MassLumping::Lumped).into()),
        ("graph", sheet.graph(MassLumping::Lumped).into()),
    ]
}

/// Sag of a square of 1 m held along two opposite sides, level and as far apart as it is long.
fn sag(
    topology: &Topology,
    sheet: &Sheet,
    fabric: &Fabric,
    form: StretchMethod,
    substeps: u32,
) -> f64 {
    let settings = settings_for(fabric, Method::Verlet, settings(form, substeps));
    let mut solver = at_rest(topology, Vec3::ZERO, material(fabric), settings);
    let (rows, columns) = (sheet.rows(), sheet.columns());
    let last = (rows - 1) * columns;
    let pins: Vec<_> = (0..columns).chain(last..last + columns).map(|i| i as u32).collect();
    solver.set_pins(&pins).unwrap();
    settle(&mut solver, GRAVITY, 1e-5, 256);
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    -f64::from(solver.position(sheet.at(rows / 2, columns / 2)).y)
}

#[test]
fn a_sheet_sags_alike_at_every_resolution() {
    // rho g L / K = 0.0981; threads alone make it a cylinder, the elastic catenary.
    let plain = Fabric { thread: 20.0, drag: 6.0, ..Fabric::default() };
    let exact = elastic(1.0, 0.2 * 9.81 / plain.thread).1;
    for form in FORMS {
        for kind in 0..2 {
            let mut errors = Vec::new();
            for cells in [16_usize, 32, 64, 128] {
                let sheet = Sheet::square(cells, 1.0);
                let (name, topology) = &topologies(&sheet)[kind];
                // A mesh's bound is Gershgorin's, and asks for more.
                let substeps = cells as u32 * 3 / 8;
                let substeps =
                    if form == StretchMethod::ImplicitThreads { 16 } else { substeps.max(6) };
                let measured = sag(topology, &sheet, &plain, form, substeps);
                let error = measured / exact - 1.0;
                // N springs sag as the catenary does but for their square.
                // Chains of a mesh are of 32 springs, one solved after the other: what that loses is as
                // the square of substeps and cells, `k h^2` to a particle's mass.
                let n = cells as f64;
                let cut = if form == StretchMethod::ImplicitThreads && kind == 1 && cells > 32 {
                    1.0
                } else {
                    0.0
                };
                let h = f64::from(TICK) / f64::from(substeps);
                let bound = 0.4 / (n * n) + 2e-5 + cut * 0.008 * 20.0 * h * h * n * n / 0.2;
                let what = format!("{name}, {form:?}, {cells} a side: sag / catenary's, less 1");
                check(&what, error, 0.0, bound);
                errors.push(error);
            }
            println!("{form:?}, kind {kind}: {errors}", errors = list(&errors));
        }
    }
}

#[test]
fn a_sheet_with_shear_sags_alike_at_every_resolution_and_converges_at_second_order() {
    let fabric = Fabric { thread: 20.0, shear: 5.0, drag: 6.0, ..Fabric::default() };
    for form in FORMS {
        let mut last = 0.0;
        for kind in 0..2 {
            let sags: Vec<_> = [16_usize, 32, 64]
                .iter()
                .map(|&cells| {
                    let sheet = Sheet::square(cells, 1.0);
                    let (_, topology) = &topologies(&sheet)[kind];
                    let substeps =
                        if form == StretchMethod::ImplicitThreads { 32 } else { cells as u32 / 2 };
                    sag(topology, &sheet, &fabric, form, substeps.max(8))
                })
                .collect();
            println!("{form:?}, kind {kind}, 16, 32, 64 a side: sag {sags} m", sags = list(&sags));
            check("16 a side over 64 a side", sags[0] / sags[2], 1.0, 5e-3);
            if kind == 1 {
                // Chains of a mesh carry nothing on, and are softer for it.
                check("mesh over lattice", sags[2] / last, 1.0, 2.5e-3);
            }
            last = sags[2];
            if form == StretchMethod::ExplicitSprings {
                let order = ((sags[0] - sags[1]) / (sags[1] - sags[2])).abs().log2();
                println!("order of the sag {order:.2}");
                assert!(order > 1.0, "of order {order}");
            }
        }
    }
}

/// Droop H/W of a strip of 1 m x 1/8 m that is clamped at one end, by cells along it.
fn droop(topology: &Topology, sheet: &Sheet, fabric: &Fabric, form: StretchMethod) -> f64 {
    let cell = sheet.cell.x;
    let bending = (32.0 * fabric.rigidity / fabric.density).sqrt() / (cell * cell);
    let threads = if form == StretchMethod::ExplicitSprings {
        (8.0 * fabric.thread / fabric.density).sqrt() / cell
    } else {
        0.0
    };
    let graph = matches!(topology, Topology::Graph(_));
    let more = if graph { 1.5 } else { 1.0 };
    let omega = more * bending.hypot(threads);
    let substeps = (f64::from(TICK) * omega / 1.85).ceil().max(16.0) as u32;
    let settings = settings_for(fabric, Method::Verlet, settings(form, substeps));
    let mut solver = at_rest(topology, Vec3::ZERO, material(fabric), settings);
    let columns = sheet.columns();
    solver.set_pins(&(0..2 * columns as u32).collect::<Vec<_>>()).unwrap();
    settle(&mut solver, GRAVITY, 1e-4, 256);
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    let tip = solver.position(sheet.at(sheet.rows() - 1, columns / 2)).as_dvec3();
    -tip.y / (tip.z - cell)
}

#[test]
fn a_strip_droops_alike_at_every_resolution() {
    // Gamma = 100; the threads stretch by half a percent.
    let fabric =
        Fabric { thread: 200.0, rigidity: 0.2 * 9.81 / 100.0, drag: 6.0, ..Fabric::default() };
    let strip = |cells: usize| Sheet {
        cells: [cells / 8, cells + 1],
        cell: DVec2::splat(1.0 / cells as f64),
    };
    // The same strip by the reference: its own equilibrium at each resolution, two cells wide.
    let equilibrium = |cells: usize, start: Option<Vec<DVec3>>| {
        let narrow = Sheet { cells: [2, cells + 1], cell: DVec2::splat(1.0 / cells as f64) };
        let model = narrow.model(&fabric, &[0, 1, 2, 3, 4, 5], GRAVITY.as_dvec3());
        let x = model.equilibrium(&start.unwrap_or_else(|| narrow.rest()));
        let tip = x[x.len() - 2];
        -tip.y / (tip.z - narrow.cell.x)
    };
    let references = [16, 32, 64].map(|cells| equilibrium(cells, None));
    let order = ((references[0] - references[1]) / (references[1] - references[2])).log2();
    println!("reference's droop at 16, 32, 64: {references}", references = list(&references));
    check("order of the reference's droop", order, 2.0, 0.2);
    let finest = references[2] + (references[2] - references[1]) / 3.0;
    for form in FORMS {
        for kind in 0..2 {
            let mut droops = Vec::new();
            for cells in [16_usize, 32, 64, 128] {
                // A mesh of 128 a side takes 30 s.
                if kind == 1 && cells == 128 {
                    continue;
                }
                let sheet = strip(cells);
                let (name, topology) = &topologies(&sheet)[kind];
                let measured = droop(topology, &sheet, &fabric, form);
                droops.push(measured);
                let error = measured / finest - 1.0;
                let coarse = references[0] / finest - 1.0;
                let bound = 1.6 * coarse * (16.0 / cells as f64).powi(2) + 1.5e-3;
                let what = format!("{name}, {form:?}, {cells} along: droop / the finest's, less 1");
                check(&what, error, 0.0, bound);
            }
            let order = ((droops[0] - droops[1]) / (droops[1] - droops[2])).abs().log2();
            println!("{form:?}, kind {kind}: {droops}, order {order:.2}", droops = list(&droops));
            if kind == 0 {
                check("order of the droop", order, 2.0, 0.25);
            }
        }
    }
}
