//! Cloths that start as no cloth can be: scrambled, flattened, at one point.

use std::cell::RefCell;

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{FormChoice, MassLumping, Settings, Substeps};

use crate::common::*;

const N: usize = 24;

/// Hung from two corners, or free.
fn holds() -> [(&'static str, Vec<u32>); 2] {
    [("hung", corners(N).to_vec()), ("free", Vec::new())]
}

/// Runs a start for ten seconds, hung and free, in all variants.
fn recovers(name: &str, within: [usize; 2], start: impl Fn(&mut Dice, Vec3) -> Vec3) {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for (&within, (hold, pins)) in within.iter().zip(holds()) {
            let dice = RefCell::new(Dice(21));
            let sheet = variant.sheet(Vec2::ONE, N, N);
            let name = format!("{name}, {hold}");
            let place = |_: usize, rest: Vec3| start(&mut dice.borrow_mut(), rest);
            let mut trial = Trial::new(&name, variant, sheet, &pins, place);
            if pins.is_empty() {
                fall(&mut trial);
            } else {
                trial.run(SCENE, &[]);
            }
            trial.recovers_within(within);
            trials.push(trial);
        }
    }
    verdict(trials);
}

/// Ten seconds without gravity, so that the cloth is where it began, but for what it opens to and
/// drifts.
fn fall(trial: &mut Trial) {
    trial.gravity = Vec3::ZERO;
    let (from, _) = trial.centre();
    trial.keep_in(Vec3::splat(-10.0), Vec3::splat(10.0));
    trial.run(SCENE, &[]);
    let (to, _) = trial.centre();
    println!("{}: drifted {}", trial.name, (to - from).length());
}

#[test]
fn h01_scrambled_on_a_sphere() {
    recovers("scrambled", [600, 600], |dice, _| {
        dice.vector().normalize_or(Vec3::X) * 0.5
    });
}

#[test]
fn h02_flattened_onto_a_line() {
    recovers("flattened", [600, 600], |dice, rest| {
        rest * Vec3::Z + dice.vector() * 1e-6
    });
    recovers("flattened exactly", [600, 600], |_, rest| rest * Vec3::Z);
}

#[test]
fn h03_all_at_one_point() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for lumping in [MassLumping::Lumped] {
            let _ = lumping;
            // No spring has a direction.
            let sheet = variant.sheet(Vec2::ONE, N, N);
            let mut trial = Trial::new("at one point", variant, sheet, &[], |_, _| Vec3::ONE);
            trial.gravity = Vec3::ZERO;
            trial.keep_in(Vec3::ONE * -1.0, Vec3::ONE * 3.0);
            trial.run(30, &[]);
            let mut dice = Dice(22);
            for i in 0..N * N {
                trial.solver.set_position(i, Vec3::ONE + dice.vector() * 1e-6).unwrap();
            }
            trial.run_on();
            let (low, high) = extent(&trial.places());
            let across = (high - low).max_element();
            println!("{}: opened to {across}", trial.name);
            trial.recovers_within(600);
            trials.push(trial);
        }
    }
    recovers("at one point", [600, 600], |_, _| Vec3::ZERO);
    verdict(trials);
}

#[test]
fn h04_one_substep_a_frame_and_stretched_five_times() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let settings = Settings { substeps: Substeps::Fixed(1), ..variant.settings() };
        let material = variant.material();
        let pin = Vec3::new(0.0, 0.0, -0.5);
        let mut trial =
            Trial::with("one substep", variant, sheet, material, settings, &corners(N), |_, p| {
                pin + (p - pin) * 5.0
            });
        trial.run_on();
        trial.recovers_within(600);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn crumpled_into_a_cube() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let n = 64;
        let sheet = variant.sheet(Vec2::ONE, n, n);
        let dice = RefCell::new(Dice(5));
        let cube = |_: usize, _: Vec3| dice.borrow_mut().vector() * 0.05;
        let mut trial = Trial::new("crumpled", variant, sheet, &corners(n), cube);
        let mut under_half = 0;
        for frame in 1..=60 {
            trial.frame(&[]);
            if trial.strain > 0.5 {
                under_half = frame;
            }
            if frame < 12 {
                println!("{} frame {frame}: {:.1} %", trial.name, trial.strain * 100.0);
            }
        }
        println!("{}: under half after {under_half}", trial.name);
        trial.run_on();
        trial.recovers_within(600);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn forms_are_as_they_are_to_be() {
    let _ = FormChoice::Automatic;
}
