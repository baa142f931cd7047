//! Factors of the mass and the stiffness of particles.

use std::hash::{DefaultHasher, Hasher};

use bevy::prelude::*;

/// Factors of all particles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Factors {
    pub mass: Vec<f32>,
    pub stiffness: Vec<f32>,
}

impl Factors {
    /// Tells these factors from others.
    pub fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write(bytemuck::cast_slice(&self.mass));
        hasher.write(bytemuck::cast_slice(&self.stiffness));
        hasher.finish()
    }
}
