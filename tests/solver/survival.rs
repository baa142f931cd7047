//! What a user can pass must not break a cloth: finite, and within the bounds that its weight and
//! its
//! reach allow.

use std::sync::Arc;

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{
    ClothSolver, DampingForm, Lattice, MassLumping, Material, Settings, StretchMethod, Substeps,
};

use crate::support::solver::*;

/// No real cloth is as stiff.
fn stiff() -> Material {
    Material {
        thread_stiffness: 1e12,
        shear_stiffness: 1e12,
        flexural_rigidity: 1e6,
        damping: 1e6,
        max_strain: 0.1,
        ..plain()
    }
}

/// Ten seconds of a cloth held along its first row; nothing may be further off than the cloth
/// reaches.
fn survives(lattice: &Arc<Lattice>, material: Material, settings: Settings, ticks: usize) {
    let columns = lattice.columns();
    let mut solver = at_rest(lattice, Vec3::ZERO, material, settings);
    solver.set_pins(&(0..columns as u32).collect::<Vec<_>>()).unwrap();
    let what = format!("{:?} {:?}", settings.stretch_method, settings.substeps);
    for _ in 0..ticks {
        run(&mut solver, 1, GRAVITY, &[]);
        for p in positions(&solver) {
            // The first row is at y = 0, z = -0.5, and the cloth 1 m long and wide.
            let away = p.y.hypot(p.z + 0.5);
            assert!(away <= 1.15 && p.x.abs() <= 0.65, "{what}: {p}, {}", solver.plan());
        }
    }
    let (low, _) = solver.bounds();
    assert!(low.y < -0.3, "{what}: it did not fall, {low}");
}

#[test]
fn a_hundred_by_a_hundred_of_stiffness_1e12_lives_ten_seconds() {
    let lattice = sheet(Vec2::ONE, 100, 100, MassLumping::Lumped);
    survives(&lattice, stiff(), Settings::default(), 640);
    let bare = Material { shear_stiffness: 0.0, flexural_rigidity: 0.0, damping: 0.0, ..stiff() };
    survives(&lattice, bare, Settings::default(), 640);
}

#[test]
fn both_forms_live_with_any_substeps() {
    let lattice = sheet(Vec2::ONE, 40, 40, MassLumping::Lumped);
    for substeps in [1, 4, 16] {
        survives(&lattice, stiff(), settings(StretchMethod::ImplicitThreads, substeps), 640);
        let passes =
            Settings { provot_passes: 8, ..settings(StretchMethod::ExplicitSprings, substeps) };
        survives(&lattice, stiff(), passes, 640);
    }
    let relative = Material { damping_form: DampingForm::Relative, ..stiff() };
    survives(&lattice, relative, Settings::default(), 640);
}

#[test]
fn a_straight_line_held_at_both_ends_stays() {
    for form in [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads] {
        for stretch in [0.9, 1.0, 1.02, 1.5] {
            let lattice = sheet(Vec2::new(1.0, 0.1), 3, 33, MassLumping::Lumped);
            let start: Vec<_> = lattice
                .rest_positions()
                .iter()
                .map(|&p| Vec3::new(p.x * stretch, p.y, p.z))
                .collect();
            let mut solver = ClothSolver::new(lattice, &start, stiff(), settings(form, 8)).unwrap();
            solver.set_pins(&[0, 33, 66, 32, 65, 98]).unwrap();
            run(&mut solver, 256, GRAVITY, &[]);
            let (low, high) = solver.bounds();
            assert!(low.is_finite() && high.is_finite(), "{form:?} {stretch}");
            let aside = low.x.abs().max(high.x.abs());
            assert!(
                aside <= 0.5 * stretch + 0.05 && low.y > -0.5 && high.y < 0.3,
                "{form:?} {stretch}: {low} {high}"
            );
        }
    }
}

#[test]
fn all_pinned_or_none_is_a_cloth_too() {
    for form in
        [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads, StretchMethod::Automatic]
    {
        let lattice = sheet(Vec2::ONE, 7, 19, MassLumping::Lumped);
        let settings = Settings { stretch_method: form, ..Settings::default() };
        let mut solver = at_rest(&lattice, Vec3::ONE, stiff(), settings);
        solver.set_pins(&(0..7 * 19).collect::<Vec<_>>()).unwrap();
        let before = positions(&solver);
        run(&mut solver, 64, GRAVITY, &[]);
        assert_eq!(before, positions(&solver), "{form:?}");
        assert!(!solver.has_moved());
        // A held particle's velocity is that of half a substep before it was let go.
        let expected = -4.905 - 9.81 * 0.5 * f64::from(solver.plan().step);
        solver.set_pins(&[]).unwrap();
        run(&mut solver, 64, GRAVITY, &[]);
        check(
            &format!("{form:?}, fallen in 1 s [m]"),
            f64::from(solver.position(60).y - 1.0),
            expected,
            1e-3,
        );
    }
}

fn soft_cloth() -> Material {
    Material {
        thread_stiffness: 2000.0,
        shear_stiffness: 20.0,
        flexural_rigidity: 1e-5,
        damping: 0.001,
        drag: 2.0,
        max_strain: 0.1,
        ..plain()
    }
}

