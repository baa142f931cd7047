//! Rest shapes in use: equal cloths share one, and the last cloth takes it with it. Those of large meshes are made in the
//! background.

use std::sync::{Arc, Weak};

use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use crate::error::problems::MeshProblem;
use crate::error::proxy::ProxyProblem;
use crate::mesh::background::{Background, LARGE};
use crate::mesh::factors::Factors;
use crate::mesh::intake::{Connection, MeshShape};
use crate::mesh::proxy::{Coarse, Proxy, ProxyKey};
use crate::mesh::raw::RawMesh;
use crate::mesh::rest_shape::RestShape;
use crate::solver::{Graph, Lattice, MassLumping, SolverError, Topology, Weights};

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

/// A [`Topology`] that does not keep it alive.
enum WeakTopology {
    Lattice(Weak<Lattice>),
    Graph(Weak<Graph>),
}

impl WeakTopology {
    fn of(topology: &Topology) -> Self {
        match topology {
            Topology::Lattice(lattice) => Self::Lattice(Arc::downgrade(lattice)),
            Topology::Graph(graph) => Self::Graph(Arc::downgrade(graph)),
        }
    }

    fn upgrade(&self) -> Option<Topology> {
        match self {
            Self::Lattice(lattice) => lattice.upgrade().map(Topology::Lattice),
            Self::Graph(graph) => graph.upgrade().map(Topology::Graph),
        }
    }

    fn is_in_use(&self) -> bool {
        match self {
            Self::Lattice(lattice) => lattice.strong_count() > 0,
            Self::Graph(graph) => graph.strong_count() > 0,
        }
    }
}

/// The rest shapes in use, and those that are being made.
#[derive(Resource, Default)]
pub(crate) struct RestCache {
    meshes: HashMap<u64, Weak<MeshShape>>,
    topologies: HashMap<TopologyKey, WeakTopology>,
    proxies: HashMap<ProxyKey, Weak<Proxy>>,
    /// Those that a cloth has asked for since the last look: nobody else may have them yet.
    asked_proxies: HashMap<ProxyKey, (Arc<Proxy>, bool)>,
    meshes_to_be: Background<u64, Result<MeshShape, MeshProblem>>,
    proxies_to_be: Background<ProxyKey, Result<Proxy, ProxyProblem>>,
    /// With the shape that each is made of, which nobody else may have yet.
    topologies_to_be: Background<TopologyKey, (RestShape, Result<Topology, SolverError>)>,
}

impl RestCache {
    /// The rest shape of a mesh, made only if no cloth has it; `None` while it is made in the background.
    pub fn mesh(
        &mut self,
        fingerprint: u64,
        mesh: &Mesh,
    ) -> Result<Option<Arc<MeshShape>>, MeshProblem> {
        if let Some(shape) = self.meshes.get(&fingerprint).and_then(Weak::upgrade) {
            return Ok(Some(shape));
        }
        let made = if mesh.count_vertices() < LARGE {
            MeshShape::new(RawMesh::read(mesh)?, fingerprint)
        } else {
            let begin = || {
                let raw = RawMesh::read(mesh);
                move || MeshShape::new(raw?, fingerprint)
            };
            let Some(made) = self.meshes_to_be.ask(fingerprint, begin) else { return Ok(None) };
            made
        };
        let shape = Arc::new(made?);
        self.meshes.retain(|_, other| other.strong_count() > 0);
        self.meshes.insert(fingerprint, Arc::downgrade(&shape));
        Ok(Some(shape))
    }

    /// The coarse shape that carries a drawn one; `None` while it is made in the background.
    ///
    /// # Errors
    /// [`ProxyProblem`] where it cannot be made.
    pub fn proxy(
        &mut self,
        drawn: RestShape,
        coarse: Coarse,
    ) -> Result<Option<Arc<Proxy>>, ProxyProblem> {
        let key = ProxyKey::new(&drawn, &coarse);
        if let Some(proxy) = self.proxies.get(&key).and_then(Weak::upgrade) {
            self.asked_proxies.insert(key, (proxy.clone(), true));
            return Ok(Some(proxy));
        }
        let made = if drawn.vertex_count() < LARGE {
            Proxy::new(drawn, coarse, key)
        } else {
            let begin = || move || Proxy::new(drawn, coarse, key);
            let Some(made) = self.proxies_to_be.ask(key, begin) else { return Ok(None) };
            made
        };
        let proxy = Arc::new(made?);
        self.proxies.retain(|_, other| other.strong_count() > 0);
        self.proxies.insert(key, Arc::downgrade(&proxy));
        self.asked_proxies.insert(key, (proxy.clone(), true));
        Ok(Some(proxy))
    }

    /// Stops making what no cloth has asked for since the last call.
    pub fn stop_forgotten(&mut self) {
        self.meshes_to_be.stop_forgotten();
        self.proxies_to_be.stop_forgotten();
        self.asked_proxies.retain(|_, (_, is_asked)| core::mem::take(is_asked));
        self.topologies_to_be.stop_forgotten();
    }

