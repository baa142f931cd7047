//! Lattices of sheets: equal sheets share one.

use crate::solver::{Lattice, LatticeError, MassLumping};
use bevy::{platform::collections::HashMap, prelude::*};
use std::sync::{Arc, Weak};

/// Everything that the lattice of a sheet depends on.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct SheetKey {
    size: [u32; 2],
    particles: UVec2,
    lumping: MassLumping,
}

/// The lattices of sheets in use.
#[derive(Resource, Default)]
pub(crate) struct LatticeCache(HashMap<SheetKey, Weak<Lattice>>);

impl LatticeCache {
    /// The lattice of a sheet, shared with all equal ones.
    pub fn sheet(
        &mut self,
        size: Vec2,
        particles: UVec2,
        lumping: MassLumping,
    ) -> Result<Arc<Lattice>, LatticeError> {
        let key = SheetKey { size: size.to_array().map(f32::to_bits), particles, lumping };
        if let Some(lattice) = self.0.get(&key).and_then(Weak::upgrade) {
            return Ok(lattice);
        }
        let (rows, columns) = (particles.y as usize, particles.x as usize);
        let lattice = Arc::new(Lattice::sheet(size, rows, columns, lumping)?);
        self.0.retain(|_, other| other.strong_count() > 0);
        self.0.insert(key, Arc::downgrade(&lattice));
        Ok(lattice)
    }
}
