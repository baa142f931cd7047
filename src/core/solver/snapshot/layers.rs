//! Contact of a cloth with itself, as it is saved: by particle in place of by slot.

use bevy_math::Vec3;

use crate::solver::cloth_contact::Memory;
use crate::solver::settings::is_near;
use crate::solver::snapshot::{by_particle, by_slot};
use crate::solver::topology::Topology;

/// The memory of contact with itself; see [`Memory`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SavedLayers {
    found_at: Option<Vec<Vec3>>,
    since_touch: u32,
    /// Particles that stand down, ascending.
    down: Vec<u32>,
    is_suspected: bool,
    wait: u32,
}

impl SavedLayers {
    pub fn of(topology: &Topology, memory: Memory) -> Self {
        let Memory { found_at, since_touch, down, is_suspected, wait } = memory;
        let mut down: Vec<_> =
            down.into_iter().map(|slot| topology.particle(slot) as u32).collect();
        down.sort_unstable();
        let found_at = found_at.map(|found_at| by_particle(topology, &found_at));
        Self { found_at, since_touch, down, is_suspected, wait }
    }

    pub fn memory(&self, topology: &Topology) -> Memory {
        let Self { found_at, since_touch, down, is_suspected, wait } = self;
        Memory {
            found_at: found_at.as_deref().map(|found_at| by_slot(topology, found_at)),
            since_touch: *since_touch,
            down: down.iter().map(|&particle| topology.slot(particle as usize)).collect(),
            is_suspected: *is_suspected,
            wait: *wait,
        }
    }

    /// Whether a cloth of so many particles may have had it.
    pub fn is_good(&self, particles: usize) -> bool {
        let is_good = |found_at: &Vec<Vec3>| {
            found_at.len() == particles && found_at.iter().all(|&at| is_near(at))
        };
        self.found_at.as_ref().is_none_or(is_good)
            && self.down.iter().all(|&particle| (particle as usize) < particles)
    }
}
