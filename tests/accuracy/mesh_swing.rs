//! An irregular sheet that hangs from a bar swings in its first mode. Held to the closed form of the inextensible chain
//! (Daniel Bernoulli 1732): the shape `J0(2 w sqrt(y / g))`, at the frequency `1.202413 sqrt(g / L)`; without drag it keeps
//! its amplitude.

use bevy::math::Vec3;
use bevy_drape::solver::{ClothSolver, Material, Settings, Substeps};

use crate::support::solver::*;

const SIDE: usize = 16;
/// The first zero of the Bessel function J0.
const ZERO: f32 = 2.404826;
/// The frequency of the first mode, over `sqrt(g / L)`.
const FIRST: f64 = 1.202413;
/// Largest velocity at the start [m/s].
const SPEED: f32 = 0.05;
const SECONDS: usize = 14;

/// The Bessel function of order zero, by its series; to 1e-6 up to its first zero.
fn j0(x: f32) -> f32 {
    let quarter = x * x / 4.0;
    let terms = (1..12).scan(1.0, |term, k| {
        *term *= -quarter / (k * k) as f32;
        Some(*term)
    });
    1.0 + terms.sum::<f32>()
}

/// The mode at a place, whose bar is at the height of the origin.
fn mode(place: Vec3) -> f32 {
    j0(ZERO * (1.0 + place.y).max(0.0).sqrt())
}

/// The mode's amplitudes after each tick, and the part of the first period's amplitude that is left in the last one.
fn swing(substeps: u32) -> (Vec<f64>, f64) {
    let graph = mesh(SIDE, SIDE, 1.0 / (SIDE - 1) as f32, 0.25);
    let hung: Vec<_> = graph.rest_positions().iter().map(|&p| Vec3::new(p.x, -p.z, 0.0)).collect();
    let material = Material { drag: 0.0, damping: 0.0, bending_friction: 0.0, ..Material::USUAL };
    let settings = Settings { substeps: Substeps::Fixed(substeps), ..Settings::default() };
    let mut solver = ClothSolver::new(graph, &hung, material, settings).unwrap();
    solver.set_pins(&(0..SIDE as u32).collect::<Vec<_>>()).unwrap();
    // Its threads come to their length.
    run(&mut solver, 128, GRAVITY, &[]);
    for particle in SIDE..SIDE * SIDE {
        let velocity = Vec3::Z * SPEED * mode(solver.position(particle));
        solver.set_velocity(particle, velocity).unwrap();
    }
    let amplitudes: Vec<f64> = (0..SECONDS * 64)
        .map(|_| {
            run(&mut solver, 1, GRAVITY, &[]);
            let part = |i: usize| {
                let place = solver.position(i);
                f64::from(place.z * mode(place) * solver.mass(i))
            };
            (0..SIDE * SIDE).map(part).sum()
        })
        .collect();
    let largest = |part: &[f64]| part.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
    let kept = largest(&amplitudes[amplitudes.len() - 128..]) / largest(&amplitudes[..128]);
    (amplitudes, kept)
}

/// The mean time between two passages upwards [s].
fn period(amplitudes: &[f64]) -> f64 {
    let passages: Vec<f64> = amplitudes
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
        .map(|(tick, pair)| tick as f64 - pair[0] / (pair[1] - pair[0]))
        .collect();
    (passages[passages.len() - 1] - passages[0]) / (passages.len() - 1) as f64 * f64::from(TICK)
}

#[test]
fn an_irregular_sheet_swings_as_a_chain_and_keeps_its_amplitude() {
    // Chains of edges that carry nothing on from substep to substep keep 0.60 and 0.90.
    for (substeps, kept) in [(8, 0.9), (20, 0.98)] {
        let (amplitudes, left) = swing(substeps);
        check(
            &format!("amplitude left after {SECONDS} s, {substeps} substeps"),
            left,
            1.0,
            1.0 - kept,
        );
        let exact = std::f64::consts::TAU / (FIRST * 9.81_f64.sqrt());
        check("its period [s]", period(&amplitudes), exact, 0.01 * exact);
    }
}
