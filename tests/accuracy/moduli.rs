//! In-plane moduli of the lattice (`data/lattice_moduli.csv`): `C11 = ks + kd + 4 kb`, `C12 = C66 = kd`,
//! along the weave, on the bias and in shear. Measured as in a laboratory: a sheet in uniform strain is cut,
//! and the pull across the cut weighed, as what it sets in motion in a first short step; and a strip is
//! pulled by springs of known strength.

use bevy::math::{DMat2, DVec2, DVec3};
use bevy_drape::solver::{ClothSolver, SoftPin, StepInput, StretchMethod, Topology};

use super::reference::{FLEXION_CURVATURE, Fabric, Method};
use super::scenes::*;
use crate::support::solver::*;

struct Moduli {
    ks: f64,
    kd: f64,
    kb: f64,
    c11: f64,
    c12: f64,
    shear: f64,
    weave: f64,
    poisson: f64,
    bias: f64,
}

fn moduli() -> Vec<Moduli> {
    table(include_str!("../data/lattice_moduli.csv"))
        .iter()
        .map(|row| {
            let at = |i: usize| row[i].parse::<f64>().unwrap();
            let [ks, kd, kb, c11, c12, shear] = [0, 1, 2, 3, 4, 5].map(at);
            Moduli { ks, kd, kb, c11, c12, shear, weave: at(6), poisson: at(7), bias: at(8) }
        })
        .collect()
}

const CELLS: usize = 8;

/// Of springs `ks`, `kd` and, across two cells, `kb`.
fn fabric(moduli: &Moduli, cell: f64) -> Fabric {
    Fabric {
        thread: moduli.ks,
        shear: moduli.kd,
        rigidity: moduli.kb * cell.powi(4) * FLEXION_CURVATURE.powi(2) / 8.0,
        flexion: true,
        ..Fabric::default()
    }
}

/// Forces on all particles of a sheet in uniform strain `F = 1 + e`, by the solver: what a first substep,
/// half a kick, sets in motion.
pub fn solved(topology: Topology, fabric: &Fabric, places: &[DVec3]) -> Vec<DVec3> {
    let start: Vec<_> = places.iter().map(|p| p.as_vec3()).collect();
    let settings =
        settings_for(fabric, Method::Verlet, settings(StretchMethod::ExplicitSprings, 1));
    let mut solver = ClothSolver::new(topology, &start, material(fabric), settings).unwrap();
    let h = 1e-2_f32;
    solver.tick(&StepInput { dt: h, ..StepInput::default() }).unwrap();
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    (0..places.len())
        .map(|i| {
            let rate = f64::from(solver.mass(i)) / (0.5 * f64::from(h));
            solver.velocity(i).as_dvec3() * rate
        })
        .collect()
}

/// Stress for a small strain `e`: forces on the halves of a cut sheet over its width. Strained both
/// ways, so that what is of second order in the strain cancels.
fn stress(e: DMat2, forces: &dyn Fn(&[DVec3]) -> Vec<DVec3>) -> DMat2 {
    let sheet = Sheet::square(CELLS, 1.0);
    let centred: Vec<_> = sheet.rest().iter().map(|p| *p - DVec3::new(0.5, 0.0, 0.5)).collect();
    let small = 2e-3;
    let mut columns = [DVec2::ZERO; 2];
    for way in [small, -small] {
        let strained: Vec<_> = centred
            .iter()
            .map(|p| {
                let more = e * DVec2::new(p.x, p.z) * way;
                *p + DVec3::new(more.x, 0.0, more.y)
            })
            .collect();
        let force = forces(&strained);
        for (axis, column) in columns.iter_mut().enumerate() {
            for (f, p) in force.iter().zip(&centred) {
                let side = if axis == 0 { p.x } else { p.z };
                // Particles on the cut belong to neither half; forces inside a half cancel.
                if side.abs() > 1e-9 {
                    *column -= DVec2::new(f.x, f.z) * (0.5 * side.signum() / (2.0 * way));
                }
            }
        }
    }
    DMat2::from_cols(columns[0], columns[1])
}

