//! Hinges that are flat at rest, particle by particle: their energy is quadratic in the positions (Bergou
//! et al. 2006), so that two corners of hinges pull at each other in proportion to their distance, with
//! a constant that is summed beforehand over the hinges that they share.
//!
//! A particle gathers its dozen neighbours and theirs once, where hinge by hinge as many corners are
//! gathered for the moments, and as many moments for the forces. Each pull has an equal and opposite
//! one along the same line, to the bit: no momentum is made, nor any spin.

use crate::solver::simd::soa::Array;
use crate::solver::topology::buckets::Buckets;
use crate::solver::topology::graph::adjacency::Table;
use crate::solver::topology::graph::hinge::Hinge;

/// No entry: a corner with itself, or without weight.
const NONE: u32 = u32::MAX;

/// Which particles share hinges.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Couplings {
    pub table: Table,
    /// Entries of the table that a hinge adds to, by its two corners.
    entries: Vec<[[u32; 4]; 4]>,
}

impl Couplings {
    /// The couplings of the particles of `slots` slots.
    pub fn new(slots: usize, hinges: &[Hinge]) -> Self {
        let near: Vec<_> = hinges.iter().flat_map(pairs).map(|(.., pair)| pair).collect();
        let near = Buckets::neighbours(slots, &near);
        let pairs =
            near.each().zip(0..).flat_map(|(near, slot)| near.iter().map(move |&to| (slot, to)));
        let entries: Vec<_> = pairs.zip(0..).map(|((slot, to), i)| (slot, (to, i))).collect();
        let table = Table::new(slots, &entries, |slot| slot);
        let mut place = vec![NONE; near.len()];
        for (entry, &pair) in table.source.iter().enumerate() {
            if let Some(place) = place.get_mut(pair as usize) {
                *place = entry as u32;
            }
        }
        let entry = |(slot, to): (u32, u32)| {
            let at = near.of(slot).binary_search(&to);
            at.map_or(NONE, |at| place[near.range(slot).start + at])
        };
        let entries = hinges.iter().map(|hinge| {
            let mut entries = [[NONE; 4]; 4];
            for (a, b, pair) in self::pairs(hinge) {
                entries[a][b] = entry(pair);
            }
            entries
        });
        Self { entries: entries.collect(), table }
    }

    /// How many hinges there are.
    pub fn hinges(&self) -> usize {
        self.entries.len()
    }

    /// Room for the constants.
    pub fn room(&self) -> Array {
        self.table.room()
    }

    /// Sums the couplings \[N/m\] over hinges of the given constants \[N/m\].
    pub fn fill(&self, hinges: &[Hinge], constants: &[f32], couplings: &mut Array) {
        couplings.fill(0.0);
        for ((hinge, entries), constant) in hinges.iter().zip(&self.entries).zip(constants) {
            for (a, entries) in entries.iter().enumerate() {
                for (b, &entry) in entries.iter().enumerate() {
                    if entry != NONE {
                        let weight = hinge.weights[a] * hinge.weights[b];
                        couplings[entry as usize] -= constant * weight;
                    }
                }
            }
        }
    }
}

/// Corners of a hinge two by two, in both orders, and their slots.
fn pairs(hinge: &Hinge) -> impl Iterator<Item = (usize, usize, (u32, u32))> + '_ {
    let corners = move || (0..4).filter(|&corner| hinge.weights[corner] != 0.0);
    corners()
        .flat_map(move |a| corners().map(move |b| (a, b)))
        .filter(|(a, b)| a != b)
        .map(|(a, b)| (a, b, (hinge.slots[a], hinge.slots[b])))
}
