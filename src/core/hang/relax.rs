//! From a shape that is nearly at rest to rest, under the solver's own forces.

use bevy_math::Vec3;

use crate::solver::{ClothSolver, Material, SolverError, StepInput};

/// Time over which speeds are measured \[s\]: long enough that what trembles on the spot has none.
const WINDOW: f32 = 0.25;
/// How far a free particle is pushed to one side at first, relative to a spring: a sheet that lies in a
/// plane would never leave it, however much it is compressed.
const NUDGE: f32 = 0.02;

/// When a relaxation ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation {
    /// Speed below which all particles have to be [m/s]. Lower comes closer to rest and takes longer.
    pub speed: f32,
    /// Time that may be simulated \[s\], whether or not the cloth is at rest by then.
    pub longest: f32,
}

impl Default for Relaxation {
    fn default() -> Self {
        Self { speed: 0.002, longest: 30.0 }
    }
}

/// How a relaxation went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxReport {
    /// Ticks taken.
    pub ticks: u32,
    /// Largest speed along any axis over the last quarter of a second [m/s].
    pub speed: f32,
    /// Whether that is below the limit; else the time was over.
    pub at_rest: bool,
}

/// Lets a cloth come to rest under its own forces and those of the input, which stays what it is: pins
/// that do not move, gravity, and whatever else is there.
///
/// The cloth is braked meanwhile, by drag in place of its own and of its air's, at the rate at which a
/// pendulum as long as the cloth swings no more. Afterwards both are what they were, and nothing moves. Springs go on to bear what they bore.
/// The same cloth and input give the same bits.
///
/// # Errors
/// [`SolverError`], as [`ClothSolver::tick`].
pub fn relax(
    solver: &mut ClothSolver,
    input: &StepInput<'_>,
    limits: Relaxation,
) -> Result<RelaxReport, SolverError> {
    let (material, air) = (*solver.material(), solver.air().copied());
    solver.set_air(None)?;
    nudge(solver, input.gravity);
    let outcome = brake(solver, input, limits);
    solver.set_material(material)?;
    solver.set_air(air)?;
    solver.stop();
    outcome
}

fn brake(
    solver: &mut ClothSolver,
    input: &StepInput<'_>,
    limits: Relaxation,
) -> Result<RelaxReport, SolverError> {
    let material = *solver.material();
    solver.set_material(Material { drag: drag(solver, input.gravity), ..material })?;
    let window = (WINDOW / input.dt).ceil().max(1.0) as u32;
    let most = (limits.longest / input.dt).ceil() as u32;
    let mut report = RelaxReport { ticks: 0, speed: f32::INFINITY, at_rest: false };
    while report.ticks < most && !report.at_rest {
        solver.mark();
        let count = window.min(most - report.ticks);
        for _ in 0..count {
            solver.tick(input)?;
        }
        report.ticks += count;
        report.speed = solver.distance_from_mark() / (count as f32 * input.dt);
        report.at_rest = report.speed <= limits.speed;
    }
    Ok(report)
}

/// The rate of drag [1/s] that stops a pendulum of the cloth's height soonest.
fn drag(solver: &ClothSolver, gravity: Vec3) -> f32 {
    let (min, max) = solver.bounds();
    let down = gravity.normalize_or(Vec3::NEG_Y);
    // What lies level now will hang, or lie on something.
    let least = 0.5 * solver.topology().total_area().sqrt();
    let height = (max - min).dot(down.abs()).max(least);
    // A plate that hangs from its edge swings as a pendulum of two thirds of its height.
    2.0 * (1.5 * gravity.length().max(1.0) / height).sqrt()
}

/// Pushes every free particle to one side or the other, evenly spread and always alike.
fn nudge(solver: &mut ClothSolver, gravity: Vec3) {
    let springs = solver.topology().structural_springs().map(|(_, _, rest)| rest);
    let spring = springs.fold(f32::INFINITY, f32::min);
    let aside = gravity.normalize_or(Vec3::NEG_Y).any_orthonormal_vector();
    let other = gravity.normalize_or(Vec3::NEG_Y).cross(aside);
    for particle in 0..solver.topology().particle_count() {
        if solver.pins().binary_search(&(particle as u32)).is_ok() {
            continue;
        }
        let [a, b] = [0, 1].map(|axis| part(2 * particle as u32 + axis));
        let place = solver.position(particle) + NUDGE * spring * (a * aside + b * other);
        // Next to where it was, which could be used.
        let _ = solver.set_position(particle, place);
    }
}

/// A number from -1 to 1 that looks drawn by lot (the hash pcg of Jarzynski and Olano 2020).
fn part(of: u32) -> f32 {
    let state = of.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    let hash = (word >> 22) ^ word;
    (hash >> 8) as f32 / (1_u32 << 23) as f32 - 1.0
}
