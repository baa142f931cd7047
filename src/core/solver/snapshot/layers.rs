//! Contact of a cloth with itself and with others, as it is saved: by particle in place of by slot.

use bevy_math::Vec3;

use crate::solver::cloth_contact::{History, Memory, Stuck};
use crate::solver::settings::is_near;
use crate::solver::snapshot::{by_particle, by_slot};
use crate::solver::topology::Topology;

/// The memory of contact with itself, or with others; see [`Memory`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SavedLayers {
    found_at: Option<Vec<Vec3>>,
    since_touch: u32,
    /// Particles that stand down, ascending.
    down: Vec<u32>,
    is_suspected: bool,
    wait: u32,
    /// Halves of what it and others keep of pairs that touch.
    histories: Vec<SavedHistory>,
}

/// Particles of pairs that touch, and their anchors \[m\]; see [`History`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
struct SavedHistory {
    stamp: u64,
    pairs: Vec<(u32, Vec3)>,
}

impl SavedLayers {
    pub fn of(topology: &Topology, memory: Memory) -> Self {
        let Memory { found_at, since_touch, down, is_suspected, wait, histories } = memory;
        let mut down: Vec<_> =
            down.into_iter().map(|slot| topology.particle(slot) as u32).collect();
        down.sort_unstable();
        let found_at = found_at.map(|found_at| by_particle(topology, &found_at));
        let saved = |History { stamp, pairs }: History| {
            let particle = |slot: u32| topology.particle(slot as usize) as u32;
            let pairs = pairs.into_iter().map(|it| (particle(it.slot), it.anchor)).collect();
            SavedHistory { stamp, pairs }
        };
        let histories = histories.into_iter().map(saved).collect();
        Self { found_at, since_touch, down, is_suspected, wait, histories }
    }

    pub fn memory(&self, topology: &Topology) -> Memory {
        let Self { found_at, since_touch, down, is_suspected, wait, histories } = self;
        let history = |SavedHistory { stamp, pairs }: &SavedHistory| {
            let slot = |particle: u32| topology.slot(particle as usize) as u32;
            let stuck = |&(particle, anchor): &(u32, Vec3)| Stuck { slot: slot(particle), anchor };
            History { stamp: *stamp, pairs: pairs.iter().map(stuck).collect() }
        };
        Memory {
            found_at: found_at.as_deref().map(|found_at| by_slot(topology, found_at)),
            since_touch: *since_touch,
            down: down.iter().map(|&particle| topology.slot(particle as usize)).collect(),
            is_suspected: *is_suspected,
            wait: *wait,
            histories: histories.iter().map(history).collect(),
        }
    }

    /// Whether a cloth of so many particles may have had it.
    pub fn is_good(&self, particles: usize) -> bool {
        let is_good = |found_at: &Vec<Vec3>| {
            found_at.len() == particles && found_at.iter().all(|&at| is_near(at))
        };
        self.found_at.as_ref().is_none_or(is_good)
            && self.down.iter().all(|&particle| (particle as usize) < particles)
            && self
                .histories
                .iter()
                .flat_map(|history| &history.pairs)
                .all(|&(particle, anchor)| (particle as usize) < particles && is_near(anchor))
    }
}
