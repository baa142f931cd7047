//! A strip hung between two held ends. Held to the exact equilibrium of the discrete chain
//! (`data/catenary_discrete_*.csv`) and to the elastic catenary, whose formulas are here; the reference to
//! the tables' digits, the solver to the rounding of `f32`.

use bevy::math::{DVec3, Vec3};
use bevy_drape::solver::{ClothSolver, MassLumping, StretchMethod};

use super::reference::{Fabric, Method, Model, Spring};
use super::scenes::*;
use crate::support::solver::*;

/// For weight, length and spring constants of one: horizontal pull of an elastic chain of length 1 between
/// level supports `span` apart, and its sag.
pub fn elastic(span: f64, eps: f64) -> (f64, f64) {
    let v = 0.5;
    let reach = |h: f64| h * eps + 2.0 * h * (v / h).asinh();
    let (mut low, mut high) = (1e-9, 1e3);
    for _ in 0..200 {
        let h: f64 = 0.5 * (low + high);
        if reach(h) < span { low = h } else { high = h }
    }
    let h = 0.5 * (low + high);
    (h, v * v * eps / 2.0 + (h.hypot(v) - h))
}

/// A chain of `springs` springs, length, weight and gravity one; stiffness `1 / eps`.
fn chain(springs: usize, eps: f64) -> Model {
    let count = springs + 1;
    let n = springs as f64;
    let join = |i| Spring { ends: [i, i + 1], constant: n / eps, rest: 1.0 / n };
    Model {
        mass: vec![1.0 / n; count],
        held: (0..count).map(|i| i == 0 || i == springs).collect(),
        springs: (0..springs).map(join).collect(),
        gravity: DVec3::NEG_Y,
        ..Model::default()
    }
}

/// Somewhere between two supports: a broken line of the chain's length.
fn broken_line(count: usize, span: f64) -> Vec<DVec3> {
    let drop = (0.25 - 0.25 * span * span).max(1e-4).sqrt();
    (0..count)
        .map(|i| {
            let s = i as f64 / (count - 1) as f64;
            DVec3::new(0.0, -2.0 * drop * s.min(1.0 - s), s * span)
        })
        .collect()
}

fn equilibrium(springs: usize, span: f64, eps: f64) -> Vec<DVec3> {
    chain(springs, eps).equilibrium(&broken_line(springs + 1, span))
}

#[test]
fn the_reference_meets_the_discrete_table_and_the_elastic_catenary() {
    for row in table(include_str!("../data/catenary_discrete_sag.csv")) {
        let [span, eps, n, sag, continuum] =
            [0, 1, 2, 3, 4].map(|i| row[i].parse::<f64>().unwrap());
        if eps == 0.0 || n > 64.0 {
            continue;
        }
        let x = equilibrium(n as usize, span, eps);
        let what = format!("span {span}, eps {eps}, {n} springs");
        check(&format!("{what}: sag / L"), -x[n as usize / 2].y, sag, 2e-11);
        check(
            &format!("{what}: elastic catenary's sag / L"),
            elastic(span, eps).1,
            continuum,
            1e-10,
        );
    }
}

#[test]
fn the_chain_nears_the_catenary_as_the_square_of_its_cells_and_the_rigid_one_with_eps() {
    for eps in [1e-3, 0.1] {
        let error = |n: usize| -equilibrium(n, 0.8, eps)[n / 2].y / elastic(0.8, eps).1 - 1.0;
        check(&format!("eps {eps}, order"), (error(16) / error(64)).log2() / 2.0, 2.0, 0.02);
    }
    // 2 c sinh(D / 2 c) = L: c(cosh(D / 2 c) - 1) = 0.2654375 at D = 0.8 (the table's inextensible one).
    for (eps, relative) in [(1e-3, 1.26e-3), (1e-2, 1.25e-2), (1e-1, 0.114)] {
        let more = elastic(0.8, eps).1 / 0.265_437_5 - 1.0;
        check(
            &format!("eps {eps}: sag over the rigid one's, less 1"),
            more,
            relative,
            0.01 * relative,
        );
    }
}

