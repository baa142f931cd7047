//! Cloths that are pulled further than they reach.

use bevy::math::{Vec2, Vec3};
use bevy_drape::solver::PinMotion;

use crate::trial::*;

/// Leads pins evenly to other places in so many frames.
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
        // Two metres in four seconds, to three times its length; and nothing goes further.
        trial.keep_in(Vec3::new(-1.0, -1.2, -1.0), Vec3::new(1.0, 1.2, 2.51));
        lead(&mut trial, 240, |p| if p >= N as u32 { Vec3::Z * 2.0 } else { Vec3::ZERO });
        trial.solver.set_pins(&row).unwrap();
        trial.pins.truncate(N);
        trial.bound_by_pins();
        trial.measure_anew();
        trial.run_on();
        // A mesh of springs alone is drawn in by its limit and by tethers that had eased.
        trial.recovers_within([3, 30, 3]);
        // Where they let go, they are as fast as the limit of speed allows, and corrections a little more.
        let fastest = trial.fastest;
        trial.require(fastest < 150.0, |_| format!("{fastest} m/s"));
        trials.push(trial);
    }
    verdict(trials);
}

/// The best peer comes to a strain of 201 %, and recovers in 55 frames.
#[test]
fn both_pins_jump_ten_metres() {
    const N: usize = 32;
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for at_once in [false, true] {
            for way in [Vec3::X * 10.0, Vec3::Y * 10.0] {
                let sheet = variant.sheet(Vec2::ONE, N, N);
                let how = if at_once { "at once" } else { "in a frame" };
                let name = format!("pins jump by {way} {how}");
                let mut trial = Trial::new(&name, variant, sheet, &corners(N), |_, p| p);
                trial.run(60, &[]);
                for pin in &mut trial.pins {
                    let to = pin.end + way;
                    *pin = PinMotion { start: if at_once { to } else { pin.start }, end: to };
                }
                trial.bound_by_pins();
                trial.measure_anew();
                trial.frame(&[]);
                trial.bound_by_pins();
                if way.x == 0.0 {
                    trial.run_on();
                } else {
                    trial.run(180, &[]);
                }
                let worst = trial.worst;
                trial.require(worst < 1.5, |_| format!("strain of {worst}"));
                // From one rounding to the next a few frames or many: 8 to 43 were seen.
                trial.recovers_within([55, 120, 30]);
                trials.push(trial);
            }
        }
    }
    verdict(trials);
}
