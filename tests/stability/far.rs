//! One and ten kilometres from the world's origin. Truth: the bits of the same scene at the origin, where all
//! poses are representable in both places.
//!
//! Free flight far away: `tests/solver/free_flight.rs`. Here is what has pins, colliders that move, air and
//! friction.

use crate::support::{kinds::*, solver::*};
use bevy::math::{Quat, Vec2, Vec3, primitives::Cuboid};
use bevy_drape::solver::{
    Air, Collider, Graph, MassLumping, Pose, Settings, StepInput, Topology, Wind,
};
use std::sync::Arc;

/// Neither more nor less is representable at ten kilometres \[m\].
const GRID: f32 = 1.0 / 1024.0;
const N: usize = 17;
const CELL: f32 = 1.0 / 16.0;

/// Cloths whose particles lie on the grid.
fn kinds() -> Vec<Kind> {
    let (positions, triangles) = jittered(N, N, CELL, 0.25, 7);
    let positions: Vec<_> = positions.iter().map(|&p| (p / GRID).round() * GRID).collect();
    let graph = Graph::new(&positions, &triangles, MassLumping::Lumped).unwrap();
    let topologies: [(&str, Topology); 2] = [
        ("lattice", sheet(Vec2::ONE, N, N, MassLumping::Lumped).into()),
        ("graph", Arc::new(graph).into()),
    ];
    let materials = [("automatic", usual()), ("stiffest", stiffest())];
    topologies
        .into_iter()
        .flat_map(|(name, topology)| {
            materials.map(|(what, material)| Kind {
                what: format!("{name}, {what}"),
                topology: topology.clone(),
                material,
                settings: Settings::default(),
            })
        })
        .collect()
}

/// A cloth that is blown over a box which moves and turns, held by a corner that is led up and down: bits in
/// its own coordinates.
fn scene(kind: &Kind, offset: Vec3) -> Vec<[u32; 6]> {
    let block = Cuboid::new(0.5, 0.25, 0.5);
    let mut solver = kind.solver(Quat::IDENTITY, offset);
    solver.set_air(Some(Air::default())).unwrap();
    solver.set_pins(&[0]).unwrap();
    let wave = |tick: usize| (tick % 64).abs_diff(32) as f32 / 32.0 - 0.5;
    let path = |p: Vec3, t: f32| p + Vec3::Y * 0.5 * wave((t / TICK).round() as usize);
    let led = Led::new(&solver, &path);
    let mut contacts = 0;
    for tick in 0..TEN_SECONDS {
        let pose = |tick: usize| Pose {
            translation: offset + Vec3::new(0.5 * wave(tick), -0.5, 0.25),
            rotation: Quat::from_rotation_y(0.01 * tick as f32),
            scale: 1.0,
        };
        let colliders = [Collider::new(&block, pose(tick)).moving_to(pose(tick + 1))];
        let input = StepInput {
            dt: TICK,
            gravity: GRAVITY,
            pins: &led.motions(tick),
            colliders: &colliders,
            wind: Wind { velocity: Vec3::new(1.0, 0.0, 2.0), ..Wind::default() },
            ..StepInput::default()
        };
        contacts += solver.tick(&input).unwrap().contact_count;
        look(&solver, &kind.what, Within(offset - 4.0, offset + 4.0));
    }
    assert!(contacts > 300, "{}: it hardly met the box, {contacts}", kind.what);
    bits(&solver)
}

#[test]
fn h18_one_and_ten_kilometres_away_it_is_the_same_to_the_bit() {
    for kind in kinds() {
        let here = scene(&kind, Vec3::ZERO);
        for away in [Vec3::new(1024.0, 0.0, -512.0), Vec3::new(-10_240.0, 1024.0, 10_240.0)] {
            assert!(here == scene(&kind, away), "{} at {away}", kind.what);
        }
    }
}
