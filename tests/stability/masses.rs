//! Masses and stiffness far apart, or far from what is usual.

use bevy::math::Vec2;
use bevy_drape::solver::{Material, PlanReason, Stretching};

use crate::trial::*;

/// All four corners of a sheet.
fn four(n: usize) -> [u32; 4] {
    let last = (n * n) as u32 - 1;
    [0, n as u32 - 1, last + 1 - n as u32, last]
}

/// The chain of Small Steps (Macklin et al. 2019, section 6.1), as a strip of two columns: its lowest
/// particle is 3.2 m off there with a hundred substeps, 322 m with as many iterations.
#[test]
fn h06_a_load_of_100000_below_light_particles() {
    const ROWS: usize = 20;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for ratio in [1e3_f32, 2e3, 1e5] {
            let (light, heavy) = (1.0 / ratio.sqrt(), ratio.sqrt());
            let mass = |i: usize| if i / 2 == ROWS - 1 { heavy } else { light };
            let sheet = variant.weighted(Vec2::new(0.01, 0.19), ROWS, 2, mass, |_| 1.0);
            let name = format!("chain of 1:{ratio:.0}");
            let mut trial = Trial::new(&name, variant, sheet, &[0, 1], |_, p| p);
            trial.run_on();
            trial.strains_at_most([0.01, 0.1, 0.01], [0.002, 0.01, 0.001]);
            trials.push(trial);
        }
    }
    verdict(trials);
}

#[test]
fn h06_heavy_particles_amid_light_ones() {
    const N: usize = 16;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for ratio in [1e3_f32, 2e3, 1e5] {
            let (light, heavy) = (1.0 / ratio.sqrt(), ratio.sqrt());
            let middle = |i: usize| [7, 8].contains(&(i / N)) && [7, 8].contains(&(i % N));
            let mass = |i: usize| if middle(i) { heavy } else { light };
            let sheet = variant.weighted(Vec2::ONE, N, N, mass, |_| 1.0);
            let name = format!("four of 1:{ratio:.0}");
            let mut trial = Trial::new(&name, variant, sheet, &four(N), |_, p| p);
            trial.run_on();
            // A hundred newtons pull at particles of milligrams: bounded.
            if ratio > 1e4 {
                trial.strains_at_most([1.1, 1.1, 0.01], [1.1, 1.1, 0.01]);
            } else {
                trial.strains_at_most([0.4, 0.5, 0.01], [0.22, 0.25, 0.01]);
            }
            trials.push(trial);
        }
    }
    verdict(trials);
}

#[test]
fn h07_ten_million_newton_a_metre() {
    const N: usize = 24;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for pins in [(0..N as u32).collect::<Vec<_>>(), corners(N).to_vec()] {
            let material = Material { thread_stiffness: 1e7, ..variant.material() };
            let sheet = variant.sheet(Vec2::ONE, N, N);
            let name = format!("1e7 N/m, {} pins", pins.len());
            let settings = variant.settings();
            let mut trial = Trial::with(&name, variant, sheet, material, settings, &pins, |_, p| p);
            let plan = *trial.solver.plan();
            trial.require(plan.margin <= 0.9001, |_| format!("{plan}"));
            let told = plan.stretching == Stretching::ImplicitThreads || plan.clamped.thread;
            trial.require(told, |_| format!("explicit springs carry it? {plan}"));
            trial.run_on();
            trial.recovers_within([0, 0, 0]);
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
        ("every second warp thread", |i| (i % N).is_multiple_of(2)),
        ("every second weft thread", |i| (i / N).is_multiple_of(2)),
        ("one half", |i| i % N < N / 2),
    ];
    for variant in Variant::all() {
        for (what, stiff) in patterns {
            let factor = |i: usize| if stiff(i) { 100.0 } else { 0.01 };
            let sheet = variant.weighted(Vec2::ONE, N, N, |_| 1.0, factor);
            let mut trial = Trial::new(what, variant, sheet, &corners(N), |_, p| p);
            trial.run_on();
            trial.recovers_within([3, 3, 0]);
            trials.push(trial);
        }
        // Cells a hundred times as long as wide, so that weft springs are 10000 times as hard as warp
        // springs. Degraded, as it swings at 20 m/s with cells of 5 mm, and stable.
        let sheet = variant.sheet(Vec2::new(0.1, 10.0), 21, 21);
        let mut trial = Trial::new("warp against weft", variant, sheet, &corners(21), |_, p| p);
        trial.run_on();
        trial.strains_at_most([2.5, 0.5, 0.25], [1.2, 0.3, 0.03]);
        trials.push(trial);
    }
    verdict(trials);
}

/// As reported of another engine (godot #116058): 50 x 50 particles of 1.01 kg, stiffness 0.5, damping
/// 0.01. Nothing but the limit carries that cloth.
#[test]
fn h09_hardly_any_stiffness() {
    const N: usize = 50;
    let mut trials = Vec::new();
    for variant in Variant::all().filter(|variant| variant.stuff == Stuff::Automatic) {
        let material = Material {
            area_density: 1.01,
            thread_stiffness: 0.5,
            shear_stiffness: 0.5,
            damping: 0.01,
            ..variant.material()
        };
        let (sheet, settings) = (variant.sheet(Vec2::ONE, N, N), variant.settings());
        let (name, pins) = ("1.01 kg", corners(N));
        let mut trial = Trial::with(name, variant, sheet, material, settings, &pins, |_, p| p);
        let plan = *trial.solver.plan();
        trial.require(plan.reason == PlanReason::SpringsGive, |_| format!("{plan}"));
        trial.run_on();
        trial.recovers_within([240, 0, 0]);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn h09_as_light_as_is_accepted() {
    const N: usize = 32;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let material = Material { area_density: 1e-6, ..variant.material() };
        let (sheet, settings) = (variant.sheet(Vec2::ONE, N, N), variant.settings());
        let (name, pins) = ("1 mg", corners(N));
        let mut trial = Trial::with(name, variant, sheet, material, settings, &pins, |_, p| p);
        trial.run_on();
        trial.recovers_within([0, 0, 0]);
        trials.push(trial);
    }
    verdict(trials);
}

/// `SoftBodyStressTest` of Jolt: particles of 1 kg, 0.25 m apart, and boxes of 10 kg upon them, here as
/// mass of their own.
#[test]
fn h13_a_hundred_by_a_hundred_with_121_loads() {
    const N: usize = 100;
    let mut trials = Vec::new();
    for variant in Variant::all().filter(|variant| variant.stuff != Stuff::Springs) {
        if variant.mesh && variant.stuff == Stuff::Stiffest {
            continue;
        }
        let (row, column) = (|i: usize| i / N, |i: usize| i % N);
        let is_nth = |at: usize| at % 9 == 4 && at < 99;
        let loaded = |i: usize| is_nth(row(i)) && is_nth(column(i));
        assert_eq!((0..N * N).filter(|&i| loaded(i)).count(), 121);
        let mass = |i: usize| if loaded(i) { 11.0 } else { 1.0 };
        let sheet = variant.weighted(Vec2::splat(24.75), N, N, mass, |_| 1.0);
        let material = Material { area_density: 16.0, ..variant.material() };
        let (name, settings) = ("121 loads", variant.settings());
        let mut trial = Trial::with(name, variant, sheet, material, settings, &four(N), |_, p| p);
        trial.run_on();
        // A mesh takes 409 frames.
        trial.recovers_within([450, 0, 0]);
        trials.push(trial);
    }
    verdict(trials);
}
