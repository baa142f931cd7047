//! Colliders that are too fast to be seen twice in the same place, or that are suddenly where the cloth
//! is.

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{Collider, Pose, StepInput};

use crate::{support::solver::GRAVITY, trial::*};

/// How near to the middle of a ball a particle comes on a straight way, as seen from it \[m\].
fn nearest(from: Vec3, to: Vec3) -> f32 {
    let way = to - from;
    let part = (-from.dot(way) / way.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (from + way * part).length()
}

/// Takes a frame stage by stage while a ball goes evenly from place to place, and returns how near to its
/// middle any free particle came.
fn frame_past(trial: &mut Trial, ball: &Sphere, from: Vec3, to: Vec3) -> f32 {
    let poses = [from, to].map(Pose::from_translation);
    let colliders = [Collider::new(ball, poses[0]).moving_to(poses[1])];
    // The same frame on a copy, between whose substeps one can look.
    let mut solver = trial.solver.clone();
    let input = StepInput {
        dt: FRAME,
        gravity: trial.gravity,
        pins: &trial.pins,
        colliders: &colliders,
        ..StepInput::default()
    };
    let count = solver.topology().particle_count();
    let held = solver.pins().to_vec();
    let free: Vec<_> = (0..count).filter(|&i| !held.contains(&(i as u32))).collect();
    let mut least = f32::INFINITY;
    let substeps = solver.begin_tick(&input).unwrap();
    for substep in 0..substeps {
        let at = |part: u32| from.lerp(to, part as f32 / substeps as f32);
        let before: Vec<_> = free.iter().map(|&i| solver.position(i) - at(substep)).collect();
        solver.accumulate_forces(&input);
        solver.integrate(&input);
        solver.correct();
        solver.collide(&input);
        for (&i, &before) in free.iter().zip(&before) {
            least = least.min(nearest(before, solver.position(i) - at(substep + 1)));
        }
    }
    trial.frame(&colliders);
    least
}

/// Of every peer measured, particles pass through the ball at 50 m/s: 56 to 100 %.
#[test]
fn h12_a_fast_ball_goes_through_no_particle() {
    const RADIUS: f32 = 0.2;
    let ball = Sphere::new(RADIUS);
    let mut trials = Vec::new();
    for variant in Variant::all() {
        for pinned in [false, true] {
            // At 300 m/s it goes 5 m a frame.
            let fast = if variant.stuff == Stuff::Automatic { 300.0 } else { 250.0 };
            for speed in [50.0_f32, fast] {
                // The first as the peers were measured.
                let peers = variant.stuff == Stuff::Automatic && !pinned && speed == 50.0;
                let n: usize = if peers { 64 } else { 24 };
                let sheet = variant.sheet(Vec2::ONE, n, n);
                let last = (n * n) as u32 - 1;
                let all = [0, n as u32 - 1, last + 1 - n as u32, last];
                let pins = if pinned { &all[..] } else { &[] };
                let name = format!("ball at {speed} m/s, {} pins", pins.len());
                let mut trial = Trial::new(&name, variant, sheet, pins, |_, p| p);
                trial.gravity = if pinned { GRAVITY } else { Vec3::ZERO };
                let step = Vec3::NEG_Y * speed * FRAME;
                let (mut at, mut least) = (Vec3::Y * 1.03, f32::INFINITY);
                while at.y > -4.0 {
                    // It takes the cloth along as far as it goes, or throws it ahead.
                    let low = 1.5 * (at.y + step.y).min(-2.0);
                    trial.keep_in(Vec3::new(-2.0, low, -2.0), Vec3::splat(2.0));
                    least = least.min(frame_past(&mut trial, &ball, at, at + step));
                    at += step;
                }
                // A straight way along the ball is a chord: s^2 / 8 r deep.
                let chord = (speed * FRAME / 20.0).powi(2) / (8.0 * RADIUS);
                let deepest = RADIUS - least;
                trial.require(deepest <= chord + 1e-3, |_| format!("went {deepest} m into it"));
                let touched = deepest > -0.01;
                trial.require(touched, |_| format!("the ball passed by at {deepest}"));
                trial.measure_anew();
                if pinned {
                    trial.bound_by_pins();
                } else {
                    // It flies on, at the limit of speed at most.
                    trial.keep_in(Vec3::new(-20.0, -1100.0, -20.0), Vec3::splat(20.0));
                }
                trial.run_on();
                // The stiffest is thrown about as rounding has it: 0 to 8 frames from eight heights of the ball.
                trial.recovers_within(if pinned { [60, 100, 3] } else { [16, 20, 10] });
                trials.push(trial);
            }
        }
    }
    verdict(trials);
}

#[test]
fn h11_a_ball_that_is_suddenly_in_the_cloth_or_gone() {
    const N: usize = 32;
    let ball = Sphere::new(0.3);
    let mut trials = Vec::new();
    for variant in Variant::all() {
        let sheet = variant.sheet(Vec2::ONE, N, N);
        let last = (N * N) as u32 - 1;
        let pins = [0, N as u32 - 1, last + 1 - N as u32, last];
        let mut trial = Trial::new("ball put into it", variant, sheet, &pins, |_, p| p);
        trial.run(60, &[]);
        trial.measure_anew();
        // Into the cloth, off above it, into it, off below it, a frame at each.
        let at = |y: f32| Pose::from_translation(Vec3::new(0.02, y, 0.01));
        for &y in [-0.25, 2.0, 0.2, -2.0].iter().cycle().take(80) {
            trial.frame(&[Collider::new(&ball, at(y))]);
        }
        // There to stay.
        trial.run(120, &[Collider::new(&ball, at(-0.25))]);
        let nearest = trial
            .places()
            .iter()
            .map(|p| (*p - at(-0.25).translation).length())
            .fold(9.0, f32::min);
        trial.require(nearest > 0.3049, |_| format!("{nearest} m from its middle"));
        // It shrinks to nearly nothing: nothing itself is refused.
        for i in 0..60 {
            let pose = |i: usize| Pose { scale: 1e-4_f32.max(1.0 - i as f32 / 60.0), ..at(-0.25) };
            trial.frame(&[Collider::new(&ball, pose(i)).moving_to(pose(i + 1))]);
        }
        trial.run_on();
        // Each coming pushes particles at 2 m/s, and threads pull at those that are let go.
        let fastest = trial.fastest;
        trial.require(fastest < 10.0, |_| format!("{fastest} m/s"));
        trial.recovers_within([3, 120, 3]);
        trials.push(trial);
    }
    verdict(trials);
}
