//! The plan, held to the weighted graph Laplacian: built here from the springs' definition in 64
//! bits,
//! its largest eigenvalue by power iteration. No configuration of the sheet exceeds it.

use bevy::math::{DVec3, Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, Lattice, MassLumping, Material, PlanReason, Settings, StretchMethod, Stretching,
};
use std::sync::Arc;

use crate::support::solver::*;

/// Springs and hinges of a lattice as `(weights of particles, constant)`: the energy is
/// `constant / 2 |sum of weight x|^2`.
fn quadratic_terms(
    lattice: &Lattice,
    material: &Material,
    held: &[u32],
    equal: bool,
) -> Vec<(Vec<(usize, f64)>, f64)> {
    let (rows, columns) = (lattice.rows(), lattice.columns());
    let rest = lattice.rest_positions();
    let at = |r: usize, c: usize| r * columns + c;
    let length = |i: usize, j: usize| rest[i].as_dvec3().distance(rest[j].as_dvec3());
    let is_held = |i: usize| held.contains(&(i as u32));
    let mut terms = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            for along_row in [true, false] {
                let step = if along_row { 1 } else { columns };
                let (place, count) = if along_row { (c, columns) } else { (r, rows) };
                let (beside, others) = if along_row { (r, rows) } else { (c, columns) };
                let border = beside == 0 || beside + 1 == others;
                let across = if along_row { columns } else { 1 };
                let i = at(r, c);
                // Width of cloth across the thread, of a lattice of equal cells.
                let neighbour = if beside + 1 < others { i + across } else { i - across };
                let cell = length(i, neighbour);
                let width = if border && !equal { 0.5 * cell } else { cell };
                if place + 1 < count {
                    let l = length(i, i + step);
                    let k = f64::from(material.thread_stiffness) * width / l;
                    terms.push((vec![(i, -1.0), (i + step, 1.0)], k));
                }
                if place > 0 && place + 1 < count {
                    let l = length(i, i + step);
                    let clamp = is_held(i) && is_held(i - step) != is_held(i + step);
                    let k = f64::from(material.flexural_rigidity) * width / l.powi(3);
                    let k = if clamp { 2.0 * k } else { k };
                    terms.push((vec![(i - step, 1.0), (i, -2.0), (i + step, 1.0)], k));
                }
            }
            if r + 1 < rows && c + 1 < columns {
                let (a, b) = (length(at(r, c), at(r, c + 1)), length(at(r, c), at(r + 1, c)));
                let k = f64::from(material.shear_stiffness) * (a * a + b * b) / (2.0 * a * b);
                terms.push((vec![(at(r, c), -1.0), (at(r + 1, c + 1), 1.0)], k));
                terms.push((vec![(at(r, c + 1), -1.0), (at(r + 1, c), 1.0)], k));
            }
        }
    }
    terms
}

/// Largest `omega^2` of those terms with the solver's masses.
fn highest(solver: &ClothSolver, terms: &[(Vec<(usize, f64)>, f64)]) -> f64 {
    let count = solver.topology().particle_count();
    let mut inverse_mass: Vec<_> = (0..count).map(|i| 1.0 / f64::from(solver.mass(i))).collect();
    for &pin in solver.pins() {
        inverse_mass[pin as usize] = 0.0;
    }
    let mut dice = Dice(5);
    let mut x: Vec<_> = (0..count).map(|_| f64::from(dice.roll())).collect();
    let mut rate = 0.0;
    for _ in 0..3000 {
        let mut y = vec![0.0; count];
        for (weights, k) in terms {
            let turn: f64 = weights.iter().map(|&(i, w)| w * x[i]).sum();
            for &(i, w) in weights {
                y[i] += k * w * turn * inverse_mass[i];
            }
        }
        let norm = y.iter().map(|v| v * v).sum::<f64>().sqrt();
        rate = norm / x.iter().map(|v| v * v).sum::<f64>().sqrt();
        x = y.into_iter().map(|v| v / norm).collect();
    }
    rate
}

