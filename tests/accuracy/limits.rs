//! The limit of stability. Found by bisection on the reference, and held to closed forms: `omega^2` of a
//! lumped sheet of structural springs is at most `4 ks / m` flat and `8 ks / m` folded onto a line, and to
//! eigenvalues of flat grids (`data/omega_max_grid.csv`). The solver's planned step lies at
//! `sqrt(margin)` of it, as the angle shows by which the stiffest motion turns in a substep.

use bevy::math::{DVec2, DVec3};
use bevy_drape::solver::{ClothSolver, StepInput, StretchMethod, Topology};

use super::modes::turn;
use super::reference::{FLEXION_CURVATURE, Fabric, Method, Model, Motion};
use super::scenes::*;
use crate::support::solver::*;

/// The longest step at which a slight disturbance of an equilibrium does not grow.
fn longest_stable_step(model: &Model, x: &[DVec3], guess: f64) -> f64 {
    let grows = |h: f64| {
        let mut motion = Motion::at_rest(x);
        let mut dice = Dice(9);
        for (x, held) in motion.x.iter_mut().zip(&model.held) {
            let off = dice.vector().as_dvec3() * 1e-9;
            *x += if *held { DVec3::ZERO } else { off };
        }
        for _ in 0..40 {
            model.steps(&mut motion, Method::Verlet, h, 100);
            if apart(&motion.x, x) > 1e-5 {
                return true;
            }
        }
        false
    };
    let (mut low, mut high) = (0.5 * guess, 2.0 * guess);
    assert!(!grows(low) && grows(high));
    for _ in 0..16 {
        let h = 0.5 * (low + high);
        if grows(h) { high = h } else { low = h }
    }
    low
}

/// All springs of a sheet along z, at their rest lengths: cells folded onto one.
fn folded(sheet: &Sheet) -> Vec<DVec3> {
    let columns = sheet.columns();
    (0..sheet.count())
        .map(|i| DVec3::Z * sheet.cell.x * ((i / columns + i % columns) % 2) as f64)
        .collect()
}

#[test]
fn bisection_finds_the_closed_forms_flat_and_folded() {
    let sheet = Sheet::square(7, 0.7);
    let fabric = Fabric { thread: 20.0, ..Fabric::default() };
    let model = sheet.model(&fabric, &[], DVec3::ZERO);
    let mass = 0.2 * 0.01;
    for (what, x, factor) in [("flat", sheet.rest(), 4.0), ("folded", folded(&sheet), 8.0)] {
        let expected = 2.0 / f64::sqrt(factor * 20.0 / mass);
        let found = longest_stable_step(&model, &x, expected);
        check(&format!("{what}: longest stable step [s]"), found, expected, 2e-4 * expected);
    }
}

#[test]
fn bisection_finds_the_grids_eigenvalues() {
    for row in table(include_str!("../data/omega_max_grid.csv")) {
        let [ks, kd, kb, symbol, closed, eigenvalue] =
            [0, 1, 2, 3, 4, 7].map(|i| row[i].parse::<f64>().unwrap());
        // The maximum of the Fourier symbol.
        let s = ks + kd;
        let d = kd + kb;
        let first = if kb <= s / 4.0 { 4.0 * s } else { 4.0 * kb + 2.0 * s + s * s / (4.0 * kb) };
        let second =
            if ks <= 4.0 * d { 2.0 * ks + 4.0 * d + ks * ks / (4.0 * d) } else { 4.0 * ks };
        check("closed form", first.max(second), symbol, 1e-8 * symbol);
        check("tabled closed form", closed, symbol, 1e-8 * symbol);
        // Eight a side, of masses and spacing one.
        let sheet = Sheet::square(7, 7.0);
        let fabric = Fabric {
            density: 64.0 / 49.0,
            thread: ks,
            shear: kd,
            rigidity: kb * FLEXION_CURVATURE.powi(2) / 8.0,
            flexion: true,
            equal: true,
            ..Fabric::default()
        };
        let model = sheet.model(&fabric, &[], DVec3::ZERO);
        let expected = 2.0 / eigenvalue.sqrt();
        let found = longest_stable_step(&model, &sheet.rest(), expected);
        let what = format!("ks {ks} kd {kd} kb {kb}: longest stable step [s]");
        check(&what, found, expected, 2e-4 * expected);
        assert!(found > 2.0 / symbol.sqrt(), "a finite grid lies below");
    }
}

