//! Contact of a cloth with itself. Its particles are balls, and no two balls overlap.
//!
//! Two square lattices cannot pass through each other while no two of their particles are nearer than half a diagonal of a cell.
//! So a particle's ball is as large as the triangles around it ask for, with some reserve ([`balls`]). Particles that are near each
//! other at rest are left alone: a cloth does not push its own neighbours.
//!
//! Pairs that may touch are found in a grid a few times a tick, with a margin ([`find`]). A pair sleeps until the cloth has moved by
//! the pair's gap ([`travel`]). Pairs that touch are met in every substep, after the threads and before the strain limit ([`respond`]).
//! What a pair gives one particle it takes from the other, so momentum is kept.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `balls` | how large a particle's ball is |
//! | `faces` | the triangles of a cloth |
//! | `grid` | particles sorted by the cells of a grid |
//! | `find` | pairs of particles that may touch before the cloth has moved by the margin |
//! | `travel` | how far particles have moved relative to each other since then |
//! | `respond` | pairs that touch are moved apart, with friction |
//! | `crossings` | edges that pierce faces, counted |

mod balls;
mod crossings;
mod faces;
mod find;
mod grid;
mod respond;
mod travel;

pub(super) use crate::solver::self_contact::crossings::crossings;

use crate::solver::self_contact::balls::Balls;
use crate::solver::self_contact::find::{FindPairs, Pair};
use crate::solver::self_contact::grid::Grid;
use crate::solver::self_contact::respond::Respond;
use crate::solver::self_contact::travel::Travel;
use crate::solver::settings::{ParameterError, check};
use crate::solver::simd::isa::Isa;
use crate::solver::simd::parallel::{self, Band};
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// Fewest substeps in 1/60 s in which layers do not pass through each other.
pub(super) const FEWEST_SUBSTEPS: u32 = 12;
/// Gap up to which pairs are kept, in diameters of the largest ball. More makes fewer searches, and more pairs.
const MARGIN: f32 = 0.7;
/// Pairs that there is room for from the start, for each particle.
const ROOM: usize = 4;

/// How a cloth collides with itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfCollision {
    /// Distance at which particles are kept from each other \[m\]; `None` is the least at which no layer passes through another,
    /// 0.85 of the particle spacing on a square sheet. Smaller is thinner and lets layers pass.
    pub distance: Option<f32>,
    /// Coulomb's coefficient between layers \[1\]. Higher slides less.
    pub friction: f32,
}

impl Default for SelfCollision {
    fn default() -> Self {
        Self { distance: None, friction: 0.5 }
    }
}

impl SelfCollision {
    /// Checks every number, for a cloth.
    ///
    /// # Errors
    /// [`ParameterError`] for the first number that is not finite or out of its range. A distance may be at most the automatic one
    /// over 0.85, which is the particle spacing of a square sheet.
    pub fn validate(&self, topology: &Topology) -> Result<(), ParameterError> {
        check("friction", self.friction, 0.0, 1e3, "from 0 to 1000")?;
        let Some(distance) = self.distance else { return Ok(()) };
        let most = Balls::automatic(topology).largest() * (2.0 / 0.85);
        let range = "positive and at most the distance between neighbouring particles: ask for less, or make the cloth coarser";
        check("distance", distance, most * 1e-3, most, range)
    }
}

/// A cloth's contact with itself: its balls, and the pairs of them that may touch. Nothing but the balls outlives a tick.
#[derive(Clone, Debug)]
pub(super) struct SelfContact {
    pub settings: SelfCollision,
    balls: Balls,
    grid: Grid,
    /// Positions when pairs were found last \[m\].
    found_at: Soa,
    /// Whether they were found in this tick.
    is_found: bool,
    pairs: Vec<Pair>,
    /// Gap up to which pairs are kept \[m\].
    margin: f32,
}

/// A substep of a cloth, as its contact with itself takes it.
pub(super) struct Substep<'a> {
    pub isa: Isa,
    pub band: Band,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Pulls that are noted (`integrate::houbolt`): contact is none.
    pub pull: Option<&'a mut Soa>,
    /// Displacements of particles that lie on colliders, before corrections pulled at them.
    pub unpulled: Option<&'a mut Soa>,
    /// How far a pair is moved apart in the substep at most, without speed \[m\].
    pub most_push: f32,
}

impl SelfContact {
    /// For a cloth with settings that have been checked.
    pub fn new(topology: &Topology, settings: SelfCollision) -> Self {
        let balls = match settings.distance {
            Some(distance) => Balls::uniform(topology, distance),
            None => Balls::automatic(topology),
        };
        let particles = topology.particle_count();
        Self {
            settings,
            grid: Grid::new(topology),
            found_at: Soa::zeros(topology.layout().len()),
            is_found: false,
            pairs: Vec::with_capacity(ROOM * particles),
            margin: 2.0 * balls.largest() * MARGIN,
            balls,
        }
    }

    /// Begins a tick: pairs are found anew.
    pub fn begin_tick(&mut self) {
        self.is_found = false;
    }

    /// Moves apart what touches. Tells how many pairs do.
    pub fn meet(&mut self, on: Substep<'_>) -> u32 {
        let Substep { isa, band, inverse_mass, x, d, pull, unpulled, most_push } = on;
        let travel = Travel { band: band.clone(), x, d, from: &self.found_at };
        let mut travelled = if self.is_found { parallel::run(isa, travel).length() } else { 0.0 };
        if !self.is_found || travelled >= self.margin {
            self.grid.sort(isa, &band.layout, &self.balls, self.margin, x, d, &mut self.found_at);
            self.pairs.clear();
            isa.run(FindPairs { grid: &self.grid, margin: self.margin, pairs: &mut self.pairs });
            self.is_found = true;
            travelled = 0.0;
        }
        let friction = self.settings.friction;
        let pairs = &self.pairs;
        Respond { pairs, travelled, friction, most_push, inverse_mass, x, d, pull, unpulled }.run()
    }
}
