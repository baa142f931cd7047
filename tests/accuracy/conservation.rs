//! What a free sheet keeps: momentum, angular momentum (all forces but relative damping act along springs),
//! and the symmetry of a symmetric scene. The reference keeps them to the rounding of `f64`; what the
//! solver keeps is in the tests of `solver`. Relative damping brakes a rigid spin at a rate of its own,
//! `sum(C l^2) / sum(m r^2)` over springs of length l and particles at r, and both are held to that.

use bevy::math::{DVec2, DVec3, Vec3};
use bevy_drape::solver::StretchMethod;

use super::reference::{Fabric, Method, Model, Motion};
use super::scenes::*;
use crate::support::solver::*;

fn momenta(model: &Model, motion: &Motion) -> (DVec3, DVec3) {
    (0..motion.x.len()).fold((DVec3::ZERO, DVec3::ZERO), |(linear, angular), i| {
        let p = motion.v[i] * model.mass[i];
        (linear + p, angular + motion.x[i].cross(p))
    })
}

#[test]
fn the_reference_keeps_both_momenta_to_rounding() {
    let sheet = Sheet { cells: [9, 6], cell: DVec2::splat(0.1) };
    let all =
        Fabric { thread: 40.0, shear: 10.0, rigidity: 1e-3, damping: 0.01, ..Fabric::default() };
    for (what, fabric) in [
        ("second differences", all),
        ("flexion springs", Fabric { flexion: true, ..all }),
        ("equal masses", Fabric { equal: true, ..all }),
        ("relative damping", Fabric { axial: false, ..all }),
    ] {
        let model = sheet.model(&fabric, &[], DVec3::ZERO);
        let mut motion = Motion::at_rest(&sheet.rest());
        let mut dice = Dice(7);
        for (x, v) in motion.x.iter_mut().zip(&mut motion.v) {
            *x += dice.vector().as_dvec3() * 0.02;
            *v = dice.vector().as_dvec3() + DVec3::new(0.5, 0.0, 1.0);
        }
        let before = momenta(&model, &motion);
        model.steps(&mut motion, Method::Verlet, 1.0 / 512.0, 512);
        let after = momenta(&model, &motion);
        let drift = (after.0 - before.0).length() / before.0.length();
        check_at_most(&format!("{what}: drift of momentum, relative"), drift, 1e-12);
        if fabric.axial {
            // The stored velocity is half a step old, but along it the lever does not change.
            let drift = (after.1 - before.1).length() / before.1.length();
            check_at_most(&format!("{what}: drift of angular momentum, relative"), drift, 1e-12);
        }
    }
}

#[test]
fn relative_damping_brakes_a_spin_at_its_closed_rate() {
    let sheet = Sheet { cells: [8, 8], cell: DVec2::splat(0.1) };
    let fabric =
        Fabric { thread: 400.0, shear: 100.0, damping: 2e-3, axial: false, ..Fabric::default() };
    let model = sheet.model(&fabric, &[], DVec3::ZERO);
    let rest: Vec<_> = sheet.rest().iter().map(|p| *p - DVec3::new(0.4, 0.0, 0.4)).collect();
    let dampers = model.dampers.iter();
    let braking: f64 =
        dampers.map(|d| d.constant * rest[d.ends[0]].distance_squared(rest[d.ends[1]])).sum();
    let inertia: f64 = rest.iter().zip(&model.mass).map(|(x, m)| m * x.length_squared()).sum();
    // Held together by springs: it spins slowly, and they hardly stretch.
    let turn = DVec3::Y * 0.5;
    let expected = (-braking / inertia).exp();
    let mut motion = Motion::at_rest(&rest);
    motion.v = rest.iter().map(|x| turn.cross(*x)).collect();
    let before = momenta(&model, &motion).1.y;
    model.steps(&mut motion, Method::Verlet, f64::from(TICK) / 16.0, 1024);
    let left = momenta(&model, &motion).1.y / before;
    check("reference: spin left after a second", left, expected, 2e-3 * expected);
    let settings =
        settings_for(&fabric, Method::Verlet, settings(StretchMethod::ExplicitSprings, 16));
    for graph in [false, true] {
        let topology: bevy_drape::solver::Topology = if graph {
            sheet.graph(lumping(&fabric)).into()
        } else {
            sheet.lattice(lumping(&fabric)).into()
        };
        let middle = Vec3::new(-0.4, 0.0, -0.4);
        let mut solver = at_rest(&topology, middle, material(&fabric), settings);
        for (i, x) in rest.iter().enumerate() {
            solver.set_velocity(i, turn.cross(*x).as_vec3()).unwrap();
        }
        let before = crate::support::solver::momenta(&solver).1.y;
        run(&mut solver, 64, Vec3::ZERO, &[]);
        assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
        let left_here = crate::support::solver::momenta(&solver).1.y / before;
        let what = format!("graph {graph}: spin left after a second");
        check(&what, left_here, expected, 2e-3 * expected);
        check("less the reference's", left_here - left, 0.0, 2e-5);
    }
}

#[test]
fn the_reference_keeps_symmetry_to_rounding() {
    let sheet = Sheet::square(10, 1.0);
    let fabric =
        Fabric { thread: 30.0, shear: 10.0, rigidity: 1e-4, damping: 2e-3, ..Fabric::default() };
    let model = sheet.model(&fabric, &[0, 10, 110, 120], GRAVITY.as_dvec3());
    let mut motion = Motion::at_rest(&sheet.rest());
    model.steps(&mut motion, Method::Verlet, 1.0 / 1024.0, 512);
    let mut worst = 0.0_f64;
    for r in 0..=10 {
        for c in 0..=10 {
            let p = motion.x[sheet.at(r, c)];
            let mirrored = motion.x[sheet.at(r, 10 - c)];
            worst = worst.max(mirrored.distance(DVec3::new(1.0 - p.x, p.y, p.z)));
            let exchanged = motion.x[sheet.at(c, r)];
            worst = worst.max(exchanged.distance(DVec3::new(p.z, p.y, p.x)));
        }
    }
    check_at_most("asymmetry after half a second [m]", worst, 1e-9);
}
