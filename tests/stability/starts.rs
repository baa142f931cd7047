//! Cloths that start as no cloth can be: scrambled, flattened, at one point, five times too long.
//!
//! Free ones keep their momentum besides, as long as no particle is as fast as the limit of speed.

use std::cell::RefCell;

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::{Settings, Substeps};

use crate::{
    support::solver::{Dice, extent},
    trial::*,
};

const N: usize = 24;

/// Runs a start for ten seconds in all variants, hung from two corners; and without gravity, held by
/// nothing and with no limit of speed.
fn recovers(
    name: &str,
    [hung, free]: [Within; 2],
    start: impl Fn(&mut Dice, Vec3) -> Vec3,
) -> Vec<Trial> {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let dice = RefCell::new(Dice(21));
        let place = |_: usize, rest: Vec3| start(&mut dice.borrow_mut(), rest);
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let title = format!("{name}, hung");
        let mut trial = Trial::new(&title, variant, sheet.clone(), &corners(N), place);
        trial.run_on();
        trial.recovers_within(hung);
        trials.push(trial);

        *dice.borrow_mut() = Dice(21);
        let settings = Settings { max_speed: 1e5, ..variant.settings() };
        let title = format!("{name}, free");
        let material = variant.material();
        let mut trial = Trial::with(&title, variant, sheet, material, settings, &[], place);
        trial.gravity = Vec3::ZERO;
        trial.keep_in(Vec3::splat(-2.0), Vec3::splat(2.0));
        let (from, _) = trial.centre();
        trial.run_on();
        let (to, _) = trial.centre();
        trial.require(from.distance(to) < 1e-4, |_| format!("drifted from {from} to {to}"));
        trial.recovers_within(free);
        trials.push(trial);
    }
    trials
}

#[test]
fn h01_scrambled_on_a_sphere() {
    let within = [[10, 90, 15], [2, 10, 10]];
    verdict(recovers("scrambled", within, |dice, _| dice.vector().normalize_or(Vec3::X) * 0.5));
}

#[test]
fn h01_scrambled_where_particles_reach_the_limit_of_speed() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let dice = RefCell::new(Dice(21));
        let place = |_: usize, _: Vec3| dice.borrow_mut().vector() * 2.0;
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let mut trial = Trial::new("scrambled widely, free", variant, sheet, &[], place);
        trial.gravity = Vec3::ZERO;
        // What the limit takes of a particle's momentum, the cloth as a whole goes on without. How far is chance:
        // twelve seeds of the dice come to 4 to 27 m.
        trial.keep_in(Vec3::splat(-40.0), Vec3::splat(40.0));
        trial.run_on();
        let (_, speed) = trial.centre();
        trial.require(speed.length() < 2.0, |_| format!("goes at {speed}"));
        trial.recovers_within([5, 20, 5]);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn h02_flattened_onto_a_line() {
    let within = [[25, 30, 5], [2, 2, 6]];
    verdict(recovers("flattened", within, |dice, rest| rest * Vec3::Z + dice.vector() * 1e-6));
}

#[test]
fn h02_flattened_onto_a_line_exactly() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let flat = |_: usize, rest: Vec3| rest * Vec3::Z;
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let (name, pins) = ("flattened exactly, hung", corners(N));
        let mut trial = Trial::new(name, variant, sheet.clone(), &pins, flat);
        trial.run_on();
        trial.recovers_within([15, 80, 5]);
        trials.push(trial);
        // Across the line nothing has a direction: free, it stays on it, where its springs are at odds with
        // each other.
        let mut trial = Trial::new("flattened exactly, free", variant, sheet, &[], flat);
        trial.gravity = Vec3::ZERO;
        trial.keep_in(Vec3::NEG_Z * 20.0, Vec3::Z * 20.0);
        trial.run_on();
        trial.strains_at_most([4.0; 3], [3.0; 3]);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn h03_all_at_one_point_exactly() {
    verdict(recovers("at one point", [[10, 30, 10], [0, 0, 0]], |_, _| Vec3::ZERO));
}

#[test]
fn h03_all_at_one_point_opens_once_nudged() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let mut trial = Trial::new("at one point, nudged", variant, sheet, &[], |_, _| Vec3::ONE);
        trial.gravity = Vec3::ZERO;
        trial.keep_in(Vec3::splat(-2.0), Vec3::splat(4.0));
        trial.run(30, &[]);
        trial.require(trial.fastest == 0.0, |_| "moved without a direction".into());
        let mut dice = Dice(22);
        for i in 0..N * N {
            trial.solver.set_position(i, Vec3::ONE + dice.vector() * 1e-6).unwrap();
        }
        trial.measure_anew();
        trial.run_on();
        let (low, high) = extent(&trial.places());
        let across = (high - low).max_element();
        trial.require(across > 0.2, |_| format!("opened to {across} m"));
        trial.recovers_within([2, 2, 60]);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn h04_one_substep_a_frame_and_stretched_five_times() {
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let settings = Settings { substeps: Substeps::Fixed(1), ..variant.settings() };
        let (material, pins) = (variant.material(), corners(N));
        let edge = Vec3::new(0.0, 0.0, -0.5);
        let stretched = |_: usize, p: Vec3| edge + (p - edge) * 5.0;
        let name = "one substep, stretched";
        let mut trial = Trial::with(name, variant, sheet, material, settings, &pins, stretched);
        trial.run(10, &[]);
        trial.bound_by_pins();
        trial.run(110, &[]);
        trial.measure_anew();
        trial.run_on();
        // Stable, though wrong: one substep of a frame does not hold the limit.
        trial.strains_at_most([0.8, 0.9, 0.25], [0.7, 0.8, 0.12]);
        trials.push(trial);
    }
    verdict(trials);
}

/// The best peer has strain under 50 % after six frames, others never.
#[test]
fn crumpled_into_a_cube_of_ten_centimetres() {
    const N: usize = 64;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let dice = RefCell::new(Dice(5));
        let cube = |_: usize, _: Vec3| dice.borrow_mut().vector() * 0.05;
        let mut trial = Trial::new("crumpled", variant, sheet, &corners(N), cube);
        let mut half = 0;
        for frame in 1..=120 {
            trial.frame(&[]);
            if trial.strain > 0.5 {
                half = frame;
            }
        }
        // Explicit springs carry 24 N/m of the 2000 that are asked for.
        let most = variant.of([6, 25, 6]);
        trial.require(half <= most, |_| format!("under 50 % after {half} frames, not {most}"));
        trial.name += &format!(", under 50 % after {half} frames");
        trial.measure_anew();
        trial.run(if variant.stuff == Stuff::Automatic { 480 } else { 120 }, &[]);
        // A whole cloth hangs from two particles of thousands: by its limit of 10 %.
        trial.strains_at_most([0.3, 0.3, 0.2], [0.25, 0.25, 0.101]);
        trials.push(trial);
    }
    verdict(trials);
}