#[test]
fn the_plan_covers_the_graph_laplacian_on_every_lattice() {
    let materials = [
        ("structural", Material { thread_stiffness: 0.1, ..plain() }),
        ("shear", Material { thread_stiffness: 0.1, shear_stiffness: 0.1, ..plain() }),
        ("mostly shear", Material { thread_stiffness: 0.01, shear_stiffness: 0.1, ..plain() }),
        ("bending", Material { thread_stiffness: 0.0, flexural_rigidity: 1e-5, ..plain() }),
        (
            "all",
            Material {
                thread_stiffness: 0.1,
                shear_stiffness: 0.05,
                flexural_rigidity: 1e-4,
                ..plain()
            },
        ),
    ];
    let mut least = f64::INFINITY;
    let mut failures = Vec::new();
    for (rows, columns) in [(2, 2), (2, 6), (7, 2), (3, 3), (3, 8), (12, 13)] {
        for stretch in [1.0, 2.5] {
            for lumping in [MassLumping::Lumped, MassLumping::Equal] {
                let size = Vec2::new((columns - 1) as f32 * stretch, (rows - 1) as f32) * 0.1;
                let lattice = sheet(size, rows, columns, lumping);
                for (what, material) in materials {
                    for clamped in [false, true] {
                        let settings =
                            Settings { lumping, ..settings(StretchMethod::ExplicitSprings, 4) };
                        let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings);
                        if clamped && rows > 3 {
                            solver.set_pins(&(0..2 * columns as u32).collect::<Vec<_>>()).unwrap();
                        }
                        let equal = lumping == MassLumping::Equal;
                        let terms = quadratic_terms(&lattice, &material, solver.pins(), equal);
                        if terms.iter().all(|(_, k)| *k == 0.0) {
                            continue;
                        }
                        let plan = *solver.plan();
                        assert_eq!(plan.clamped, Default::default(), "{plan}");
                        let h = f64::from(plan.step);
                        let covered = f64::from(plan.margin) * 4.0 / (h * h);
                        let share = covered / highest(&solver, &terms).max(1e-30);
                        least = least.min(share);
                        if share < 0.999 {
                            failures.push(format!(
                                "{rows} x {columns} cells 1:{stretch} {lumping:?} {what}, clamped {clamped}: {share:.4}"
                            ));
                        }
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "the bound is too low:\n{}", failures.join("\n"));
    check("highest true rate over the plan's bound", 1.0 / least, 1.0, 1e-3);
}

#[test]
fn an_uneven_lattice_is_covered_too() {
    // Rows of growing height: Gershgorin's circles, held to the same eigenvalue.
    let (rows, columns) = (9, 7);
    let positions: Vec<_> = (0..rows)
        .flat_map(|r| (0..columns).map(move |c| (r, c)))
        .map(|(r, c)| Vec3::new(c as f32 * 0.1, 0.0, (r * r) as f32 * 0.02 + r as f32 * 0.05))
        .collect();
    let lattice = Arc::new(Lattice::new(rows, columns, &positions, MassLumping::Lumped).unwrap());
    let material = Material { thread_stiffness: 0.05, shear_stiffness: 0.02, ..plain() };
    let solver =
        at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ExplicitSprings, 4));
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    // Constants of the springs: width over length, where the width is half of both cells.
    let height = |r: usize| f64::from(positions[(r + 1) * columns].z - positions[r * columns].z);
    let at = |r: usize, c: usize| r * columns + c;
    let mut terms = Vec::new();
    for r in 0..rows {
        for c in 0..columns {
            if c + 1 < columns {
                let above = if r > 0 { height(r - 1) } else { 0.0 };
                let below = if r + 1 < rows { height(r) } else { 0.0 };
                terms.push((
                    vec![(at(r, c), -1.0), (at(r, c + 1), 1.0)],
                    0.05 * (above + below) / 2.0 / 0.1,
                ));
            }
            if r + 1 < rows {
                let width = if c == 0 || c + 1 == columns { 0.05 } else { 0.1 };
                terms.push((vec![(at(r, c), -1.0), (at(r + 1, c), 1.0)], 0.05 * width / height(r)));
            }
            if r + 1 < rows && c + 1 < columns {
                let (a, b) = (0.1, height(r));
                let k = 0.02 * (a * a + b * b) / (2.0 * a * b);
                terms.push((vec![(at(r, c), -1.0), (at(r + 1, c + 1), 1.0)], k));
                terms.push((vec![(at(r, c + 1), -1.0), (at(r + 1, c), 1.0)], k));
            }
        }
    }
    let h = f64::from(solver.plan().step);
    let share = f64::from(solver.plan().margin) * 4.0 / (h * h) / highest(&solver, &terms);
    assert!(share >= 0.999, "the bound covers only {share} of the highest rate");
    check_at_most("the bound over the highest rate", share, 2.0);
}

#[test]
fn the_largest_stiffness_that_is_kept_is_the_closed_form() {
    // Structural springs alone: omega^2 <= 8 k / (rho a^2), of which 0.9 of 4 / h^2 is used.
    for (lumping, n) in
        [(MassLumping::Lumped, 32), (MassLumping::Lumped, 64), (MassLumping::Equal, 33)]
    {
        let a = 1.0 / (n - 1) as f64;
        let mass = match lumping {
            MassLumping::Lumped => 0.2 * a * a,
            MassLumping::Equal => 0.2 / (n * n) as f64,
        };
        let h = 1.0 / 960.0;
        let expected = 0.9 * 4.0 / (h * h) * mass / 8.0;
        let lattice = sheet(Vec2::ONE, n, n, lumping);
        let settings = Settings { lumping, ..settings(StretchMethod::ExplicitSprings, 16) };
        let mut solver = at_rest(&lattice, Vec3::ZERO, plain(), settings);
        let (mut kept, mut clamped) = (0.0_f32, 1e4_f32);
        for _ in 0..40 {
            let k = 0.5 * (kept + clamped);
            solver.set_material(Material { thread_stiffness: k, ..plain() }).unwrap();
            let plan = *solver.plan_for(1.0 / 60.0).unwrap();
            assert!(plan.margin <= 0.9001, "{plan}");
            assert_eq!(plan.clamped.thread, plan.thread_stiffness < k, "{plan}");
            if plan.clamped.thread { clamped = k } else { kept = k }
        }
        check(
            &format!("{lumping:?} {n} a side, largest stiffness [N/m]"),
            kept.into(),
            expected,
            2e-3 * expected,
        );
        // The clamp of a stiffer one ends at the same.
        solver.set_material(Material { thread_stiffness: 1e6, ..plain() }).unwrap();
        let plan = *solver.plan_for(1.0 / 60.0).unwrap();
        check(
            "stiffness that it is clamped to [N/m]",
            plan.thread_stiffness.into(),
            expected,
            2e-3 * expected,
        );
        check("margin", plan.margin.into(), 0.9, 1e-3);
    }
}

#[test]
fn each_family_is_clamped_by_itself() {
    let lattice = sheet(Vec2::ONE, 33, 33, MassLumping::Lumped);
    let plan = |material| {
        *at_rest(&lattice, Vec3::ZERO, material, settings(StretchMethod::ExplicitSprings, 8)).plan()
    };
    let soft = Material { thread_stiffness: 1.0, ..plain() };
    assert_eq!(plan(soft).clamped, Default::default());
    let shear = plan(Material { shear_stiffness: 1e5, ..soft });
    assert!(shear.clamped.shear && !shear.clamped.bending && !shear.clamped.thread, "{shear}");
    let bend = plan(Material { flexural_rigidity: 10.0, ..soft });
    assert!(bend.clamped.bending && !bend.clamped.shear && !bend.clamped.thread, "{bend}");
    assert!(bend.flexural_rigidity < 10.0 && bend.flexural_rigidity > 0.0);
    let damping = plan(Material { damping: 10.0, ..soft });
    assert!(damping.clamped.damping && damping.damping < 10.0, "{damping}");
    for plan in [shear, bend, damping] {
        assert!(plan.margin <= 0.9001, "{plan}");
    }
}

#[test]
fn real_fabric_takes_threads_and_soft_cloth_springs() {
    for n in [32, 64, 128] {
        let lattice = sheet(Vec2::ONE, n, n, MassLumping::Lumped);
        for stiffness in [1000.0, 10_000.0] {
            let material =
                Material { thread_stiffness: stiffness, shear_stiffness: 30.0, ..plain() };
            let plan = *at_rest(&lattice, Vec3::ZERO, material, Settings::default()).plan();
            assert_eq!(plan.stretching, Stretching::ImplicitThreads, "{n}: {plan}");
            assert!(matches!(plan.reason, PlanReason::SpringsNeed(count) if count > 20), "{plan}");
            assert_eq!(plan.thread_stiffness, stiffness);
            assert!(plan.substeps <= 20 && !plan.clamped.thread && !plan.clamped.shear, "{plan}");
        }
    }
    let lattice = sheet(Vec2::ONE, 32, 32, MassLumping::Lumped);
    let material = Material { thread_stiffness: 10.0, ..plain() };
    let plan = *at_rest(&lattice, Vec3::ZERO, material, Settings::default()).plan();
    assert_eq!(
        (plan.stretching, plan.reason),
        (Stretching::ExplicitSprings, PlanReason::SpringsSuffice),
        "{plan}"
    );
    // 8 k / (rho a^2) = 3.84e5 1/s2 and 1/64 s: h <= 2 sqrt(0.9 / 3.84e5), so 6 substeps.
    assert_eq!(plan.substeps, 6, "{plan}");
    assert_eq!(plan.clamped, Default::default());
}

#[test]
fn cloth_that_its_springs_do_not_carry_takes_threads() {
    // A metre of 0.2 kg/m2 pulls with 1.962 N/m at its upper side, which 19.62 N/m carry at a strain of 0.1.
    let lattice = sheet(Vec2::ONE, 32, 32, MassLumping::Lumped);
    for (stiffness, form, reason) in [
        (19.7, Stretching::ExplicitSprings, PlanReason::SpringsSuffice),
        (19.5, Stretching::ImplicitThreads, PlanReason::SpringsGive),
    ] {
        let material = Material { thread_stiffness: stiffness, max_strain: 0.1, ..plain() };
        let plan = *at_rest(&lattice, Vec3::ZERO, material, Settings::default()).plan();
        assert_eq!((plan.stretching, plan.reason), (form, reason), "{stiffness} N/m: {plan}");
    }
}

/// Energy of springs and motion, in units of what it was at first; the most over 2 s.
fn most_energy(
    start: &[Vec3],
    lattice: &Arc<Lattice>,
    material: Material,
    settings: Settings,
) -> f64 {
    let terms =
        quadratic_terms(lattice, &Material { flexural_rigidity: 0.0, ..material }, &[], false);
    let mut solver = ClothSolver::new(lattice.clone(), start, material, settings).unwrap();
    let clamped = *solver.plan();
    let scale = f64::from(clamped.thread_stiffness / material.thread_stiffness);
    assert!(clamped.margin > 0.88, "the bound is not reached: {clamped}");
    let rest = lattice.rest_positions();
    let energy = |solver: &ClothSolver| {
        let mut stored = 0.0;
        let mut force = vec![DVec3::ZERO; rest.len()];
        for (ends, k) in &terms {
            let (i, j) = (ends[0].0, ends[1].0);
            let way = solver.position(j).as_dvec3() - solver.position(i).as_dvec3();
            let stretch = way.length() - rest[i].as_dvec3().distance(rest[j].as_dvec3());
            stored += 0.5 * k * scale * stretch * stretch;
            let pull = way.normalize_or_zero() * (k * scale * stretch);
            force[i] += pull;
            force[j] -= pull;
        }
        // The velocity is that of half a substep before, and the force leads to that of half a substep after. With
        // the product of both for the square of either, leapfrog keeps the energy of any linear spring exactly.
        let h = f64::from(clamped.step);
        let moving: f64 = (0..rest.len())
            .map(|i| {
                let before = solver.velocity(i).as_dvec3() * f64::from(solver.mass(i));
                0.5 * before.dot(before + force[i] * h) / f64::from(solver.mass(i))
            })
            .sum();
        stored + moving
    };
    let first = energy(&solver);
    let mut most = 0.0_f64;
    for _ in 0..128 {
        run(&mut solver, 1, Vec3::ZERO, &[]);
        most = most.max(energy(&solver) / first);
    }
    most
}

/// Nothing gains energy, in any of eight draws: in none, folded or thrown, does the most over 2 s come to more than
/// 0.88 of the first.
fn check_energy(
    what: &str,
    lattice: &Arc<Lattice>,
    place: impl Fn(usize, Vec3) -> Vec3,
    thrown: f32,
) {
    let material = Material { thread_stiffness: 1e4, ..plain() };
    let settings = Settings { max_speed: 1e5, ..settings(StretchMethod::ExplicitSprings, 8) };
    let mut worst = 0.0_f64;
    for seed in 11..19 {
        let mut dice = Dice(seed);
        let rest = lattice.rest_positions().iter().enumerate();
        let start: Vec<_> = rest.map(|(i, &p)| place(i, p) + dice.vector() * thrown).collect();
        worst = worst.max(most_energy(&start, lattice, material, settings));
    }
    check_at_most(&format!("{what}, most energy over the first"), worst, 1.0);
}

#[test]
fn folded_and_random_sheets_do_not_blow_up_at_the_planned_step() {
    let lattice = sheet(Vec2::ONE, 20, 20, MassLumping::Lumped);
    // Thrown by 0.4 of a cell and more, collapsed springs do heat the sheet at this step: the speed limit is
    // there for that.
    check_energy("folded", &lattice, |_, p| Vec3::new(p.x.abs(), 0.0, p.z), 1e-4);
    let twice = |_, p: Vec3| Vec3::new(p.x.abs(), 0.0, p.z.abs());
    check_energy("folded twice", &lattice, twice, 1e-4);
    check_energy("random", &lattice, |_, p| p, 0.01);
}

#[test]
fn a_folded_strip_two_particles_wide_does_not_blow_up() {
    let lattice = sheet(Vec2::new(1.0, 0.05), 2, 21, MassLumping::Lumped);
    // Every cell folded onto one line of cells: each spring lies along z.
    let folded = |i: usize, _| Vec3::Z * 0.05 * ((i / 21 + i % 21) % 2) as f32;
    check_energy("strip", &lattice, folded, 1e-4);
}
