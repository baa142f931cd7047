//! Items by the slot that each belongs to. Sorted in linear time: a mesh has millions of them.

use core::ops::Range;

/// Items by slot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Buckets<T> {
    /// Items of slot i: from `first[i]` to `first[i + 1]`.
    first: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy> Buckets<T> {
    /// Items of `slots` slots. Those of a slot keep their order.
    pub fn new(slots: usize, items: Vec<T>, slot: impl Fn(&T) -> u32) -> Self {
        let mut first = vec![0; slots + 1];
        for item in &items {
            first[slot(item) as usize + 1] += 1;
        }
        for i in 0..slots {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut sorted = items.clone();
        for item in items {
            let next = &mut next[slot(&item) as usize];
            sorted[*next as usize] = item;
            *next += 1;
        }
        Self { first, items: sorted }
    }

    /// How many slots there are.
    fn slots(&self) -> usize {
        self.first.len() - 1
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
        (0..self.slots() as u32).map(|slot| self.of(slot))
    }

    /// The same, with those of a slot in ascending order.
    pub fn ascending(mut self) -> Self
    where
        T: Ord,
    {
        for slot in 0..self.slots() as u32 {
            let range = self.range(slot);
            self.items[range].sort_unstable();
        }
        self
    }
}

impl Buckets<u32> {
    /// What each slot is paired with, ascending, each once.
    pub fn neighbours(slots: usize, pairs: Vec<(u32, u32)>) -> Self {
        let all = Buckets::new(slots, pairs, |&(slot, _)| slot).ascending();
        let mut unique = Self { first: vec![0], items: Vec::new() };
        for of_slot in all.each() {
            unique.items.extend(of_slot.chunk_by(|a, b| a == b).map(|same| same[0].1));
            unique.first.push(unique.items.len() as u32);
        }
        unique
    }

    /// How many there are of all slots.
    pub fn len(&self) -> usize {
        self.items.len()
    }
}
