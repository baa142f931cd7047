//! Pairs of particles of a sheet, found patch by patch: each particle of a patch with all those of another, side by side.

use bevy_math::Vec3;

use crate::solver::cloth_contact::find::{Group, NEIGHBOURS, Pair};
use crate::solver::cloth_contact::grid::NOWHERE;
use crate::solver::cloth_contact::patches::{PARTICLES, Patches, SIDE};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::soa::{Array, Soa};

/// Places whose slots follow each other: a row of a patch.
const RUN: usize = SIDE;
/// Where there is no particle.
const NONE: u32 = u32::MAX;

/// The particles of a sheet, patch by patch: the particles of a patch are the lanes of a block.
#[derive(Clone, Debug)]
pub(super) struct InPatches {
    pub patches: Patches,
    /// Slots by place, or [`NONE`].
    slots: Vec<u32>,
    /// Rest positions and radii by place \[m\].
    rest: Soa,
    radius: Array,
    /// Positions by place \[m\].
    x: Soa,
}

impl InPatches {
    /// For particles of these rest positions and radii by slot.
    pub fn new(patches: Patches, rest_of: &Soa, radius_of: &[f32]) -> Self {
        let count = patches.count() * PARTICLES;
        let mut slots = vec![NONE; count];
        let [mut rest, mut x] = [(); 2].map(|()| Soa::zeros(count));
        let mut radius = Array::zeros(count);
        for place in 0..count {
            let Some(slot) = patches.slot(place) else {
                rest.set(place, Vec3::splat(NOWHERE));
                x.set(place, Vec3::splat(NOWHERE));
                continue;
            };
            slots[place] = slot as u32;
            rest.set(place, rest_of.get(slot));
            radius[place] = radius_of[slot];
        }
        Self { patches, slots, rest, radius, x }
    }

    /// Finds the pairs of particles at these places that may touch before the cloth has moved by the margin, where two may touch that are
    /// `reach` apart now.
    pub fn find(&mut self, isa: Isa, at: &Soa, margin: f32, reach: f32, pairs: &mut Vec<Pair>) {
        self.patches.look(isa, at);
        self.patches.find_meetings(isa, reach);
        self.put(at);
        isa.run(Meet { particles: self, margin, pairs });
    }

    /// Takes in where particles are.
    fn put(&mut self, at: &Soa) {
        let axes = [(&mut self.x.x, &at.x), (&mut self.x.y, &at.y), (&mut self.x.z, &at.z)];
        for (to, from) in axes {
            let runs = self.slots.as_chunks::<RUN>().0.iter();
            for (to, slots) in to.as_chunks_mut::<RUN>().0.iter_mut().zip(runs) {
                let first = slots[0] as usize;
                if slots[RUN - 1] != NONE {
                    to.copy_from_slice(&from[first..first + RUN]);
                    continue;
                }
                for (to, &slot) in to.iter_mut().zip(slots).filter(|&(_, &slot)| slot != NONE) {
                    *to = from[slot as usize];
                }
            }
        }
    }
}

/// Compares the particles of patches that may meet.
struct Meet<'a> {
    particles: &'a InPatches,
    margin: f32,
    pairs: &'a mut Vec<Pair>,
}

impl Kernel for Meet<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { particles, margin, pairs } = self;
        let InPatches { patches, slots, rest, radius, x } = particles;
        for &[a, b] in patches.meetings() {
            let [first, other] = [a, b].map(|patch| patch as usize * PARTICLES);
            let now = Group::<PARTICLES>::load(x, radius, other);
            let at_rest = Group::<PARTICLES>::load(rest, radius, other);
            for i in (0..PARTICLES).filter(|&i| slots[first + i] != NONE) {
                let (p, r) = (x.get(first + i), radius[first + i]);
                let mut lanes = now.near(p, r, 1.0, margin);
                if a == b {
                    lanes &= !((2 << i) - 1);
                }
                if lanes == 0 {
                    continue;
                }
                lanes &= !at_rest.near(rest.get(first + i), r, NEIGHBOURS, 0.0);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let slots = [slots[first + i], slots[other + lane]];
                    pairs.push(now.pair(lane, p, r, slots));
                }
            }
        }
    }
}
