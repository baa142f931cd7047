//! Contact of a cloth with itself. Its particles are balls, and no two balls overlap.
//!
//! Two square lattices cannot pass through each other while no two of their particles are nearer than half a diagonal of a cell.
//! So a particle's ball is as large as the triangles around it ask for, with some reserve ([`balls`]). Particles that are near each
//! other at rest are left alone: a cloth does not push its own neighbours.
//!
//! Pairs that may touch are found in a grid a few times a tick, with a margin ([`find`]). A pair sleeps until the cloth has moved by
//! the pair's gap ([`travel`]). Pairs that touch are met in every substep, after the threads and before the strain limit ([`respond`]).
//! A pair gives one particle what it takes from the other, so momentum is kept.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `balls` | how large a particle's ball is |
//! | `faces` | the triangles of a cloth |
//! | `grid` | particles sorted by the cells of a grid |
//! | `find` | pairs of particles that may touch before the cloth has moved by the margin |
//! | `patches` | smooth parts of a sheet, which are passed over |
//! | `normals` | the surface's normals, by which layers slide on each other |
//! | `travel` | how far particles have moved relative to each other since then |
//! | `respond` | pairs that touch are moved apart, with friction |
//! | `tangles` | faces that pierce each other, whose particles stand down |
//! | `crossings` | edges that pierce faces |

mod balls;
mod crossings;
mod faces;
mod find;
mod grid;
mod normals;
mod patches;
mod respond;
mod tangles;
mod travel;

pub(super) use crate::solver::self_contact::crossings::crossing_edges;

use crate::solver::self_contact::balls::Balls;
use crate::solver::self_contact::find::{FindPairs, Pair};
use crate::solver::self_contact::grid::Grid;
use crate::solver::self_contact::normals::Normals;
use crate::solver::self_contact::patches::{LookAtPatches, Patches};
use crate::solver::self_contact::respond::Respond;
use crate::solver::self_contact::tangles::{DEEP, Tangles};
use crate::solver::self_contact::travel::{AddUp, Regions, Travelled};
use crate::solver::settings::{ParameterError, Settings, check};
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// Substeps in 1/60 s at least of a cloth that may come to touch itself.
const FEWEST_SUBSTEPS: u32 = 12;
/// Speed at which a ball goes as far as it is wide in a substep, of a cloth that touches itself \[m/s\]: with fewer substeps threads
/// and layers that press on each other come to no agreement, and layers pass through each other.
const SPEED: f32 = 22.0;
/// Ticks for which it has these substeps after its layers touched.
const CALM: u32 = 30;
/// Automatic distance on a square sheet, in particle spacings.
const AUTOMATIC: f32 = 0.92;
/// Gap up to which pairs are kept, in diameters of the largest ball. More makes fewer searches, and more pairs.
const MARGIN: f32 = 0.7;
/// Pairs that there is room for from the start, for each particle.
const ROOM: usize = 4;

/// How a cloth collides with itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub struct SelfCollision {
    /// Distance at which particles are kept from each other \[m\]; `None` is the least at which no layer passes through another,
    /// 0.92 of the particle spacing on a square sheet. Smaller is thinner and lets layers pass.
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
    /// over 0.92, which is the particle spacing of a square sheet.
    pub fn validate(&self, topology: &Topology) -> Result<(), ParameterError> {
        check("friction", self.friction, 0.0, 1e3, "from 0 to 1000")?;
        let Some(distance) = self.distance else { return Ok(()) };
        let most = Balls::automatic(topology).widest() / AUTOMATIC;
        let range = "positive and at most the distance between neighbouring particles: ask for less, or make the cloth coarser";
        check("distance", distance, most * 1e-3, most, range)
    }
}

/// A cloth's contact with itself: its balls, and the pairs of them that may touch. All but the balls follows from where the particles
/// were when pairs were found last.
#[derive(Clone, Debug)]
pub(super) struct SelfContact {
    pub settings: SelfCollision,
    balls: Balls,
    /// Patches of a sheet, by which smooth parts are passed over.
    patches: Option<Patches>,
    grid: Grid,
    regions: Regions,
    tangles: Tangles,
    normals: Normals,
    /// Positions when pairs were found last \[m\].
    found_at: Soa,
    /// Whether they were found, and no particle has been put elsewhere since.
    is_found: bool,
    /// Ticks since pairs touched, up to [`CALM`].
    since_touch: u32,
    /// Substeps in 1/60 s that were planned.
    planned: u32,
    pairs: Vec<Pair>,
    /// Gap up to which pairs are kept \[m\].
    margin: f32,
}

/// All that later bits of contact with itself depend on, between two ticks.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    /// Positions when pairs were found, where no particle has been put elsewhere since \[m\].
    pub found_at: Option<Soa>,
    /// Ticks since pairs touched.
    pub since_touch: u32,
    /// Slots of the particles that stand down.
    pub down: Vec<usize>,
    /// Whether there may be a tangle.
    pub is_suspected: bool,
    /// Ticks until tangles are searched.
    pub wait: u32,
}

