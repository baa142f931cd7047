//! Contact of cloth with cloth: with itself, and with other cloths. Particles are balls, and no two balls overlap.
//!
//! Two square lattices cannot pass through each other while no two of their particles are nearer than half a diagonal of a cell.
//! So a particle's ball is as large as the triangles around it ask for, with some reserve ([`balls`]). Particles that are near each
//! other at rest are left alone: a cloth does not push its own neighbours.
//!
//! Pairs that may touch are found a few times a tick, with a margin: of one cloth patch by patch ([`in_patches`]), of two in a grid
//! ([`find`]). Where there are many, a pair sleeps until the cloth has moved by the pair's gap ([`travel`]). Pairs that touch are met in
//! every substep, after the threads and before the strain limit ([`respond`]). Where they are pressed into each other, they are met once
//! more after the limit, and kept half of their distance apart. A pair gives one particle what it takes from the other, so momentum is kept.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `balls` | how large a particle's ball is |
//! | `faces` | the triangles of a cloth |
//! | `grid` | particles sorted by the cells of a grid |
//! | `find` | pairs of particles that may touch before they have moved by the margin |
//! | `kin` | particles that are near at rest, and share no edge |
//! | `patch` | a part of a cloth, and whether it is flat |
//! | `patches` | all of them, of which smooth neighbours are passed over |
//! | `sheet_patches`, `mesh_patches` | how a sheet and a mesh are divided into patches |
//! | `clusters` | the particles of a mesh in compact clusters |
//! | `sweep` | boxes that are near each other |
//! | `in_patches` | pairs of a cloth's own particles, found patch by patch |
//! | `normals` | the direction to push apart, by which layers slide on each other |
//! | `regions` | the regions of a cloth, and the boxes of their particles |
//! | `travel` | how far particles have moved relative to each other since then |
//! | `batches` | pairs in batches that are met side by side |
//! | `beads` | the particles of a cloth one after the other, as batches take them |
//! | `side` | a cloth as one side of pairs |
//! | `grains` | the particles of one side of a batch |
//! | `respond` | pairs that touch are moved apart |
//! | `history` | where pairs that touch began to, from tick to tick |
//! | `friction` | pairs that touch rub on each other, and are held where they began to |
//! | `rings` | the faces at a particle in a few numbers |
//! | `tangles` | faces that pierce each other, whose particles stand down |
//! | `crossings` | edges that pierce faces |
//! | `itself` | contact of a cloth with itself |
//! | `others` | what a cloth has for its contact with others |
//! | `parts` | a cloth, as contact with others takes it |
//! | `couple` | two cloths that may touch |
//! | `many` | the particles of several cloths, as pairs of them are found |
//! | `couples` | all couples of cloths that are stepped together: who is near whom, pairs, margins |

mod balls;
mod batches;
mod beads;
mod clusters;
mod couple;
mod couples;
mod crossings;
mod faces;
mod find;
mod friction;
mod grains;
mod grid;
mod history;
mod in_patches;
mod itself;
mod kin;
mod many;
mod mesh_patches;
mod normals;
mod others;
mod parts;
mod patch;
mod patches;
mod regions;
mod respond;
mod rings;
mod sheet_patches;
mod side;
mod sweep;
mod tangles;
mod travel;

pub(super) use crate::solver::cloth_contact::beads::Lying;
pub(super) use crate::solver::cloth_contact::couples::Couples;
pub(super) use crate::solver::cloth_contact::crossings::{crossing_edges, edges_through};
pub(super) use crate::solver::cloth_contact::faces::FacesAt;
pub(super) use crate::solver::cloth_contact::history::{History, Stuck};
pub use crate::solver::cloth_contact::itself::SelfCollision;
pub(super) use crate::solver::cloth_contact::itself::{SelfContact, Substep};
pub use crate::solver::cloth_contact::others::InterCollision;
pub(super) use crate::solver::cloth_contact::others::OthersContact;
pub(super) use crate::solver::cloth_contact::parts::{Body, Parts};

use crate::solver::cloth_contact::balls::Balls;
use crate::solver::settings::{ParameterError, Settings, check};
use crate::solver::simd::soa::Soa;
use crate::solver::topology::Topology;

/// Substeps in 1/60 s at least of a cloth that may come to touch cloth.
const FEWEST_SUBSTEPS: u32 = 12;
/// Speed at which a ball goes as far as it is wide in a substep, of a cloth that touches cloth \[m/s\]: with fewer substeps threads
/// and layers that press on each other come to no agreement, and layers pass through each other.
const SPEED: f32 = 17.5;
/// Part of the distance at which pairs touch that is kept against the strain limit as well: layers that are further into each other
/// may be through each other in the next substep.
const AT_LEAST: f32 = 0.5;
/// Ticks for which it has these substeps after its layers touched.
const CALM: u32 = 30;
/// Automatic distance on a square sheet, in particle spacings.
const AUTOMATIC: f32 = 0.92;
/// Gap up to which pairs are kept, in diameters of the largest ball. More makes fewer searches, and more pairs.
const MARGIN: f32 = 0.7;

/// All that later bits of contact depend on, between two ticks.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Memory {
    /// Positions when pairs of a cloth's own were found, where no particle has been put elsewhere since \[m\].
    pub found_at: Option<Soa>,
    /// Ticks since pairs touched.
    pub since_touch: u32,
    /// Slots of the particles that stand down.
    pub down: Vec<usize>,
    /// Whether there may be a tangle.
    pub is_suspected: bool,
    /// Ticks until tangles are searched.
    pub wait: u32,
    /// Pairs that touch, by each other cloth.
    pub histories: Vec<History>,
}

/// Substeps in 1/60 s that layers need of balls so wide \[m\], so many ticks after they touched.
fn substeps_for(widest: f32, since_touch: u32) -> u32 {
    if since_touch == CALM {
        return FEWEST_SUBSTEPS;
    }
    let needed = (SPEED / (60.0 * widest)).ceil();
    (needed as u32).clamp(FEWEST_SUBSTEPS, Settings::MAX_SUBSTEPS)
}

/// Checks a coefficient of friction, and a distance for a cloth.
fn check_numbers(
    topology: &Topology,
    distance: Option<f32>,
    friction: f32,
) -> Result<(), ParameterError> {
    check("friction", friction, 0.0, 1e3, "from 0 to 1000")?;
    let Some(distance) = distance else { return Ok(()) };
    let most = Balls::automatic(topology).widest() / AUTOMATIC;
    let range = "positive and at most the distance between neighbouring particles: ask for less, or make the cloth coarser";
    check("distance", distance, most * 1e-3, most, range)
}
