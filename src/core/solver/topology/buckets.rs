//! Items by the slot that each belongs to, sorted in linear time: a mesh has millions of them.

use core::ops::Range;

/// Items by slot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Buckets<T> {
    /// Items of slot i: from `first[i]` to `first[i + 1]`.
    first: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy> Buckets<T> {
    /// Items of `slots` slots, with the slot of each. Those of a slot keep their order.
    pub fn new(slots: usize, with_slots: &[(u32, T)]) -> Self {
        let mut first = vec![0; slots + 1];
        for &(slot, _) in with_slots {
            first[slot as usize + 1] += 1;
        }
        for i in 0..slots {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut items: Vec<T> = with_slots.iter().map(|&(_, item)| item).collect();
        for &(slot, item) in with_slots {
            let next = &mut next[slot as usize];
            items[*next as usize] = item;
            *next += 1;
        }
        Self { first, items }
    }

    /// Sorts the items of each slot by a key. Those of one key keep their order.
    pub fn sorted_by_key<K: Ord>(mut self, key: impl Fn(&T) -> K) -> Self {
        for slot in 0..self.slots() {
            let range = self.range(slot);
            self.items[range].sort_by_key(&key);
        }
        self
    }

    /// How many slots there are.
    pub fn slots(&self) -> u32 {
        self.first.len() as u32 - 1
    }

    /// Where the items of a slot are among all.
    pub fn range(&self, slot: u32) -> Range<usize> {
        let slot = slot as usize;
        self.first[slot] as usize..self.first[slot + 1] as usize
    }

    /// The items of a slot.
    pub fn of(&self, slot: u32) -> &[T] {
        &self.items[self.range(slot)]
    }

    /// The items of each slot, slot after slot.
    pub fn each(&self) -> impl Iterator<Item = &[T]> {
        (0..self.slots()).map(|slot| self.of(slot))
    }

    /// How many items there are, of all slots.
    pub fn len(&self) -> usize {
        self.items.len()
    }
}

impl Buckets<u32> {
    /// The slots that each is paired with, ascending, each once.
    pub fn neighbours(slots: usize, pairs: &[(u32, u32)]) -> Self {
        let all = Self::new(slots, pairs).sorted_by_key(|&to| to);
        let mut unique = Self { first: vec![0], items: Vec::new() };
        for of_slot in all.each() {
            unique.items.extend(of_slot.chunk_by(|a, b| a == b).map(|same| same[0]));
            unique.first.push(unique.items.len() as u32);
        }
        unique
    }
}
