//! The shape of a cloth at rest.

use std::sync::Arc;

use bevy::prelude::*;

use crate::mesh::background::LARGE;
use crate::mesh::intake::{ClothIntake, MeshShape};

/// The shape of a cloth at rest, in its entity's frame.
#[derive(Clone, Debug)]
pub(crate) enum RestShape {
    Sheet { size: Vec2, particles: UVec2 },
    Mesh(Arc<MeshShape>),
}

impl RestShape {
    /// Whether another is the same one.
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Sheet { size, particles },
                Self::Sheet { size: other_size, particles: others },
            ) => size == other_size && particles == others,
            (Self::Mesh(shape), Self::Mesh(other)) => Arc::ptr_eq(shape, other),
            _ => false,
        }
    }

    pub fn particle_count(&self) -> usize {
        match self {
            Self::Sheet { particles, .. } => particles.x as usize * particles.y as usize,
            Self::Mesh(shape) => shape.positions.len(),
        }
    }

    /// Whether it is a mesh that is worked on in the background.
    pub fn is_large_mesh(&self) -> bool {
        matches!(self, Self::Mesh(_)) && self.particle_count() >= LARGE
    }

    pub fn vertex_count(&self) -> usize {
        match self {
            Self::Sheet { .. } => self.particle_count(),
            Self::Mesh(shape) => shape.particle_of_vertex.len(),
        }
    }

    /// The particle of a vertex; `None` where there is no such vertex, or no triangle uses it.
    pub fn particle_of(&self, vertex: u32) -> Option<u32> {
        match self {
            Self::Sheet { .. } => ((vertex as usize) < self.particle_count()).then_some(vertex),
            Self::Mesh(shape) => shape.particle_of(vertex),
        }
    }

    /// The vertices that triangles use, and their particles.
    pub fn used_vertices(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let (same, shape) = match self {
            Self::Sheet { .. } => (self.particle_count(), None),
            Self::Mesh(shape) => (0, Some(shape)),
        };
        let mapped = shape.into_iter().flat_map(|shape| shape.used_vertices());
        (0..same).map(|i| (i, i)).chain(mapped)
    }

    /// Vertex colours, where the mesh has any.
    pub fn colors(&self) -> Option<&[[f32; 4]]> {
        match self {
            Self::Sheet { .. } => None,
            Self::Mesh(shape) => shape.colors.as_deref(),
        }
    }

    /// The intake's findings about the mesh.
    pub fn intake(&self) -> Option<&ClothIntake> {
        match self {
            Self::Sheet { .. } => None,
            Self::Mesh(shape) => Some(&shape.intake),
        }
    }
}

/// The particles of a sheet, row by row.
pub(crate) fn sheet_points(size: Vec2, particles: UVec2) -> Vec<Vec3> {
    let last = (particles - 1).as_vec2();
    let at = |i: u32| UVec2::new(i % particles.x, i / particles.x).as_vec2() / last - 0.5;
    (0..particles.x * particles.y).map(|i| size * at(i)).map(|p| Vec3::new(p.x, 0.0, p.y)).collect()
}
