//! What hangs from a body that stands still pulls at it by its weight.

use bevy::math::{Mat3, Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, Material, Mobility, PinMotion, PinPull, Pose, Settings, StepInput,
    Topology,
};

use crate::bodies::GRAVITY;
use crate::support::{sheets::mesh, solver::*};

const SIDE: usize = 20;

/// The force that a metre of cloth pulls with at a body which its first row is pinned to, and the weight of the rest of it \[N\].
fn pull(is_mesh: bool, budget: u32) -> (f32, f32) {
    let topology: Topology = match is_mesh {
        true => mesh(SIDE, SIDE, 1.0 / (SIDE - 1) as f32, 0.3).into(),
        false => sheet(Vec2::ONE, SIDE, SIDE, Settings::default().lumping).into(),
    };
    let material = Material { drag: 4.0, ..Material::default() };
    let substeps = bevy_drape::solver::Substeps::Automatic { budget };
    let settings = Settings { substeps, ..Settings::default() };
    // Hanging straight down.
    let flat: Vec<_> = topology.rest_positions().to_vec();
    let top = flat.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
    let hung: Vec<_> = flat.iter().map(|p| Vec3::new(p.x, top - p.z, 0.0)).collect();
    let mut cloth = ClothSolver::new(topology, &hung, material, settings).unwrap();
    let row: Vec<_> = (0..hung.len()).filter(|&i| hung[i].y > -1e-4).collect();
    assert_eq!(row.len(), SIDE);
    cloth.set_pins(&row.iter().map(|&i| i as u32).collect::<Vec<_>>()).unwrap();
    // Its first row has half of the cells beside it.
    let weight = GRAVITY * material.area_density * (1.0 - 0.5 / (SIDE - 1) as f32);
    let mobility = Mobility {
        inverse_mass: 0.2,
        inverse_inertia: Mat3::from_diagonal(Vec3::splat(1.0)),
        informed: false,
    };
    let shape = Sphere::new(0.1);
    let away = Pose::from_translation(Vec3::Y * 2.0);
    let body = Collider { key: 1, body: 7, ..Collider::new(&shape, away) };
    let colliders = [body.moved_by(mobility, Vec3::ZERO)];
    let pins: Vec<_> = row.iter().map(|&i| PinMotion::still(hung[i])).collect();
    let pulls: Vec<_> = (0..SIDE as u32).map(|pin| PinPull { pin, body: 7 }).collect();
    let input = StepInput {
        dt: TICK,
        gravity: Vec3::NEG_Y * GRAVITY,
        pins: &pins,
        pulls: &pulls,
        colliders: &colliders,
        ..StepInput::default()
    };
    let mut given = 0.0;
    for tick in 0..320 {
        cloth.tick(&input).unwrap();
        given += if tick < 256 { 0.0 } else { cloth.impulse(0).linear.y };
    }
    (-given / (64.0 * TICK), weight)
}

#[test]
fn what_hangs_from_a_body_pulls_at_it_by_its_weight() {
    for is_mesh in [false, true] {
        for budget in [8, 20] {
            let (pull, weight) = pull(is_mesh, budget);
            let what = format!("mesh {is_mesh}, {budget} substeps: pull, of the weight");
            check(&what, (pull / weight).into(), 1.0, 0.02);
        }
    }
}
