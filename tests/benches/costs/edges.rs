//! Edges that are held out of solids, where particles are far apart beside what they lie on: a garment's proxy on a body.

use std::{error::Error, sync::Arc};

use crate::{
    solver::{Scene, compare},
    turns::{Bound, Wrong, heading, line},
};
use bevy::math::{
    Vec2, Vec3,
    primitives::{Cuboid, Sphere},
};
use bevy_drape::{
    sdf::{
        SignedDistance,
        shapes::{CapsuleBetween, Shell},
    },
    solver::{Collider, Lattice, MassLumping, Pose},
};

/// Particles a side of a square metre.
const FEW: usize = 16;

/// The surface of a cube, as a level has it.
fn crate_of_a_level(side: f32) -> Result<Shell, Box<dyn Error>> {
    let half = |corner: usize, axis: usize| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 };
    let corner = |i| side * Vec3::new(half(i, 0), half(i, 1), half(i, 2));
    let corners: Vec<_> = (0..8).map(corner).collect();
    let sides =
        [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    let halves = |[a, b, c, d]: [u32; 4]| [a, b, c, b, d, c];
    Ok(Shell::new(&corners, &sides.map(halves).concat(), 0.01)?)
}

/// A cloth of few particles that comes to lie on solids, whose edges are held or not.
pub fn edges(rounds: usize, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let limb = CapsuleBetween {
        from: Vec3::new(-0.4, 0.0, 0.1),
        to: Vec3::new(0.4, 0.0, -0.1),
        radius: 0.1,
    };
    let (ball, cube, shell) = (Sphere::new(0.15), Cuboid::from_length(0.4), crate_of_a_level(0.4)?);
    let lattice = Arc::new(Lattice::sheet(Vec2::ONE, FEW, FEW, MassLumping::Lumped)?);
    heading("edges held, us a tick, 16 x 16 on a square metre", "without", "with");
    let solids: [(&str, &dyn SignedDistance, f32); 4] = [
        ("on a capsule of 10 cm", &limb, 0.12),
        ("on a ball of 15 cm", &ball, 0.17),
        ("on a cube of 40 cm", &cube, 0.22),
        ("on the surface of a cube", &shell, 0.23),
    ];
    for (name, solid, above) in solids {
        let colliders = [Collider::new(solid, Pose::from_translation(Vec3::NEG_Y * above))];
        let with = Scene::new(lattice.clone().into(), 1e-5)?.among(&colliders);
        let without = with.clone().without_edges()?;
        let turns = compare(name, rounds, (&without, with), false, wrong);
        line(name, &turns, Bound::None);
    }
    Ok(())
}