fn stretch(angle: f64, across: f64) -> DMat2 {
    let (n, t) = (DVec2::from_angle(angle), DVec2::from_angle(angle).perp());
    let outer = |v: DVec2| DMat2::from_cols(v * v.x, v * v.y);
    outer(n) + outer(t) * across
}

fn pull(stress: DMat2, angle: f64) -> f64 {
    let n = DVec2::from_angle(angle);
    n.dot(stress * n)
}

fn hold_to_the_table(what: &str, tolerance: f64, of: &dyn Fn(&Moduli, DMat2) -> DMat2) {
    let quarter = std::f64::consts::FRAC_PI_4;
    for m in moduli() {
        let what = format!("{what}, ks {} kd {} kb {}", m.ks, m.kd, m.kb);
        let scale = tolerance * m.c11;
        let along = of(&m, stretch(0.0, 0.0));
        check(&format!("{what}: C11"), pull(along, 0.0), m.c11, scale);
        check(&format!("{what}: C12"), along.y_axis.y, m.c12, scale);
        let along = of(&m, stretch(2.0 * quarter, 0.0));
        check(&format!("{what}: C22"), along.y_axis.y, m.c11, scale);
        let sheared = of(&m, DMat2::from_cols(DVec2::Y * 0.5, DVec2::X * 0.5));
        check(&format!("{what}: G"), sheared.x_axis.y, m.shear, scale);
        let free = of(&m, stretch(0.0, -m.poisson));
        check(&format!("{what}: E along the weave"), pull(free, 0.0), m.weave, scale);
        check(&format!("{what}: across the weave"), free.y_axis.y, 0.0, scale);
        if m.kd > 0.0 {
            let poisson = m.bias / (2.0 * m.shear) - 1.0;
            let free = of(&m, stretch(quarter, -poisson));
            check(&format!("{what}: E on the bias"), pull(free, quarter), m.bias, scale);
            check(&format!("{what}: across the bias"), pull(free, 3.0 * quarter), 0.0, scale);
        }
    }
}

#[test]
fn the_references_moduli_are_the_tables() {
    let sheet = Sheet::square(CELLS, 1.0);
    hold_to_the_table("reference", 2e-5, &|m, e| {
        let model = sheet.model(&fabric(m, sheet.cell.x), &[], DVec3::ZERO);
        stress(e, &|x| model.forces(x))
    });
}

#[test]
fn the_lattices_moduli_are_the_tables() {
    let sheet = Sheet::square(CELLS, 1.0);
    hold_to_the_table("lattice", 2e-4, &|m, e| {
        let fabric = fabric(m, sheet.cell.x);
        stress(e, &|x| solved(sheet.lattice(lumping(&fabric)).into(), &fabric, x))
    });
}

#[test]
fn a_graphs_moduli_are_the_tables() {
    let sheet = Sheet::square(CELLS, 1.0);
    hold_to_the_table("graph", 2e-4, &|m, e| {
        // Flexion springs of a mesh are those across its edges, others than a lattice's.
        let fabric = Fabric { rigidity: 0.0, ..fabric(m, sheet.cell.x) };
        let graph = stress(e, &|x| solved(sheet.graph(lumping(&fabric)).into(), &fabric, x));
        let lattice_of_kb = sheet.model(&self::fabric(m, sheet.cell.x), &[], DVec3::ZERO);
        let lattice = sheet.model(&fabric, &[], DVec3::ZERO);
        let rest = stress(e, &|x| lattice_of_kb.forces(x)) - stress(e, &|x| lattice.forces(x));
        graph + rest
    });
}