/// Every form with every kind of masses.
fn kinds() -> impl Iterator<Item = (Arc<Lattice>, Settings)> {
    [StretchMethod::ExplicitSprings, StretchMethod::ImplicitThreads, StretchMethod::Automatic]
        .into_iter()
        .flat_map(|form| {
            [MassLumping::Lumped, MassLumping::Equal].into_iter().map(move |lumping| {
                let substeps = Substeps::Automatic { budget: 16 };
                let settings =
                    Settings { stretch_method: form, lumping, substeps, ..Settings::default() };
                (curtain(Vec2::ONE, 25, 25, lumping), settings)
            })
        })
}

#[test]
fn a_scrambled_start_sorts_itself_out() {
    for (lattice, settings) in kinds() {
        let mut dice = Dice(21);
        let mut start: Vec<_> = (0..625).map(|_| dice.vector()).collect();
        for corner in [0, 24] {
            start[corner] = lattice.rest_positions()[corner];
        }
        let mut solver = ClothSolver::new(lattice, &start, soft_cloth(), settings).unwrap();
        solver.set_pins(&[0, 24]).unwrap();
        run(&mut solver, 640, GRAVITY, &[]);
        let what = format!("{:?} {:?} after 10 s", settings.stretch_method, settings.lumping);
        check_at_most(&format!("{what}, speed [m/s]"), fastest(&solver), 0.05);
        // The spring form's constants are clamped to what its substeps carry.
        let most =
            if settings.stretch_method == StretchMethod::ExplicitSprings { 0.4 } else { 0.11 };
        check_at_most(&format!("{what}, strain"), solver.strain().max.into(), most);
    }
}

#[test]
fn pins_further_apart_than_the_cloth_is_wide_do_no_harm() {
    for (lattice, settings) in kinds() {
        for beyond in [0.4, 0.45, 0.5] {
            let mut start = lattice.rest_positions().to_vec();
            start[24] += Vec3::X * beyond;
            let mut solver =
                ClothSolver::new(lattice.clone(), &start, soft_cloth(), settings).unwrap();
            solver.set_pins(&[0, 24]).unwrap();
            let what = format!("{:?} {:?} {beyond} m", settings.stretch_method, settings.lumping);
            for _ in 0..320 {
                run(&mut solver, 1, GRAVITY, &[]);
                // Within its plane, as all that acts on it is; aside no further than the pins, but for what swings
                // at first; not below where it began. Upwards it buckles, by 0.80 m at most.
                let (low, high) = solver.bounds();
                let (least, most) =
                    (Vec3::new(-0.6, -1.02, 0.0), Vec3::new(0.501 + beyond, 0.9, 0.0));
                let inside = low.cmpge(least).all() && high.cmple(most).all();
                assert!(inside, "{what}: {low} {high}");
            }
            // It comes to rest, stretched most at the pins: there to 1.7 to 2.2 times what they ask for.
            check_at_most(&format!("{what}: speed [m/s]"), fastest(&solver), 0.05);
            let strain = f64::from(solver.strain().max);
            check_at_most(&format!("{what}: strain"), strain, 2.5 * f64::from(beyond));
        }
    }
}

#[test]
fn the_extremes_of_every_number_stay_finite() {
    let lattice = sheet(Vec2::ONE, 9, 18, MassLumping::Lumped);
    let extremes: [(&str, fn(&mut Material)); 10] = [
        ("light", |m| m.area_density = 1e-6),
        ("heavy", |m| m.area_density = 1e4),
        ("no threads", |m| m.thread_stiffness = 0.0),
        ("stiffest", |m| m.thread_stiffness = 1e15),
        ("stiffest shear", |m| m.shear_stiffness = 1e15),
        ("rigid", |m| m.flexural_rigidity = 1e9),
        ("damped", |m| m.damping = 1e9),
        ("in honey", |m| m.drag = 1e6),
        ("no strain", |m| m.max_strain = 0.0),
        ("light and stiff", |m| {
            (m.area_density, m.thread_stiffness, m.shear_stiffness, m.damping) =
                (1e-6, 1e15, 1e15, 1e9);
        }),
    ];
    for (what, change) in extremes {
        for form in [
            StretchMethod::ExplicitSprings,
            StretchMethod::ImplicitThreads,
            StretchMethod::Automatic,
        ] {
            let mut material = Material { shear_stiffness: 1.0, damping: 0.001, ..plain() };
            change(&mut material);
            let mut solver = at_rest(
                &lattice,
                Vec3::ZERO,
                material,
                Settings { stretch_method: form, ..Settings::default() },
            );
            solver.set_pins(&[0, 17]).unwrap();
            run(&mut solver, 128, GRAVITY, &[]);
            let (low, high) = solver.bounds();
            let most = if what == "no threads" { 25.0 } else { 12.0 };
            assert!(
                low.is_finite() && high.is_finite() && (high - low).max_element() < most,
                "{what} {form:?}: {low} {high}"
            );
        }
    }
}
