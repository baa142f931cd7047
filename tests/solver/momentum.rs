//! Conservation in a free sheet: every force and correction acts between particles, so that linear
//! momentum stays; all but relative damping act along the line between them, so that angular
//! momentum
//! stays too. Corrections act at the substep's end, which costs a spin as they begin.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    Bending, ClothSolver, DampingForm, MassLumping, Material, Settings, StretchMethod,
};

use crate::support::solver::*;

/// A crumpled sheet whose particles go every way.
fn crumpled(material: Material, settings: Settings) -> ClothSolver {
    let lattice = sheet(Vec2::new(0.9, 0.6), 9, 12, settings.lumping);
    let mut dice = Dice(7);
    let start: Vec<_> =
        lattice.rest_positions().iter().map(|&p| p + dice.vector() * 0.02).collect();
    let mut solver = ClothSolver::new(lattice, &start, material, settings).unwrap();
    for i in 0..start.len() {
        solver.set_velocity(i, dice.vector() + Vec3::new(0.5, 0.0, 1.0)).unwrap();
    }
    solver
}

/// What one of the solver's parts, alone, does.
fn parts() -> Vec<(&'static str, Material, Settings)> {
    let springs = settings(StretchMethod::ExplicitSprings, 8);
    let threads = settings(StretchMethod::ImplicitThreads, 8);
    let none = Material { thread_stiffness: 0.0, ..plain() };
    let equal = Settings { lumping: MassLumping::Equal, ..springs };
    let flexion = Settings { bending: Bending::Flexion, ..springs };
    let relative = DampingForm::Relative;
    vec![
        ("springs", Material { thread_stiffness: 40.0, ..none }, springs),
        ("springs, equal masses", Material { thread_stiffness: 40.0, ..none }, equal),
        ("shear springs", Material { shear_stiffness: 10.0, ..none }, springs),
        ("second differences", Material { flexural_rigidity: 1e-3, ..none }, springs),
        ("flexion springs", Material { flexural_rigidity: 1e-3, ..none }, flexion),
        ("axial damping", Material { damping: 0.01, ..none }, springs),
        (
            "axial damping with shear",
            Material { damping: 0.01, shear_stiffness: 1.0, ..none },
            springs,
        ),
        ("relative damping", Material { damping: 0.01, damping_form: relative, ..none }, springs),
        ("threads", Material { thread_stiffness: 2000.0, ..none }, threads),
        ("threads with shear", Material { shear_stiffness: 50.0, ..none }, threads),
        ("Provot's limit", Material { max_strain: 0.02, ..none }, springs),
        (
            "Provot's limit with shear",
            Material { max_strain: 0.02, shear_stiffness: 1.0, ..none },
            springs,
        ),
    ]
}

#[test]
fn linear_momentum_stays() {
    for (what, material, settings) in parts() {
        let mut solver = crumpled(material, settings);
        let before = momenta(&solver).0;
        run(&mut solver, 64, Vec3::ZERO, &[]);
        let drift = (momenta(&solver).0 - before).length() / before.length();
        check_at_most(&format!("{what}: drift of linear momentum, relative"), drift, 1e-5);
    }
}

#[test]
fn angular_momentum_stays_under_forces_along_springs() {
    for (what, material, settings) in parts().into_iter().take(7) {
        let mut solver = crumpled(material, settings);
        let before = momenta(&solver).1;
        run(&mut solver, 64, Vec3::ZERO, &[]);
        let drift = (momenta(&solver).1 - before).length() / before.length();
        check_at_most(&format!("{what}: drift of angular momentum, relative"), drift, 3e-5);
    }
}

/// A flat sheet turning about its normal; what is left of its spin after a second.
fn spin_left(material: Material, form: StretchMethod, substeps: u32) -> f64 {
    const TURN: Vec3 = Vec3::new(0.0, 2.0, 0.0);
    let lattice = sheet(Vec2::new(0.9, 0.6), 9, 12, MassLumping::Lumped);
    let mut solver = at_rest(&lattice, Vec3::ZERO, material, settings(form, substeps));
    for (i, &p) in lattice.rest_positions().iter().enumerate() {
        solver.set_velocity(i, TURN.cross(p)).unwrap();
    }
    let before = momenta(&solver).1;
    run(&mut solver, 64, Vec3::ZERO, &[]);
    momenta(&solver).1.y / before.y
}

#[test]
fn axial_damping_leaves_spin_alone_and_relative_damping_does_not() {
    let material =
        Material { thread_stiffness: 40.0, shear_stiffness: 10.0, damping: 0.01, ..plain() };
    let axial = spin_left(material, StretchMethod::ExplicitSprings, 8);
    check("spin left under axial damping", axial, 1.0, 1e-5);
    let relative = Material { damping_form: DampingForm::Relative, ..material };
    let relative = spin_left(relative, StretchMethod::ExplicitSprings, 8);
    check_at_most("spin left under relative damping", relative, 0.9);
}

/// A correction at the substep's end is towards the axis while the particle has gone on by `omega h`, and
/// takes `(omega h)^2` of the spin. Once corrections are carried on nothing is left of that but
/// `(omega h)^4 / 2`: it is the first substep that costs, and the second to which it has carried nothing.
#[test]
fn threads_lose_spin_only_as_they_begin() {
    let material = Material { thread_stiffness: 2000.0, shear_stiffness: 100.0, ..plain() };
    for substeps in [2, 4, 16, 64] {
        let lost = 1.0 - spin_left(material, StretchMethod::ImplicitThreads, substeps);
        let turned = 2.0 * f64::from(TICK) / f64::from(substeps);
        let first = turned * turned;
        check(&format!("spin lost by threads x{substeps}"), lost, 2.0 * first, 0.1 * first + 2e-5);
    }
}
