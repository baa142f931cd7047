//! The particles of several cloths, as pairs of them are found.

use crate::solver::cloth_contact::couple::Couple;
use crate::solver::cloth_contact::find::{Company, Pair, WIDE};

/// No couple, in the table of couples.
pub(super) const NONE: u32 = u32::MAX;

/// The particles of several cloths. Those of one cloth are no pair.
pub(super) struct ManyCloths<'a> {
    pub owner: &'a [u32],
    pub first: &'a [u32],
    pub table: &'a [u32],
    pub couples: &'a mut [Couple],
    /// Whether there are cloths that are no couple.
    pub some_do_not_meet: bool,
}

impl ManyCloths<'_> {
    #[inline(always)]
    fn couple(&self, a: u32, b: u32) -> u32 {
        self.table[a as usize * (self.first.len() - 1) + b as usize]
    }
}

impl Company for ManyCloths<'_> {
    #[inline(always)]
    fn among(&self, lanes: u32, at: usize, place: usize) -> u32 {
        let own = self.owner[place];
        let mut bits = [0_u32; WIDE];
        for (i, &other) in self.owner[at..at + WIDE].iter().enumerate() {
            bits[i] = if other == own { 0 } else { 1 << i };
        }
        let mut lanes = lanes & bits.into_iter().fold(0, |all, bit| all | bit);
        let mut meets = lanes;
        while lanes != 0 && self.some_do_not_meet {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            if self.couple(own, self.owner[at + lane as usize]) == NONE {
                meets &= !(1 << lane);
            }
        }
        meets
    }

    #[inline(always)]
    fn take(&mut self, places: [usize; 2], pair: Pair) {
        let [a, b] = places.map(|place| self.owner[place]);
        let slot = |of: u32, slot: u32| slot - self.first[of as usize];
        let [first, second] = [slot(a, pair.slots[0]), slot(b, pair.slots[1])];
        let slots = if a < b { [first, second] } else { [second, first] };
        let couple = self.couple(a, b) as usize;
        self.couples[couple].pairs.push(Pair { slots, ..pair });
    }
}
