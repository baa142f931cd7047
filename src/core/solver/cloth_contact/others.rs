//! What a cloth has for its contact with other cloths.

use std::sync::Arc;

use bevy_math::Mat3;

use crate::solver::cloth_contact::balls::Balls;
use crate::solver::cloth_contact::beads::Beads;
use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::regions::Regions;
use crate::solver::cloth_contact::tangles::Tangles;
use crate::solver::cloth_contact::{CALM, History, Memory, check_numbers, substeps_for};
use crate::solver::settings::ParameterError;
use crate::solver::topology::Topology;

/// How a cloth collides with other cloths.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct InterCollision {
    /// Layers, a bit each. Two cloths collide where they share one.
    pub layers: u32,
    /// Distance at which particles are kept from those of a cloth like it \[m\]: each cloth gives half of it. `None` is the least at which
    /// no layer passes through another, 0.92 of the particle spacing on a square sheet. Smaller is thinner and lets layers pass.
    pub distance: Option<f32>,
    /// Coulomb's coefficient \[1\]. Between two cloths it is the geometric mean of both. Higher slides less.
    pub friction: f32,
}

impl Default for InterCollision {
    fn default() -> Self {
        Self { layers: u32::MAX, distance: None, friction: 0.5 }
    }
}

impl InterCollision {
    /// Checks every number, for a cloth.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is not finite or out of its range. A
    /// distance may be at most the automatic one over 0.92, which is the particle spacing of a square sheet.
    pub fn validate(&self, topology: &Topology) -> Result<(), ParameterError> {
        check_numbers(topology, self.distance, self.friction)
    }
}

/// A cloth's part in contact with others.
#[derive(Clone, Debug)]
pub(in crate::solver) struct OthersContact {
    pub settings: InterCollision,
    pub(super) balls: Balls,
    pub(super) regions: Regions,
    pub(super) tangles: Tangles,
    pub(super) beads: Beads,
    /// Ticks since it touched another cloth, up to [`CALM`].
    pub(super) since_touch: u32,
    /// Whether it may touch others in this tick.
    is_in_company: bool,
    /// Its halves of what it and others keep of pairs that touch.
    pub(super) histories: Vec<History>,
}

impl OthersContact {
    /// For a cloth with settings that have been checked.
    pub fn new(topology: &Topology, faces: Arc<FacesAt>, settings: InterCollision) -> Self {
        let layout = topology.layout();
        Self {
            settings,
            balls: Balls::of(topology, settings.distance),
            regions: Regions::new(topology),
            tangles: Tangles::new(topology, faces),
            beads: Beads::new(layout.len()),
            since_touch: CALM,
            is_in_company: false,
            histories: Vec::new(),
        }
    }

    /// Begins a tick in which it may touch others, or not.
    pub fn begin_tick(&mut self, is_in_company: bool) {
        self.since_touch = (self.since_touch + 1).min(CALM);
        self.tangles.begin_tick();
        self.is_in_company = is_in_company;
        if !is_in_company {
            self.histories.clear();
        }
    }

    /// Substeps in 1/60 s that it asks for.
    pub fn substeps(&self) -> u32 {
        if self.is_in_company { substeps_for(self.balls.widest(), self.since_touch) } else { 0 }
    }

    /// Largest distance at which a particle is kept from one of a cloth like it \[m\].
    pub fn widest(&self) -> f32 {
        self.balls.widest()
    }

    /// The cloth's faces.
    pub fn faces(&self) -> Arc<FacesAt> {
        self.tangles.faces.clone()
    }

    /// Takes out all that its later bits depend on.
    pub fn memory(&self) -> Memory {
        Memory {
            since_touch: self.since_touch,
            histories: self.histories.clone(),
            ..self.tangles.memory()
        }
    }

    /// Takes over another's memory.
    pub fn remember(&mut self, memory: &Memory) {
        self.since_touch = memory.since_touch.min(CALM);
        self.tangles.remember(memory);
        self.histories.clone_from(&memory.histories);
    }

    /// Particles have been put elsewhere.
    pub fn forget(&mut self) {
        self.tangles.suspect();
        self.histories.clear();
    }

    /// The cloth has been moved rigidly, and turned if at all.
    pub fn ride(&mut self, turn: Option<Mat3>) {
        self.tangles.suspect();
        if let Some(turn) = turn {
            self.histories.iter_mut().for_each(|history| history.turn(turn));
        }
    }
}
