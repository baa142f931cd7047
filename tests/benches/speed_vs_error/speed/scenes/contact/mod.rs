//! P9 to P12: cloth at rest on solids, struck by fast ones, on thin ones, and pulled over them; the cloth that a user gets.

pub mod capstan;
pub mod fast;
pub mod peers;
pub mod poke;
pub mod rest;

use std::sync::Arc;

use bevy::math::{Vec2, Vec3, primitives::InfinitePlane3d};
use bevy_drape::{
    sdf::SignedDistance,
    solver::{
        ClothSolver, Collider, Lattice, MassLumping, Material, Pose, Settings, Substeps, Topology,
    },
};

use super::super::{Extent, Outcome};
use super::irregular;

/// A cloth as a user gets it, but for its budget of substeps.
#[derive(Clone, Copy)]
struct Cloth {
    side: f32,
    n: usize,
    /// Whether it is a mesh whose vertices are jittered and whose diagonals go either way, or a sheet.
    is_mesh: bool,
    budget: u32,
}

impl Cloth {
    fn method(&self) -> &'static str {
        if self.is_mesh { "mesh" } else { "sheet" }
    }

    fn knob(&self) -> String {
        format!("budget {}", self.budget)
    }

    /// Those that a scene is measured with, of so many particles a side.
    fn all(side: f32, n: usize, extent: Extent) -> Vec<Self> {
        let kinds: &[_] = if extent.quick {
            &[(false, 20)]
        } else {
            &[(false, 20), (false, 8), (true, 20), (true, 8)]
        };
        kinds.iter().map(|&(is_mesh, budget)| Self { side, n, is_mesh, budget }).collect()
    }

    fn topology(&self) -> Outcome<Topology> {
        let Self { side, n, is_mesh, .. } = *self;
        if !is_mesh {
            let lattice = Lattice::sheet(Vec2::splat(side), n, n, MassLumping::Lumped)?;
            return Ok(Arc::new(lattice).into());
        }
        irregular::square(side, n, MassLumping::Lumped)
    }

    /// The corners of its cells: two of a row, and two of the next.
    fn cells(&self) -> impl Iterator<Item = [u32; 4]> {
        let n = self.n as u32;
        let first = (0..n - 1).flat_map(move |row| (0..n - 1).map(move |column| row * n + column));
        first.map(move |a| [a, a + 1, a + n, a + n + 1])
    }

    /// It starts where `place` puts its particles.
    fn solver(&self, material: Material, place: impl Fn(Vec3) -> Vec3) -> Outcome<ClothSolver> {
        let topology = self.topology()?;
        let start: Vec<_> = topology.rest_positions().iter().map(|&at| place(at)).collect();
        let substeps = Substeps::Automatic { budget: self.budget };
        let settings = Settings { substeps, ..Settings::default() };
        let mut solver = ClothSolver::new(topology, &start, material, settings)?;
        solver.set_shared(false);
        Ok(solver)
    }
}

/// A solid over the ground.
fn over_ground<'a>(
    ground: &'a InfinitePlane3d,
    solid: &'a dyn SignedDistance,
    pose: Pose,
) -> [Collider<'a>; 2] {
    [Collider::new(ground, Pose::IDENTITY), Collider::new(solid, pose)]
}

fn ground() -> InfinitePlane3d {
    InfinitePlane3d::new(Vec3::Y)
}

fn places(cloth: &ClothSolver) -> Vec<Vec3> {
    (0..cloth.topology().particle_count()).map(|i| cloth.position(i)).collect()
}