    /// A rest shape as the solver has it, made larger by `scale`.
    pub fn topology(
        &mut self,
        rest: &RestShape,
        scale: f32,
        lumping: MassLumping,
        factors: Option<&Factors>,
    ) -> Result<Topology, SolverError> {
        let key = TopologyKey::new(rest, scale, lumping, factors);
        if let Some(topology) = self.topologies.get(&key).and_then(WeakTopology::upgrade) {
            return Ok(topology);
        }
        let topology = topology(rest, scale, lumping, factors)?;
        self.keep(key, &topology);
        Ok(topology)
    }

    /// The same; `None` while it is made in the background, as that of a large mesh is. `rubs` tells whether the cloth has
    /// friction of bending.
    pub fn topology_to_be(
        &mut self,
        rest: &RestShape,
        scale: f32,
        lumping: MassLumping,
        factors: Option<&Factors>,
        rubs: bool,
    ) -> Result<Option<Topology>, SolverError> {
        let key = TopologyKey::new(rest, scale, lumping, factors);
        let known = self.topologies.get(&key).and_then(WeakTopology::upgrade);
        if known.is_some() || !rest.is_large_mesh() {
            return self.topology(rest, scale, lumping, factors).map(Some);
        }
        let begin = || {
            let (rest, factors) = (rest.clone(), factors.cloned());
            move || {
                let made = topology(&rest, scale, lumping, factors.as_ref());
                if let (true, Ok(Topology::Graph(graph))) = (rubs, &made) {
                    graph.prepare_bending_friction();
                }
                (rest, made)
            }
        };
        let Some((_, made)) = self.topologies_to_be.ask(key, begin) else { return Ok(None) };
        let topology = made?;
        self.keep(key, &topology);
        Ok(Some(topology))
    }

    fn keep(&mut self, key: TopologyKey, topology: &Topology) {
        self.topologies.retain(|_, other| other.is_in_use());
        self.topologies.insert(key, WeakTopology::of(topology));
    }
}

impl TopologyKey {
    fn new(rest: &RestShape, scale: f32, lumping: MassLumping, factors: Option<&Factors>) -> Self {
        let shape = match rest {
            RestShape::Sheet { size, particles } => ShapeKey::Sheet {
                size: (*size * scale).to_array().map(f32::to_bits),
                particles: *particles,
            },
            RestShape::Mesh(shape) => {
                ShapeKey::Mesh { fingerprint: shape.fingerprint, scale: scale.to_bits() }
            }
        };
        Self { shape, lumping, factors: factors.map(Factors::fingerprint) }
    }
}

fn topology(
    rest: &RestShape,
    scale: f32,
    lumping: MassLumping,
    factors: Option<&Factors>,
) -> Result<Topology, SolverError> {
    let lattice = match rest {
        RestShape::Sheet { size, particles } => {
            let (rows, columns) = (particles.y as usize, particles.x as usize);
            Lattice::sheet(*size * scale, rows, columns, lumping)?
        }
        RestShape::Mesh(shape) => {
            let positions: Vec<_> = shape.positions.iter().map(|p| *p * scale).collect();
            match &shape.connection {
                Connection::Grid { rows, columns } => {
                    Lattice::new(*rows, *columns, &positions, lumping)?
                }
                Connection::Triangles(triangles) => {
                    let weights = factors.map_or(Weights::default(), |factors| Weights {
                        mass: &factors.mass,
                        stiffness: &factors.stiffness,
                    });
                    let graph = Graph::with_weights(&positions, triangles, lumping, weights)?;
                    return Ok(Arc::new(graph).into());
                }
            }
        }
    };
    let lattice = match factors {
        Some(factors) => lattice.with_weights(&factors.mass, &factors.stiffness)?,
        None => lattice,
    };
    Ok(Arc::new(lattice).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_lives_as_long_as_a_cloth_has_it() {
        let mut cache = RestCache::default();
        let sheet = |size| RestShape::Sheet { size: Vec2::splat(size), particles: UVec2::splat(3) };
        let factors = Factors { mass: vec![2.0; 9], stiffness: vec![1.0; 9] };
        let equal = factors.clone();
        let mut get = |size: f32, scale, factors| {
            let topology = cache.topology(&sheet(size), scale, MassLumping::Lumped, factors);
            topology.unwrap().as_lattice().unwrap().clone()
        };
        let first = get(1.0, 2.0, None);
        assert!(Arc::ptr_eq(&first, &get(2.0, 1.0, None)), "the same size in the end");
        let heavy = get(1.0, 2.0, Some(&factors));
        assert!(!Arc::ptr_eq(&first, &heavy));
        assert!(Arc::ptr_eq(&heavy, &get(1.0, 2.0, Some(&equal))));
        let watch = Arc::downgrade(&first);
        drop(first);
        assert_eq!(watch.strong_count(), 0, "nobody has it any more");
        // What is new takes the place of what is gone.
        get(1.0, 2.0, None);
        assert!(cache.topologies.len() <= 2);
    }
}