/// Young's modulus and Poisson's ratio of a strip 1/4 as wide as long, pulled by 1e-4 of its length by
/// springs as strong as it is itself.
fn pulled(
    topology: Topology,
    sheet: &Sheet,
    fabric: &Fabric,
    form: StretchMethod,
    substeps: u32,
) -> (f64, f64) {
    let settings = settings_for(fabric, Method::Verlet, settings(form, substeps));
    // About the origin, where floats are finest.
    let (columns, rows) = (sheet.columns(), sheet.rows());
    let middle = DVec3::new(0.125, 0.0, 0.5);
    let mut solver = at_rest(&topology, -middle.as_vec3(), material(fabric), settings);
    let held: Vec<_> = (0..columns as u32).collect();
    solver.set_pins(&held).unwrap();
    let last = (columns * (rows - 1)) as u32;
    let strength = fabric.thread * 0.25 / columns as f64;
    let grips: Vec<_> = (last..last + columns as u32)
        .map(|particle| SoftPin { particle, stiffness: strength as f32, damping: 0.0 })
        .collect();
    solver.set_soft_pins(&grips).unwrap();
    let delta = 2e-4_f32;
    let mut pins = still(&solver);
    for pin in &mut pins[columns..] {
        pin.start.z += delta;
        pin.end.z += delta;
    }
    let input = StepInput { dt: TICK, pins: &pins, ..StepInput::default() };
    for _ in 0..384 {
        solver.tick(&input).unwrap();
    }
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    let x = places(&solver);
    let force: f64 = (0..columns)
        .map(|c| (f64::from(pins[columns + c].end.z) - x[last as usize + c].z) * strength)
        .sum();
    let at = |row: usize, column: usize| x[sheet.at(row, column)];
    let rest = sheet.rest();
    let length = |a: usize, b: usize| rest[a].distance(rest[b]);
    // Away from the grips.
    let (low, high) = (rows / 3, 2 * rows / 3);
    let (mut along, mut across) = (0.0, 0.0);
    for c in 0..columns {
        let l = length(sheet.at(low, c), sheet.at(high, c));
        along += ((at(high, c) - at(low, c)).length() / l - 1.0) / columns as f64;
    }
    for r in low..=high {
        let l = length(sheet.at(r, 0), sheet.at(r, columns - 1));
        across += ((at(r, columns - 1) - at(r, 0)).length() / l - 1.0) / (high - low + 1) as f64;
    }
    check("strain of the strip", along, 1e-4, 4e-5);
    (force / 0.25 / along, -across / along)
}

#[test]
fn a_strip_is_as_stiff_as_the_lattices_modulus() {
    let sheet = Sheet { cells: [10, 40], cell: DVec2::splat(0.025) };
    for m in moduli() {
        // Springs across two cells reach into the grips.
        if m.kd == 0.0 || m.kb > 0.0 {
            continue;
        }
        let unit = 20.0;
        let fabric =
            Fabric { thread: unit * m.ks, shear: unit * m.kd, drag: 14.0, ..Fabric::default() };
        for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
            for (what, topology) in [
                ("lattice", Topology::from(sheet.lattice(lumping(&fabric)))),
                ("graph", Topology::from(sheet.graph(lumping(&fabric)))),
            ] {
                let substeps = if form == StretchMethod::ImplicitThreads { 96 } else { 24 };
                let (young, poisson) = pulled(topology, &sheet, &fabric, form, substeps);
                let what = format!("{what} {form:?} kd {}", m.kd);
                check(&format!("{what}: E / ks"), young / unit, m.weave, 0.01 * m.weave);
                check(&format!("{what}: nu"), poisson, m.poisson, 0.02);
            }
        }
    }
}

#[test]
fn threads_are_as_stiff_whatever_their_substep() {
    // Shear, weft and warp are solved one after the other, each from where the last one left off. What one
    // takes back of the other's work made a strip softer by 0.2 `k h^2 / m`, were all of it done anew in each
    // substep: by 5.3 % at 12. Of what is carried on nothing is taken back.
    let sheet = Sheet { cells: [10, 40], cell: DVec2::splat(0.025) };
    let m = moduli().into_iter().find(|m| m.kd == 1.0 && m.kb == 0.0).unwrap();
    let fabric = Fabric { thread: 20.0, shear: 20.0, drag: 14.0, ..Fabric::default() };
    for substeps in [12, 24, 48] {
        let lattice = sheet.lattice(lumping(&fabric)).into();
        let stiffness =
            pulled(lattice, &sheet, &fabric, StretchMethod::ImplicitThreads, substeps).0 / 20.0;
        check(&format!("threads x{substeps}: E / ks"), stiffness / m.weave, 1.0, 4e-3);
    }
}
