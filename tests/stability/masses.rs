//! Masses and stiffness far apart, or far from what is usual.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{FormChoice, Material, Settings};

use crate::common::*;

#[test]
fn h06_heavy_below_light() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for ratio in [1e3_f32, 2e3, 1e5] {
            // A strip of 20 rows, a centimetre apart, with a load on the last.
            let (rows, columns) = (20, 2);
            let (low, high) = (1.0 / ratio.sqrt(), ratio.sqrt());
            let mass = |i: usize| if i / columns == rows - 1 { high } else { low };
            let size = Vec2::new(0.01, 0.19);
            let sheet = variant.weighted(size, rows, columns, mass, |_| 1.0);
            let name = format!("load of {ratio:.0}");
            let mut trial = Trial::new(&name, variant, sheet, &[0, 1], |_, p| p);
            trial.run_on();
            trial.recovers_within(600);
            trials.push(trial);
            // Four heavy particles in the middle of a sheet.
            let n = 16;
            let middle = |i: usize| [7, 8].contains(&(i / n)) && [7, 8].contains(&(i % n));
            let mass = |i: usize| if middle(i) { high } else { low };
            let sheet = variant.weighted(Vec2::ONE, n, n, mass, |_| 1.0);
            let name = format!("load of {ratio:.0} in the middle");
            let last = (n * n) as u32 - 1;
            let pins = [0, n as u32 - 1, last + 1 - n as u32, last];
            let mut trial = Trial::new(&name, variant, sheet, &pins, |_, p| p);
            trial.run_on();
            trial.recovers_within(600);
            trials.push(trial);
        }
    }
    verdict(trials);
}

#[test]
fn h07_ten_million_newton_a_metre() {
    const N: usize = 32;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for pins in [(0..N as u32).collect::<Vec<_>>(), corners(N).to_vec()] {
            let material = Material { thread_stiffness: 1e7, ..variant.material() };
            let sheet = variant.sheet(Vec2::ONE, N, N);
            let name = format!("1e7 N/m, {} pins", pins.len());
            let mut trial =
                Trial::with(&name, variant, sheet, material, variant.settings(), &pins, |_, p| p);
            let plan = *trial.solver.plan();
            trial.require(plan.margin <= 0.9001, |_| format!("{plan}"));
            trial.run_on();
            trial.recovers_within(600);
            trials.push(trial);
        }
    }
    verdict(trials);
}

#[test]
fn h08_stiffness_one_to_ten_thousand() {
    const N: usize = 24;
    let mut trials = Vec::new();
    let patterns: [(&str, fn(usize) -> bool); 3] = [
        ("every second warp thread", |i| i % N % 2 == 0),
        ("every second weft thread", |i| i / N % 2 == 0),
        ("one half", |i| i % N < N / 2),
    ];
    for variant in Variant::all() {
        for (what, stiff) in patterns {
            let factor = |i: usize| if stiff(i) { 100.0 } else { 0.01 };
            let sheet = variant.weighted(Vec2::ONE, N, N, |_| 1.0, factor);
            let name = format!("{what} 10000 times as stiff");
            let mut trial = Trial::new(&name, variant, sheet, &corners(N), |_, p| p);
            trial.run_on();
            trial.recovers_within(600);
            trials.push(trial);
        }
        // Cells a hundred times as long as wide: warp against weft.
        let sheet = variant.sheet(Vec2::new(0.1, 10.0), 21, 21);
        let mut trial = Trial::new("warp against weft", variant, sheet, &corners(21), |_, p| p);
        trial.run_on();
        trial.recovers_within(600);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn h09_light_particles_and_hardly_any_stiffness() {
    const N: usize = 50;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        // Of the issue: 50 x 50, 1.01 kg, stiffness 0.5, damping 0.01. Then as light as is accepted.
        let usual = variant.material();
        let stiff = variant.stuff == Stuff::Stiffest;
        let soft = |asked: f32, stiffest: f32| if stiff { stiffest } else { asked };
        let reported = Material {
            area_density: 1.01,
            thread_stiffness: soft(0.5, 1e15),
            shear_stiffness: soft(0.5, 1e15),
            damping: 0.01,
            ..usual
        };
        for (what, material) in
            [("1.01 kg", reported), ("1 mg", Material { area_density: 1e-6, ..usual })]
        {
            let sheet = variant.sheet(Vec2::ONE, N, N);
            let settings = variant.settings();
            let mut trial =
                Trial::with(what, variant, sheet, material, settings, &corners(N), |_, p| p);
            println!("{}", trial.solver.plan());
            trial.run_on();
            trial.recovers_within(600);
            trials.push(trial);
        }
    }
    verdict(trials);
}

#[test]
fn h13_a_hundred_by_a_hundred_with_121_loads() {
    const N: usize = 100;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for (kilogram, density) in [(1.0, 16.0_f32), (0.0125, 0.2)] {
            // Loads of 10 kg on every tenth particle both ways, of a cloth of 24.75 m.
            let loaded = |i: usize| i / N % 9 == 0 && i % N % 9 == 0 && i / N % 99 != 0 && i % N % 99 != 0;
            let mass = |i: usize| if loaded(i) { 1.0 + 10.0 / kilogram } else { 1.0 };
            let size = Vec2::splat(24.75);
            let sheet = variant.weighted(size, N, N, mass, |_| 1.0);
            let material = Material { area_density: density, ..variant.material() };
            let last = (N * N) as u32 - 1;
            let pins = [0, N as u32 - 1, last + 1 - N as u32, last];
            let name = format!("loads of 10 kg on particles of {kilogram} kg");
            let mut trial =
                Trial::with(&name, variant, sheet, material, variant.settings(), &pins, |_, p| p);
            trial.run_on();
            trial.recovers_within(600);
            trials.push(trial);
        }
    }
    verdict(trials);
}

#[allow(unused)]
fn unused() {
    let _ = (FormChoice::Springs, Settings::default(), Vec3::ZERO);
}