/// A substep of a cloth, as its contact with itself takes it.
pub(super) struct Substep<'a> {
    pub isa: Isa,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
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
        let layout = topology.layout();
        Self {
            settings,
            patches: topology.as_lattice().map(|lattice| Patches::new(lattice.layout)),
            grid: Grid::new(topology),
            regions: Regions::new(layout),
            tangles: Tangles::new(topology),
            normals: Normals::new(layout.len()),
            found_at: Soa::zeros(layout.len()),
            is_found: false,
            since_touch: CALM,
            planned: 0,
            pairs: Vec::with_capacity(ROOM * topology.particle_count()),
            margin: balls.widest() * MARGIN,
            balls,
        }
    }

    /// Begins a tick. Tells whether it asks for other substeps than were planned.
    pub fn begin_tick(&mut self) -> bool {
        self.since_touch = (self.since_touch + 1).min(CALM);
        self.tangles.begin_tick();
        self.substeps() != self.planned
    }

    /// Substeps in 1/60 s that it asks for, which are planned now.
    pub fn plan(&mut self) -> u32 {
        self.planned = self.substeps();
        self.planned
    }

    /// Substeps in 1/60 s that it asks for.
    fn substeps(&self) -> u32 {
        if self.since_touch == CALM {
            return FEWEST_SUBSTEPS;
        }
        let needed = (SPEED / (60.0 * self.balls.widest())).ceil();
        (needed as u32).clamp(FEWEST_SUBSTEPS, Settings::MAX_SUBSTEPS)
    }

    /// Takes out all that its later bits depend on.
    pub fn memory(&self) -> Memory {
        let Tangles { is_down, any: _, is_suspected, wait, faces: _ } = &self.tangles;
        Memory {
            found_at: self.is_found.then(|| self.found_at.clone()),
            since_touch: self.since_touch,
            down: (0..is_down.len()).filter(|&slot| is_down[slot]).collect(),
            is_suspected: *is_suspected,
            wait: *wait,
        }
    }

    /// Takes over another's memory.
    pub fn remember(&mut self, isa: Isa, memory: Memory) {
        let Memory { found_at, since_touch, down, is_suspected, wait } = memory;
        self.since_touch = since_touch.min(CALM);
        self.tangles.put_down(&down);
        (self.tangles.is_suspected, self.tangles.wait) = (is_suspected, wait);
        self.is_found = false;
        if let Some(found_at) = found_at {
            self.found_at = found_at;
            self.find(isa);
        }
    }

    /// Forgets which pairs there are: particles have been put elsewhere.
    pub fn forget(&mut self) {
        self.is_found = false;
        self.tangles.is_suspected = true;
        self.tangles.wait = 0;
    }

    /// Moves apart what touches. Tells how many pairs do.
    pub fn meet(&mut self, on: Substep<'_>) -> u32 {
        let Substep { isa, inverse_mass, x, d, unpulled, most_push } = on;
        let mut travelled = Travelled { most: 0.0, is_too_far: !self.is_found };
        if self.is_found {
            travelled = self.regions.measure(isa, x, d, &self.found_at, self.margin);
        }
        if travelled.is_too_far {
            isa.run(AddUp { x, d, to: &mut self.found_at });
            self.find(isa);
            travelled.most = 0.0;
        }
        if self.tangles.is_due() {
            self.tangles.search(&self.pairs, x, d);
        }
        let respond = Respond {
            pairs: &self.pairs,
            normals: &self.normals,
            travelled: travelled.most,
            friction: self.settings.friction,
            most_push,
            inverse_mass,
            x,
            d,
            unpulled,
            is_down: self.tangles.any.then_some(&self.tangles.is_down),
        };
        let touched = respond.run();
        self.since_touch = if touched.count > 0 { 0 } else { self.since_touch };
        self.tangles.is_suspected |= touched.deepest > DEEP;
        touched.count
    }

    /// Finds the pairs of particles that are at `found_at`.
    fn find(&mut self, isa: Isa) {
        let Self {
            patches,
            grid,
            regions,
            found_at: at,
            pairs,
            margin,
            balls,
            tangles,
            normals,
            ..
        } = self;
        let reach = balls.widest() + *margin;
        regions.begin(isa, at, *margin, reach);
        grid.begin(reach);
        match patches {
            Some(patches) => {
                isa.run(LookAtPatches { patches, at });
                patches.find_busy(reach);
                grid.take(at, patches.busy_slots());
            }
            None => grid.take(at, grid.layout.slots()),
        }
        grid.sort(isa, balls, at);
        pairs.clear();
        isa.run(FindPairs { grid, margin: *margin, pairs });
        normals.find(pairs, &tangles.faces, at);
        self.is_found = true;
    }
}
