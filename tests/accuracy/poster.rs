//! One sheet at two resolutions under the same outside conditions, the force on it divided equally over its
//! points: every particle weighs the same (`Equal`), and every spring is whole. Held to the closed form of
//! the hanging strip.
//!
//! In a strip of N springs a column, C columns, each spring carries the points below it: the elongation is
//! `m g / k N (N + 1) / 2` with `m = rho L W / ((N + 1) C)` and `k = K W / (C - 1) / (L / N)`. It comes to
//! `(rho g L^2 / 2 K) (C - 1) / C`: the rows' weight is right at every resolution, and what differs is that
//! the columns at both borders are whole ones, `C / (C - 1)` as strong. Divided by area (`Lumped`), it is
//! `rho g L^2 / 2 K` at every resolution.

use bevy::math::{DVec2, Vec3};
use bevy_drape::solver::StretchMethod;

use super::reference::{Fabric, Method};
use super::scenes::*;
use crate::support::solver::*;

const EPS: f64 = 0.1;

/// Elongation of a square of 1 m, hung from its first row, by particles a side.
fn elongation(side: usize, equal: bool, form: StretchMethod, gravity: f64) -> f64 {
    let sheet = Sheet { cells: [side - 1; 2], cell: DVec2::splat(1.0 / (side - 1) as f64) };
    let fabric = Fabric { thread: 0.2 * gravity / EPS, drag: 14.0, equal, ..Fabric::default() };
    let settings = settings_for(&fabric, Method::Verlet, settings(form, side as u32));
    let lattice = sheet.lattice(lumping(&fabric));
    let mut solver = at_rest(&lattice, Vec3::NEG_Z * 0.5, material(&fabric), settings);
    solver.set_pins(&(0..side as u32).collect::<Vec<_>>()).unwrap();
    settle(&mut solver, Vec3::Z * gravity as f32, 1e-7, 448);
    assert_eq!(solver.plan().clamped, Default::default(), "{}", solver.plan());
    let x = places(&solver);
    let last = &x[side * (side - 1)..];
    let (low, high) = last.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.z), h.max(p.z)));
    check_at_most("difference between columns [m]", high - low, 2e-6);
    x[side * (side - 1) + side / 2].z - 0.5
}

#[test]
fn two_resolutions_of_equal_points_differ_by_the_closed_form() {
    let closed = |side: usize| 0.5 * EPS * (side - 1) as f64 / side as f64;
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        let [coarse, fine] = [16, 32].map(|side| {
            let measured = elongation(side, true, form, 10.0);
            let what = format!("{form:?}, {side} a side, force divided equally: elongation / L");
            check(&what, measured, closed(side), 3e-6);
            measured
        });
        let what = format!("{form:?}, 32 less 16 a side / L");
        check(&what, fine - coarse, closed(32) - closed(16), 4e-6);
        let [coarse, fine] = [16, 32].map(|side| {
            let measured = elongation(side, false, form, 10.0);
            let what = format!("{form:?}, {side} a side, divided by area: elongation / L");
            check(&what, measured, 0.5 * EPS, 3e-6);
            measured
        });
        check(&format!("{form:?}, 32 less 16 a side, by area / L"), fine - coarse, 0.0, 4e-6);
    }
}

#[test]
fn the_references_strip_is_the_closed_form() {
    // A strip of two columns cannot be told from a chain.
    for (side, equal) in [(8, true), (16, true), (8, false), (16, false)] {
        let sheet = Sheet { cells: [side - 1; 2], cell: DVec2::splat(1.0 / (side - 1) as f64) };
        let fabric = Fabric { thread: 0.2 * 10.0 / EPS, equal, ..Fabric::default() };
        let held: Vec<_> = (0..side).collect();
        let model = sheet.model(&fabric, &held, bevy::math::DVec3::Z * 10.0);
        let x = model.equilibrium(&sheet.rest());
        let measured = x[side * side - 1].z - 1.0;
        let part = if equal { (side - 1) as f64 / side as f64 } else { 1.0 };
        let what = format!("{side} a side, equal {equal}: elongation / L");
        check(&what, measured, 0.5 * EPS * part, 1e-12);
    }
}
