//! Rest shapes in use: equal cloths share one, and the last cloth takes it with it.

use super::weights::Factors;
use crate::{
    mesh::{Connection, MeshProblem, MeshShape, RestShape},
    solver::{Lattice, LatticeError, MassLumping},
};
use bevy::{platform::collections::HashMap, prelude::*};
use std::sync::{Arc, Weak};

/// Everything that the solver's view of a rest shape depends on.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct TopologyKey {
    shape: ShapeKey,
    lumping: MassLumping,
    /// Fingerprint of the factors of mass and stiffness.
    factors: Option<u64>,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum ShapeKey {
    Sheet { size: [u32; 2], particles: UVec2 },
    Mesh { fingerprint: u64, scale: u32 },
}

/// The rest shapes in use.
#[derive(Resource, Default)]
pub(crate) struct RestCache {
    meshes: HashMap<u64, Weak<MeshShape>>,
    lattices: HashMap<TopologyKey, Weak<Lattice>>,
}

impl RestCache {
    /// The rest shape of a mesh, made only if no cloth has it.
    pub fn mesh(
        &mut self,
        fingerprint: u64,
        make: impl FnOnce() -> Result<MeshShape, MeshProblem>,
    ) -> Result<Arc<MeshShape>, MeshProblem> {
        if let Some(shape) = self.meshes.get(&fingerprint).and_then(Weak::upgrade) {
            return Ok(shape);
        }
        let shape = Arc::new(make()?);
        self.meshes.retain(|_, other| other.strong_count() > 0);
        self.meshes.insert(fingerprint, Arc::downgrade(&shape));
        Ok(shape)
    }

    /// A rest shape as the solver has it, made larger by `scale`.
    pub fn topology(
        &mut self,
        rest: &RestShape,
        scale: f32,
        lumping: MassLumping,
        factors: Option<&Factors>,
    ) -> Result<Arc<Lattice>, LatticeError> {
        let shape = match rest {
            RestShape::Sheet { size, particles } => ShapeKey::Sheet {
                size: (*size * scale).to_array().map(f32::to_bits),
                particles: *particles,
            },
            RestShape::Mesh(shape) => {
                ShapeKey::Mesh { fingerprint: shape.fingerprint, scale: scale.to_bits() }
            }
        };
        let key = TopologyKey { shape, lumping, factors: factors.map(Factors::fingerprint) };
        if let Some(lattice) = self.lattices.get(&key).and_then(Weak::upgrade) {
            return Ok(lattice);
        }
        let lattice = Arc::new(lattice(rest, scale, lumping, factors)?);
        self.lattices.retain(|_, other| other.strong_count() > 0);
        self.lattices.insert(key, Arc::downgrade(&lattice));
        Ok(lattice)
    }
}

fn lattice(
    rest: &RestShape,
    scale: f32,
    lumping: MassLumping,
    factors: Option<&Factors>,
) -> Result<Lattice, LatticeError> {
    let lattice = match rest {
        RestShape::Sheet { size, particles } => {
            let (rows, columns) = (particles.y as usize, particles.x as usize);
            Lattice::sheet(*size * scale, rows, columns, lumping)?
        }
        RestShape::Mesh(shape) => {
            let positions: Vec<_> = shape.positions.iter().map(|p| *p * scale).collect();
            match shape.connection {
                Connection::Grid { rows, columns } => {
                    Lattice::new(rows, columns, &positions, lumping)?
                }
                Connection::Triangles(_) => {
                    return Err(LatticeError::TooSmall { rows: 0, columns: 0 });
                }
            }
        }
    };
    match factors {
        Some(factors) => lattice.with_weights(&factors.mass, &factors.stiffness),
        None => Ok(lattice),
    }
}
