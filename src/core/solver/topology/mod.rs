//! The topology of a cloth, which joins its particles: a lattice, or a graph.

pub(crate) mod buckets;
pub(crate) mod geodesic;
pub(crate) mod graph;
pub(crate) mod lattice;
pub(crate) mod wide_hinges;

use std::sync::Arc;

use bevy_math::Vec3;

use crate::solver::settings::{MassLumping, Material};
use crate::solver::simd::layout::Layout;
use crate::solver::topology::graph::Graph;
use crate::solver::topology::lattice::Lattice;

/// The rest shape of a cloth: immutable, shared by equal cloths.
#[derive(Clone, Debug)]
pub enum Topology {
    /// A rectangular sheet, whose particles are counted row by row.
    Lattice(Arc<Lattice>),
    /// Any triangle mesh, whose particles are counted as they were given.
    Graph(Arc<Graph>),
}

impl From<Arc<Lattice>> for Topology {
    fn from(lattice: Arc<Lattice>) -> Self {
        Self::Lattice(lattice)
    }
}

impl From<Arc<Graph>> for Topology {
    fn from(graph: Arc<Graph>) -> Self {
        Self::Graph(graph)
    }
}

impl Topology {
    /// The lattice, where it is one.
    pub fn as_lattice(&self) -> Option<&Arc<Lattice>> {
        match self {
            Self::Lattice(lattice) => Some(lattice),
            Self::Graph(_) => None,
        }
    }

    /// The graph, where it is one.
    pub fn as_graph(&self) -> Option<&Arc<Graph>> {
        match self {
            Self::Lattice(_) => None,
            Self::Graph(graph) => Some(graph),
        }
    }

    /// Number of particles.
    pub fn particle_count(&self) -> usize {
        self.rest_positions().len()
    }

    /// Rest positions \[m\], in the order of the particles.
    pub fn rest_positions(&self) -> &[Vec3] {
        match self {
            Self::Lattice(lattice) => lattice.rest_positions(),
            Self::Graph(graph) => graph.rest_positions(),
        }
    }

    /// The structural springs: both particles and the rest length \[m\].
    pub fn structural_springs(&self) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
        let lattice = self.as_lattice().into_iter().flat_map(|l| l.structural_springs());
        let graph = self.as_graph().into_iter().flat_map(|g| g.structural_springs());
        lattice.chain(graph)
    }

    /// Number of structural and shear springs.
    pub fn spring_count(&self) -> usize {
        match self {
            Self::Lattice(lattice) => lattice.spring_count(),
            Self::Graph(graph) => graph.spring_count(),
        }
    }

    /// Area of the cloth at rest \[m2\].
    pub fn total_area(&self) -> f32 {
        match self {
            Self::Lattice(lattice) => lattice.total_area(),
            Self::Graph(graph) => graph.total_area(),
        }
    }

    /// How the area is shared out to the particles.
    pub fn lumping(&self) -> MassLumping {
        match self {
            Self::Lattice(lattice) => lattice.lumping,
            Self::Graph(graph) => graph.lumping,
        }
    }

    /// How the particles lie in memory: a graph's in pages, in an order of their own.
    pub(crate) fn layout(&self) -> Layout {
        match self {
            Self::Lattice(lattice) => lattice.layout,
            Self::Graph(graph) => graph.layout,
        }
    }

    /// The slot of a particle.
    pub(crate) fn slot(&self, particle: usize) -> usize {
        match self {
            Self::Lattice(lattice) => {
                let columns = lattice.layout.columns;
                lattice.layout.slot(particle / columns, particle % columns)
            }
            Self::Graph(graph) => graph.slot(particle),
        }
    }

    /// The particle of a slot.
    pub(crate) fn particle(&self, slot: usize) -> usize {
        match self {
            Self::Lattice(lattice) => {
                let layout = lattice.layout;
                let from = slot - layout.slot(0, 0);
                from / layout.stride * layout.columns + from % layout.stride
            }
            Self::Graph(graph) => graph.particle(slot),
        }
    }

    /// Area of cloth \[m2\] whose mass the particle of a slot carries.
    pub(crate) fn area(&self, slot: usize) -> f32 {
        match self {
            Self::Lattice(lattice) => lattice.mass_area[slot],
            Self::Graph(graph) => graph.area[slot],
        }
    }

    /// Resistance to shearing of the cloth as a whole \[N/m\].
    pub(crate) fn shear_stiffness(&self, material: &Material) -> f32 {
        match self {
            // Edges in all directions resist it by themselves: van Gelder's network.
            Self::Graph(graph) if graph.shear.is_empty() => 0.375 * material.thread_stiffness,
            _ => material.shear_stiffness,
        }
    }
}
