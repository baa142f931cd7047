//! Ways to run a solver.

use bevy::math::Vec3;
use bevy_drape::solver::{
    ClothSolver, Collider, Material, PinMotion, Settings, StepInput, TickReport, Topology,
};

/// Bevy's default step \[s\].
pub const TICK: f32 = 1.0 / 64.0;
/// The Earth's \[m/s²\].
pub const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

/// A cloth in its rest shape, moved by `offset`.
pub fn at_rest<T: Clone + Into<Topology>>(
    topology: &T,
    offset: Vec3,
    material: Material,
    settings: Settings,
) -> ClothSolver {
    let topology: Topology = topology.clone().into();
    let positions: Vec<_> = topology.rest_positions().iter().map(|&p| p + offset).collect();
    ClothSolver::new(topology, &positions, material, settings).unwrap()
}

/// Pins, then soft pins, that stay where their particles are.
pub fn still(solver: &ClothSolver) -> Vec<PinMotion> {
    let soft = solver.soft_pins().map(|pin| pin.particle);
    let held = solver.pins().iter().copied().chain(soft);
    held.map(|p| PinMotion::still(solver.position(p as usize))).collect()
}

/// Takes ticks with the pins where they are.
pub fn run(
    solver: &mut ClothSolver,
    ticks: usize,
    gravity: Vec3,
    colliders: &[Collider<'_>],
) -> TickReport {
    let pins = still(solver);
    let input = StepInput { dt: TICK, gravity, pins: &pins, colliders, ..StepInput::default() };
    let mut report = TickReport::default();
    for _ in 0..ticks {
        report = solver.tick(&input).unwrap();
    }
    report
}
