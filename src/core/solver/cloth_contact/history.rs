//! Contact history: where pairs of two cloths that touch began to (Cundall and Strack 1979, *A discrete numerical model for granular
//! assemblies*, section 3), from tick to tick.
//!
//! Between two ticks each cloth keeps its own half, so that it is saved, restored, and met by others in any order. Both halves bear a
//! stamp, which no two couples share: a half whose other half has been lost, or is another one by now, is of no use and forgotten.

use std::hash::{DefaultHasher, Hash, Hasher};

use bevy_math::{Mat3, Vec3};

/// A particle of a pair that touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) struct Stuck {
    pub slot: u32,
    /// From the other cloth's particle to this one where the pair began to touch, but for what it has slid since \[m\].
    pub anchor: Vec3,
}

/// The half that one of two cloths keeps of their pairs that touch. The other one keeps as many, in the same order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::solver) struct History {
    pub stamp: u64,
    pub pairs: Vec<Stuck>,
}

impl History {
    /// The cloth is turned, and all that it touches with it.
    pub fn turn(&mut self, turn: Mat3) {
        for pair in &mut self.pairs {
            pair.anchor = turn * pair.anchor;
        }
    }
}

/// Takes out what two cloths keep of each other.
pub(super) fn take_shared(
    one: &mut Vec<History>,
    other: &mut Vec<History>,
) -> Option<[History; 2]> {
    let is_half =
        |it: &History, of: &History| (it.stamp, it.pairs.len()) == (of.stamp, of.pairs.len());
    let (at, there) = one.iter().enumerate().find_map(|(at, half)| {
        let there = other.iter().position(|it| is_half(it, half))?;
        Some((at, there))
    })?;
    Some([one.swap_remove(at), other.swap_remove(there)])
}

/// A stamp for two halves, of which each has its first pair's particle at some place in the world \[m\]: no other two have the same
/// particles there.
pub(super) fn stamp(halves: &[History; 2], places: [Vec3; 2]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for (half, place) in halves.iter().zip(places) {
        half.pairs.first().map(|pair| pair.slot).hash(&mut hasher);
        half.pairs.len().hash(&mut hasher);
        place.to_array().map(f32::to_bits).hash(&mut hasher);
    }
    hasher.finish()
}

/// Anchors of the pairs of two cloths, by the slots of their particles.
#[derive(Clone, Debug, Default)]
pub(super) struct AnchorTable {
    /// Where the pairs of each first slot end; those of the next one begin there.
    ends: Vec<u32>,
    pairs: Vec<Stuck>,
}

impl AnchorTable {
    /// Fills it anew with pairs: two slots, the anchor from the second particle to the first. The first cloth has so many slots.
    pub fn fill(&mut self, slots: usize, pairs: impl Iterator<Item = ([u32; 2], Vec3)> + Clone) {
        let Self { ends, pairs: table } = self;
        ends.clear();
        if pairs.clone().next().is_none() {
            return;
        }
        ends.resize(slots + 1, 0);
        for ([first, _], _) in pairs.clone() {
            ends[first as usize + 1] += 1;
        }
        for slot in 0..slots {
            ends[slot + 1] += ends[slot];
        }
        table.clear();
        table.resize(ends[slots] as usize, Stuck { slot: 0, anchor: Vec3::ZERO });
        for ([first, slot], anchor) in pairs {
            // From where the pairs of a slot begin up to where they end.
            let end = &mut ends[first as usize];
            table[*end as usize] = Stuck { slot, anchor };
            *end += 1;
        }
    }

    /// The anchor of a pair, if it has one.
    pub fn get(&self, [first, second]: [u32; 2]) -> Option<Vec3> {
        let first = first as usize;
        let end = *self.ends.get(first)? as usize;
        let begin = first.checked_sub(1).map_or(0, |before| self.ends[before] as usize);
        let pair = self.pairs[begin..end].iter().find(|pair| pair.slot == second)?;
        Some(pair.anchor)
    }
}