/// What a pattern of signs comes to, of what it was at first, after each of some substeps.
fn swing(
    topology: impl Into<Topology>,
    fabric: &Fabric,
    x: &[DVec3],
    pattern: &dyn Fn(usize) -> DVec3,
) -> (ClothSolver, Vec<f64>) {
    let start: Vec<_> = (0..x.len()).map(|i| (x[i] + pattern(i) * 2e-4).as_vec3()).collect();
    let settings =
        settings_for(fabric, Method::Verlet, settings(StretchMethod::ExplicitSprings, 1));
    let mut solver = ClothSolver::new(topology, &start, material(fabric), settings).unwrap();
    let input = StepInput { dt: 1.0 / 512.0, ..StepInput::default() };
    let values = (0..60)
        .map(|_| {
            solver.tick(&input).unwrap();
            let places = places(&solver);
            (0..x.len()).map(|i| (places[i] - x[i]).dot(pattern(i))).sum::<f64>() / 2e-4
        })
        .collect();
    (solver, values)
}

#[test]
fn the_planned_step_is_at_its_margin_of_the_limit() {
    let sheet = Sheet { cells: [10, 7], cell: DVec2::splat(0.125) };
    let columns = sheet.columns();
    // Stiffer than the step carries: it is lowered to what is safe.
    let fabric = Fabric { thread: 1e4, ..Fabric::default() };
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    for (name, topology) in [
        ("lattice", Topology::from(sheet.lattice(lumping(&fabric)))),
        ("graph", Topology::from(sheet.graph(lumping(&fabric)))),
    ] {
        let along_weft = |i: usize| DVec3::X * sign(i % columns);
        let checkers = |i: usize| DVec3::Z * sign(i / columns + i % columns);
        let (_, flat) = swing(topology.clone(), &fabric, &sheet.rest(), &along_weft);
        let (solver, folded) = swing(topology, &fabric, &folded(&sheet), &checkers);
        let plan = *solver.plan();
        assert!(plan.clamped.thread && plan.margin > 0.88 && plan.margin <= 0.9001, "{plan}");
        let margin = f64::from(plan.margin);
        // sin^2(phi / 2) = omega^2 h^2 / 4.
        let turned = |values: &[f64]| (0.5 * turn(values).1).sin().powi(2);
        check(&format!("{name}, folded: omega^2 h^2 / 4"), turned(&folded), margin, 1e-4);
        check(&format!("{name}, flat: omega^2 h^2 / 4"), turned(&flat), margin / 2.0, 1e-4);
        check(&format!("{name}, folded: growth of a substep"), turn(&folded).0, 1.0, 1e-4);
        // And by bisection, with the constants that the plan left.
        let kept = Fabric { thread: f64::from(plan.thread_stiffness), ..fabric };
        let model = sheet.model(&kept, &[], DVec3::ZERO);
        let step = f64::from(plan.step);
        let limit = longest_stable_step(&model, &self::folded(&sheet), step);
        let what = format!("{name}: planned step over the longest stable one");
        check(&what, step / limit, margin.sqrt(), 5e-4);
    }
}

#[test]
fn the_plan_holds_with_shear_whatever_the_fold() {
    // The bound is the graph Laplacian's, (4 ks + 8 kd) / m; flat, 4 (ks + kd) / m are reached.
    let sheet = Sheet { cells: [10, 8], cell: DVec2::splat(0.125) };
    let fabric = Fabric { thread: 240.0, shear: 240.0, ..Fabric::default() };
    let base = settings(StretchMethod::ExplicitSprings, 8);
    let settings = settings_for(&fabric, Method::Verlet, base);
    let lattice = sheet.lattice(lumping(&fabric));
    let solver = at_rest(&lattice, bevy::math::Vec3::ZERO, material(&fabric), settings);
    let plan = *solver.plan();
    assert!(plan.clamped == Default::default() && plan.margin > 0.8, "{plan}");
    let model = sheet.model(&fabric, &[], DVec3::ZERO);
    let rest = sheet.rest();
    let fold = |p: &DVec3, twice: bool| {
        let z = if twice { (p.z - 0.5).abs() } else { p.z };
        DVec3::new((p.x - 0.625).abs(), 0.0, z)
    };
    let rows = sheet.columns();
    let zigzag = |i: usize| DVec3::new(0.0, 0.0, 0.125 * ((i / rows) % 2) as f64);
    let step = f64::from(plan.step);
    let margin = f64::from(plan.margin);
    for (what, x) in [
        ("flat", rest.clone()),
        ("folded", rest.iter().map(|p| fold(p, false)).collect()),
        ("folded twice", rest.iter().map(|p| fold(p, true)).collect()),
        (
            "rows folded onto two",
            (0..rest.len()).map(|i| rest[i].with_z(0.0) + zigzag(i)).collect(),
        ),
    ] {
        let limit = longest_stable_step(&model, &x, 1.2 * step);
        let what = format!("{what}: planned step over the longest stable");
        check_at_most(&what, step / limit, margin.sqrt() + 1e-3);
        if what.starts_with("flat") {
            check(&what, step / limit, (margin * 8.0 / 12.0).sqrt(), 0.04);
        }
    }
}
