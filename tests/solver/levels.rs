//! Cloths on the ground of a level: an open surface of many triangles, with a thickness.

use bevy::math::{Vec2, Vec3};
use bevy_drape::sdf::shapes::Shell;
use bevy_drape::solver::{Collider, MassLumping, Pose, Settings, StepInput};

use crate::support::solver::*;

/// Half of the ground's thickness \[m\].
const RADIUS: f32 = 0.01;

/// Height of the ground: hills, and a ridge as sharp as a roof's.
fn height(x: f32, z: f32) -> f32 {
    0.05 * (3.0 * x).sin() * (2.0 * z).cos() - 0.2 * (x - 0.1).abs()
}

/// Four by four metres in 20,000 triangles.
fn ground() -> Shell {
    const SIDE: usize = 100;
    let place = |i: usize| 4.0 * i as f32 / SIDE as f32 - 2.0;
    let vertex = |k: usize| {
        let (x, z) = (place(k % (SIDE + 1)), place(k / (SIDE + 1)));
        Vec3::new(x, height(x, z), z)
    };
    let vertices: Vec<Vec3> = (0..(SIDE + 1).pow(2)).map(vertex).collect();
    let cells = (0..SIDE * SIDE).map(|k| ((k / SIDE * (SIDE + 1) + k % SIDE) as u32, k % 2 == 0));
    let indices: Vec<u32> =
        cells.flat_map(|(at, side)| halves(at, SIDE + 1, side).into_iter().flatten()).collect();
    Shell::new(&vertices, &indices, RADIUS).unwrap()
}

/// Thrown at it, a cloth does not come through, and comes to rest on it.
#[test]
fn a_cloth_lies_on_a_level() {
    let ground = ground();
    let collider = Collider::new(&ground, Pose::IDENTITY);
    for speed in [0.0, 15.0] {
        let lattice = sheet(Vec2::ONE, 64, 64, MassLumping::Lumped);
        let mut solver = at_rest(&lattice, Vec3::Y * 0.3, usual(), Settings::default());
        for i in 0..lattice.particle_count() {
            solver.set_velocity(i, Vec3::NEG_Y * speed).unwrap();
        }
        for tick in 0..64 * 8 {
            let input = StepInput {
                dt: TICK,
                gravity: GRAVITY,
                colliders: &[collider],
                ..StepInput::default()
            };
            solver.tick(&input).unwrap();
            if tick % 8 == 0 {
                let through = positions(&solver).into_iter().find(|p| p.y < height(p.x, p.z));
                assert_eq!(through, None, "{speed} m/s, tick {tick}");
            }
        }
        let squared = velocities(&solver).into_iter().map(|v| v.as_dvec3().length_squared());
        let rms = (squared.sum::<f64>() / lattice.particle_count() as f64).sqrt();
        check_at_most("rms of velocities after 8 s [m/s]", rms, 1e-4);
        check_at_most("largest strain", largest(&strains(&solver)), 0.01);
    }
}
