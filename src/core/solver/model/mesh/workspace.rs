//! Working memory of the stages of a triangle mesh: particles one after the other, gathered before corrections and
//! scattered after.

use crate::solver::constraints::threads::line::Line;
use crate::solver::contact::ActiveSet;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::gather::{Places, load, store};
use crate::solver::simd::isa::{Isa, TransposingKernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::state::State;
use crate::solver::topology::graph::Graph;

/// Room that the stages work in; nothing in it outlives a substep.
#[derive(Clone, Debug)]
pub(crate) struct MeshWorkspace {
    pub places: Places,
    pub moments: Vec<Four>,
    /// Displacements predicted for the damping.
    pub predicted: Vec<Four>,
    /// Unknowns of a bundle of chains, and its inverse masses.
    pub line: Line,
    pub inverse_mass: Array,
}

impl MeshWorkspace {
    pub fn new(graph: &Graph) -> Self {
        let longest = graph.chains.longest() * LANES;
        Self {
            places: Places::new(graph.layout.len()),
            moments: vec![Four::default(); graph.hinges.curved.room()],
            predicted: vec![Four::default(); graph.layout.len()],
            line: Line::new(longest),
            inverse_mass: Array::zeros(longest),
        }
    }

    /// Fills the places.
    /// `corrects` tells whether corrections are to see them, and what they lie on.
    pub fn fill(&mut self, isa: Isa, inverse_mass: &Array, state: &State, corrects: bool) {
        let State { x, d, contacts, .. } = state;
        let contacts = (corrects && contacts.now.any).then_some(contacts);
        let places = &mut self.places;
        isa.run_transposing(GatherParticles { inverse_mass, x, d, contacts, places });
    }

    /// Takes the corrected displacements back.
    pub fn empty(&self, isa: Isa, state: &mut State) {
        let State { d, contacts, .. } = state;
        let contacts = contacts.now.any.then_some(contacts);
        isa.run_transposing(ScatterDisplacements { places: &self.places, d, contacts });
    }
}

/// Fills the places.
pub(crate) struct GatherParticles<'a> {
    pub inverse_mass: &'a Array,
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// What they lie on, where any do.
    pub contacts: Option<&'a ActiveSet>,
    pub places: &'a mut Places,
}

impl TransposingKernel for GatherParticles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Places { x, d, normals } = self.places;
        for slot in (0..x.len()).step_by(LANES) {
            let mut w = Block::load(self.inverse_mass, slot);
            if let Some(set) = self.contacts {
                let slip = Block::load(&set.now.slip, slot);
                for i in 0..LANES {
                    w.0[i] *= slip.0[i];
                }
            }
            store(t, x, slot, Block3::load(self.x, slot), w);
            store(t, d, slot, Block3::load(self.d, slot), Block::ZERO);
            if let Some(set) = self.contacts {
                let normal = Block3::load(&set.now.normal, slot);
                store(t, normals, slot, normal, Block::load(&set.load, slot));
            }
        }
    }
}

/// Takes the displacements back.
pub(crate) struct ScatterDisplacements<'a> {
    pub places: &'a Places,
    pub d: &'a mut Soa,
    /// What takes the loads, where any particle lies on anything.
    pub contacts: Option<&'a mut ActiveSet>,
}

impl TransposingKernel for ScatterDisplacements<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self, t: impl Transpose) {
        for slot in (0..self.places.d.len()).step_by(LANES) {
            load(t, &self.places.d, slot).0.store(self.d, slot);
            if let Some(set) = &mut self.contacts {
                load(t, &self.places.normals, slot).1.store(&mut set.load, slot);
            }
        }
    }
}
