//! Cloths that are pulled further than they reach.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::PinMotion;

use crate::common::*;

/// Pins whose particles go evenly to other places in so many frames.
fn lead(trial: &mut Trial, frames: usize, way: impl Fn(u32) -> Vec3) {
    let pins = trial.solver.pins().to_vec();
    let from: Vec<_> = trial.pins.iter().map(|pin| pin.end).collect();
    for frame in 1..=frames {
        let part = frame as f32 / frames as f32;
        for (i, pin) in trial.pins.iter_mut().enumerate() {
            pin.end = from[i] + way(pins[i]) * part;
        }
        trial.frame(&[]);
    }
}

#[test]
fn h05_ten_particles_pulled_slowly_and_let_go() {
    const N: usize = 24;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let row: Vec<_> = (0..N as u32).collect();
        let pulled: Vec<_> = (0..10).map(|i| ((N - 1) * N + 7 + i) as u32).collect();
        let pins: Vec<_> = row.iter().chain(&pulled).copied().collect();
        let mut trial = Trial::new("pulled", variant, sheet, &pins, |_, p| p);
        trial.keep_in(Vec3::splat(-4.0), Vec3::splat(4.0));
        // Two metres in four seconds: to three times its length.
        lead(&mut trial, 240, |p| if p >= N as u32 { Vec3::Z * 2.0 } else { Vec3::ZERO });
        println!("{} pulled: {:.1} %, fastest {}", trial.name, trial.strain * 100.0, trial.fastest);
        trial.solver.set_pins(&row).unwrap();
        trial.pins.truncate(N);
        trial.bound_by_pins();
        trial.measure_anew();
        trial.run_on();
        trial.recovers_within(600);
        trials.push(trial);
    }
    verdict(trials);
}

#[test]
fn both_pins_jump_ten_metres() {
    const N: usize = 32;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for at_once in [false, true] {
            for way in [Vec3::X * 10.0, Vec3::Y * 10.0] {
                let sheet = variant.sheet(Vec2::ONE, N, N);
                let name = if at_once { "pins jump at once" } else { "pins jump in a frame" };
                let mut trial =
                    Trial::new(&format!("{name} {way}"), variant, sheet, &corners(N), |_, p| p);
                trial.run(60, &[]);
                for pin in &mut trial.pins {
                    let to = pin.end + way;
                    *pin = PinMotion { start: if at_once { to } else { pin.start }, end: to };
                }
                trial.bound_by_pins();
                trial.measure_anew();
                for frame in 0..5 {
                    trial.frame(&[]);
                    println!("{} frame {frame}: {:.1} %, {:.1} m/s", trial.name, trial.strain * 100.0, trial.fastest);
                }
                trial.bound_by_pins();
                trial.run_on();
                trial.recovers_within(600);
                trials.push(trial);
            }
        }
    }
    verdict(trials);
}
