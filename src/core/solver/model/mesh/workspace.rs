//! Working memory of the stages of a triangle mesh: particles one after the other, gathered before corrections and
//! scattered after.

use crate::solver::constraints::graph_strain_limit::NearLimit;
use crate::solver::constraints::threads::chains::ChainWorkspace;
use crate::solver::contact::ActiveSet;
use crate::solver::model::Particles;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::gather::{Places, PlacesMut, load, store};
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{self, Band, Workspaces, cut_between_rows};
use crate::solver::simd::soa::{Array, PartMut, Soa, ValuesMut};
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::state::State;
use crate::solver::topology::graph::Graph;
use crate::solver::topology::graph::coloring::Pairs;
use crate::solver::topology::graph::domains::Domain;

/// Room that the stages work in; nothing in it outlives a substep, but for what was near its limit within a tick.
#[derive(Clone, Debug)]
pub(crate) struct MeshWorkspace {
    pub places: Places,
    pub moments: Vec<Four>,
    /// Displacements predicted for the damping.
    pub predicted: Vec<Four>,
    pub chains: Workspaces<ChainWorkspace>,
    /// Structural springs near their limit, round by round and domain by domain.
    pub near_limit: Vec<Vec<NearLimit>>,
}

impl MeshWorkspace {
    pub fn new(graph: &Graph) -> Self {
        let chains = &graph.chains;
        Self {
            places: Places::new(graph.layout.len()),
            moments: vec![Four::default(); graph.hinges.curved.room()],
            predicted: vec![Four::default(); graph.layout.len()],
            chains: Workspaces::new(chains.most(), || ChainWorkspace::new(chains)),
            near_limit: graph.structural_pairs.0.iter().map(|round| near_limit(round)).collect(),
        }
    }

    /// Fills the places.
    /// `corrects` tells whether corrections are to see them, and what they lie on.
    pub fn fill(&mut self, on: &Particles<'_>, corrects: bool) {
        let State { x, d, contacts, .. } = &*on.state;
        parallel::run(
            on.isa,
            GatherParticles {
                band: on.bands.rows.clone(),
                inverse_mass: &on.pins.inverse_mass,
                x,
                d,
                contacts: (corrects && contacts.now.any).then_some(contacts),
                places: self.places.part_mut(),
            },
        );
    }

    /// Takes the corrected displacements back.
    pub fn empty(&self, on: Particles<'_>) {
        let State { d, contacts, .. } = on.state;
        parallel::run(
            on.isa,
            ScatterDisplacements {
                band: on.bands.rows.clone(),
                places: &self.places,
                d: d.part_mut(),
                loads: contacts.now.any.then(|| ValuesMut::all(&mut contacts.load)),
            },
        );
    }
}

/// None of a round's springs is near its limit.
fn near_limit(round: &[Domain<Pairs>]) -> Vec<NearLimit> {
    round.iter().map(|domain| vec![false; domain.work.first.len() / LANES].into()).collect()
}

/// Fills the places.
struct GatherParticles<'a> {
    band: Band,
    inverse_mass: &'a Array,
    x: &'a Soa,
    d: &'a Soa,
    /// What they lie on, where any do.
    contacts: Option<&'a ActiveSet>,
    places: PlacesMut<'a>,
}

cut_between_rows!(transposing GatherParticles, places);

impl TransposingKernel for GatherParticles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let PlacesMut { mut x, mut d, mut normals } = self.places;
        for slot in self.band.slots().step_by(LANES) {
            let mut w = Block::load(self.inverse_mass, slot);
            if let Some(set) = self.contacts {
                let slip = Block::load(&set.now.slip, slot);
                for i in 0..LANES {
                    w.0[i] *= slip.0[i];
                }
            }
            store(t, x.from(slot), 0, Block3::load(self.x, slot), w);
            store(t, d.from(slot), 0, Block3::load(self.d, slot), Block::ZERO);
            if let Some(set) = self.contacts {
                let normal = Block3::load(&set.now.normal, slot);
                store(t, normals.from(slot), 0, normal, Block::load(&set.load, slot));
            }
        }
    }
}

/// Takes the displacements back.
struct ScatterDisplacements<'a> {
    band: Band,
    places: &'a Places,
    d: PartMut<'a>,
    /// Loads of what the particles lie on, where any lies on anything.
    loads: Option<ValuesMut<'a>>,
}

cut_between_rows!(transposing ScatterDisplacements, d, loads);

impl TransposingKernel for ScatterDisplacements<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self, t: impl Transpose) {
        for slot in self.band.slots().step_by(LANES) {
            load(t, &self.places.d, slot).0.store(&mut self.d, slot);
            if let Some(loads) = &mut self.loads {
                loads.set(slot, &load(t, &self.places.normals, slot).1);
            }
        }
    }
}