/// Settled places of the middle line of a strip, in lengths.
fn solved(form: StretchMethod, springs: usize, span: f64, eps: f64, substeps: u32) -> Vec<DVec3> {
    let sheet = strip(springs, 1.0);
    // rho g L / k = eps.
    let fabric = Fabric { thread: 0.2 * 10.0 / eps, drag: 8.0, ..Fabric::default() };
    let line = broken_line(springs + 1, span);
    let start: Vec<_> = (0..sheet.count())
        .map(|i| {
            let across = (i % 3) as f64 * sheet.cell.x;
            (line[i / 3] + DVec3::X * across).as_vec3()
        })
        .collect();
    let settings = settings_for(&fabric, Method::Verlet, settings(form, substeps));
    let lattice = sheet.lattice(MassLumping::Lumped);
    let mut solver = ClothSolver::new(lattice, &start, material(&fabric), settings).unwrap();
    let last = (3 * springs) as u32;
    solver.set_pins(&[0, 1, 2, last, last + 1, last + 2]).unwrap();
    settle(&mut solver, Vec3::NEG_Y * 10.0, 1e-7, 512);
    assert!(!solver.plan().clamped.thread, "{}", solver.plan());
    places(&solver).into_iter().skip(1).step_by(3).collect()
}

#[test]
fn a_strip_of_springs_hangs_as_the_discrete_chain() {
    for (springs, substeps) in [(16, [40, 16]), (32, [80, 24])] {
        for span in [0.5, 0.8] {
            for (eps, substeps) in [(0.01, substeps[0]), (0.1, substeps[1])] {
                let exact = equilibrium(springs, span, eps);
                let settled = solved(StretchMethod::ExplicitSprings, springs, span, eps, substeps);
                let off = settled
                    .iter()
                    .zip(&exact)
                    .map(|(a, b)| (a.y - b.y).hypot(a.z - b.z))
                    .fold(0.0, f64::max);
                let what = format!("{springs} springs, span {span}, eps {eps}");
                check_at_most(&format!("{what}: from the exact chain / L"), off, 3e-6);
            }
        }
    }
}

#[test]
fn a_strip_of_threads_hangs_as_the_discrete_chain_but_for_the_substep() {
    // A thread is solved where gravity has moved it, in the directions it has there.
    for (span, eps) in [(0.5, 0.001), (0.8, 0.001), (0.8, 0.1)] {
        let exact = equilibrium(32, span, eps);
        let off = [4, 8, 16].map(|substeps| {
            let settled = solved(StretchMethod::ImplicitThreads, 32, span, eps, substeps);
            let away = |(a, b): (&DVec3, &DVec3)| (a.y - b.y).hypot(a.z - b.z);
            settled.iter().zip(&exact).map(away).fold(0.0, f64::max)
        });
        println!(
            "span {span}, eps {eps}: from the exact chain x4, x8, x16: {off}",
            off = list(&off)
        );
        check_at_most(
            &format!("span {span}, eps {eps}: from the exact chain x16 / L"),
            off[2],
            1e-4,
        );
    }
}

#[test]
fn nodes_lie_where_the_table_has_them() {
    // Rigid links, as stiff threads have them: eps = 1e-5 lets the sag grow by 1.3e-5 of itself.
    let rows = table(include_str!("../data/catenary_discrete_nodes.csv"));
    for springs in [16_usize, 32] {
        let of = |row: &&Vec<String>| {
            row[0].parse() == Ok(springs) && row[1] == "0.8" && row[2].parse() == Ok(0.0)
        };
        let nodes: Vec<_> = rows
            .iter()
            .filter(of)
            .map(|r| DVec3::new(0.0, r[5].parse().unwrap(), r[4].parse().unwrap()))
            .collect();
        if nodes.is_empty() {
            continue;
        }
        assert_eq!(nodes.len(), springs + 1);
        let exact = equilibrium(springs, 0.8, 1e-5);
        check_at_most("reference, from the rigid chain / L", apart(&exact, &nodes), 2e-5);
        let settled = solved(StretchMethod::ImplicitThreads, springs, 0.8, 1e-5, 16);
        let settled: Vec<_> = settled.iter().map(|p| DVec3::new(0.0, p.y, p.z)).collect();
        check_at_most("threads, from the rigid chain / L", apart(&settled, &nodes), 1e-4);
    }
}
