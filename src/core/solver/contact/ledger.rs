//! Momentum that colliders are given of pulls that moved nothing, at the beginning of corrections and at the end of contact.

use bevy_math::Vec3;

use crate::solver::contact::active_set::{ActiveSet, slipped};
use crate::solver::contact::impulses::Share;
use crate::solver::contact::let_go::followed;
use crate::solver::simd::block::larger;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

impl ActiveSet {
    /// Gives colliders what they took of pulls that [`HoldOnto`] left out, in a substep of length `step`.
    pub fn give_left_out(&mut self, inverse_mass: &[f32], x: &Soa, step: f32) {
        let mut impulses = core::mem::take(&mut self.impulses);
        impulses.give(self.left_out(inverse_mass, x), step);
        self.impulses = impulses;
    }

    fn left_out<'a>(
        &'a self,
        inverse_mass: &'a [f32],
        x: &'a Soa,
    ) -> impl Iterator<Item = Share> + 'a {
        self.held_slots(inverse_mass).map(|(slot, w)| {
            let dropped = self.dropped.get(slot) / w;
            self.share(slot, x, dropped, dropped)
        })
    }

    /// Gives colliders what they took of pulls at what gives way, after the corrections of a substep of length `step`: it is
    /// moved by a part of its inverse mass, and no normal tells that it is held.
    pub fn give_yielding(
        &mut self,
        inverse_mass: &[f32],
        [x, d]: [&Soa; 2],
        notes: bool,
        step: f32,
    ) {
        let mut impulses = core::mem::take(&mut self.impulses);
        if impulses.are_measured() {
            impulses.give(self.yielding(inverse_mass, [x, d], notes), step);
        }
        self.impulses = impulses;
    }

    fn yielding<'a>(
        &'a self,
        inverse_mass: &'a [f32],
        [x, d]: [&'a Soa; 2],
        notes: bool,
    ) -> impl Iterator<Item = Share> + 'a {
        let yields = |&(slot, _): &(usize, f32)| self.now.normal.get(slot) == Vec3::ZERO;
        self.touching_slots(inverse_mass).filter(yields).map(move |(slot, w)| {
            let pulled = d.get(slot) - self.unpulled.get(slot);
            let given = pulled * ((1.0 / self.now.slip[slot] - 1.0) / w);
            let owed = if notes { given } else { Vec3::ZERO };
            self.share(slot, x, given, owed)
        })
    }

    /// Gives colliders what they took of what they have let go, in a substep of length `step`. Where pulls are noted, those
    /// that did not move it are not.
    pub fn give_taken(&mut self, inverse_mass: &[f32], [x, d]: [&Soa; 2], notes: bool, step: f32) {
        let mut impulses = core::mem::take(&mut self.impulses);
        impulses.give(self.taken(inverse_mass, [x, d], notes), step);
        self.impulses = impulses;
    }

    fn taken<'a>(
        &'a self,
        inverse_mass: &'a [f32],
        [x, d]: [&'a Soa; 2],
        notes: bool,
    ) -> impl Iterator<Item = Share> + 'a {
        self.held_slots(inverse_mass).filter_map(move |(slot, w)| {
            let (load, lost, n) = (self.load[slot], self.lost[slot], self.now.normal.get(slot));
            let is_let_go = load != 0.0 || lost != 0.0;
            let fallen = if lost < 0.0 { lost } else { 0.0 };
            let released = n * (larger(lost, 0.0) + followed(lost, load * w));
            let pulled = d.get(slot) - released - self.unpulled.get(slot);
            let unslipped = slipped(pulled, n) * (1.0 / self.now.slip[slot] - 1.0);
            let unfollowed = n * (load - followed(lost, load * w) / w) + unslipped / w;
            let owed = if notes { unfollowed } else { Vec3::ZERO };
            let given = unfollowed + n * (fallen / w);
            is_let_go.then(|| self.share(slot, x, given, owed))
        })
    }

    /// The share of what the particle of a slot lies on.
    fn share(&self, slot: usize, x: &Soa, given: Vec3, owed: Vec3) -> Share {
        Share { collider: self.holder[slot] as usize, at: x.get(slot), given, owed }
    }

    /// Slots of the particles that are held, and their inverse masses.
    fn held_slots<'a>(
        &'a self,
        inverse_mass: &'a [f32],
    ) -> impl Iterator<Item = (usize, f32)> + 'a {
        let all = self.touching_slots(inverse_mass);
        all.filter(|&(slot, _)| self.now.normal.get(slot) != Vec3::ZERO)
    }

    /// Slots of blocks of which any particle is held or gives way, as far as these are free to move.
    fn touching_slots<'a>(
        &'a self,
        inverse_mass: &'a [f32],
    ) -> impl Iterator<Item = (usize, f32)> + 'a {
        let blocks = self.now.blocks.iter().enumerate().filter(|&(_, &touched)| touched);
        let slots = blocks.flat_map(|(block, _)| block * LANES..(block + 1) * LANES);
        let all = slots.map(|slot| (slot, inverse_mass[slot]));
        all.filter(|&(_, w)| w > 0.0)
    }
}
