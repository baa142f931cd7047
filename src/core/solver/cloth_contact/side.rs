//! A cloth whose particles meet others, as one side of pairs.

use crate::solver::cloth_contact::beads::Beads;
use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::grains::{Grains, Spots};
use crate::solver::cloth_contact::normals;
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;
use crate::solver::simd::transpose::Transpose;

/// The particles of a cloth, by slot.
pub(super) struct Side<'a> {
    pub beads: &'a mut Beads,
    /// Momentum that colliders bear, where particles lie on any \[kg m\].
    pub load: Option<&'a mut [f32]>,
    pub faces: &'a FacesAt,
    /// Where its particles were when pairs were found, and the place of its first slot there \[m\].
    pub found_at: &'a Soa,
    pub first: usize,
    /// Whether friction with colliders holds particles where they are pushed without speed. Layers that lie on each other creep by what
    /// it does not hold. A heap of one cloth would be held in its tangles.
    pub is_held: bool,
}

/// Momentum and moves for the particles of one side of a batch.
pub(super) struct Given {
    /// Momentum \[kg m\].
    pub momentum: Block3,
    /// A push \[kg m\] and a way \[m\] that move them without speed.
    pub pushed: Block3,
    pub back: Block3,
}

impl Side<'_> {
    /// The surface's normals at the particles that touch, where they were when pairs were found.
    #[inline(always)]
    fn normals(
        &mut self,
        t: impl Transpose,
        slots: &[u32; LANES],
        touches: &[u32; LANES],
    ) -> Block3 {
        let Self { beads, faces, found_at, first, .. } = self;
        let normal = |slot| faces.normal(slot, |slot| found_at.get(*first + slot as usize));
        normals::gather(t, beads, slots, touches, normal)
    }

    /// The numbers of particles at some slots, those that touch.
    #[inline(always)]
    pub fn grains(
        &mut self,
        t: impl Transpose,
        slots: &[u32; LANES],
        touches: &[u32; LANES],
        spots: &Spots,
    ) -> Grains {
        let mut grains = Grains::free(self.normals(t, slots, touches), spots);
        if self.load.is_some() {
            grains.lie(t, self.beads, slots, &spots.d);
            grains.pushed = if self.is_held { grains.loose } else { grains.slipping };
        }
        grains
    }

    /// Gives particles momentum, and moves them without speed, those of some lanes.
    #[inline(always)]
    pub fn give(
        &mut self,
        t: impl Transpose,
        slots: &[u32; LANES],
        lanes: &[u32; LANES],
        (spots, grains): (&Spots, &Grains),
        given: &Given,
    ) {
        let Spots { mut x, mut d, inverse_mass, down } = *spots;
        let mut borne = Block::ZERO;
        for i in 0..LANES {
            let (mut momentum, mut pushed, mut back) =
                (given.momentum.at(i), given.pushed.at(i), given.back.at(i));
            if self.load.is_some() {
                let onto = grains.onto.at(i);
                borne.0[i] = onto.dot(momentum);
                momentum -= onto * borne.0[i];
                pushed -= onto * onto.dot(pushed);
                back -= onto * onto.dot(back);
            }
            d.set(i, d.at(i) + momentum * grains.slipping.0[i]);
            x.set(i, x.at(i) + pushed * grains.pushed.0[i] + back);
        }
        let x = t.together(&[x.x, x.y, x.z, inverse_mass]);
        let d = t.together(&[d.x, d.y, d.z, down]);
        for i in (0..LANES).filter(|&i| lanes[i] != 0) {
            let bead = &mut self.beads.all[slots[i] as usize];
            (bead.x, bead.d) = (x[i], d[i]);
        }
        if let Some(load) = &mut self.load {
            for i in (0..LANES).filter(|&i| lanes[i] != 0) {
                load[slots[i] as usize] += borne.0[i];
            }
        }
    }
}
