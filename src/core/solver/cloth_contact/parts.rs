//! A cloth, as contact with others takes it.

use bevy_math::Vec3;

use crate::solver::cloth_contact::beads::{Lying, TakenFrom};
use crate::solver::cloth_contact::others::OthersContact;
use crate::solver::cloth_contact::side::Side;
use crate::solver::cloth_contact::tangles::Tangles;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::Soa;

/// A cloth, as contact with others takes it in a substep.
pub(in crate::solver) struct Parts<'a> {
    pub isa: Isa,
    /// Whether it takes the tick. What does not is as hard to move as a wall.
    pub moves: bool,
    /// Where its coordinates begin at the substep's end \[m\].
    pub origin: Vec3,
    /// How far they are moved in the substep \[m\].
    pub drift: Vec3,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Where its particles lie on colliders, if any do.
    pub lying: Option<Lying<'a>>,
    /// How far a pair is moved apart in the substep at most, without speed \[m\].
    pub most_push: f32,
    pub others: &'a mut OthersContact,
}

impl<'a> Parts<'a> {
    /// Takes in the particles that are in pairs. What does not move has displacements and inverse masses of zero.
    pub(super) fn take_in(&mut self) {
        let Self { isa, moves, x, d, inverse_mass, lying, others, .. } = self;
        let OthersContact { beads, tangles, .. } = &mut **others;
        beads.take_in(
            *isa,
            TakenFrom {
                x,
                moves: moves.then_some((d, inverse_mass)),
                lying: lying.as_ref().filter(|_| *moves),
                is_down: tangles.any.then_some(&*tangles.is_down),
            },
        );
    }

    /// Puts back where these have come to.
    pub(super) fn put_back(&mut self) {
        if self.moves {
            self.others.beads.put_back(self.isa, self.x, self.d);
        }
    }

    /// As a side of a couple, whose first slot in `found_at` is given.
    pub(super) fn side(&mut self, first: u32, found_at: &'a Soa) -> Side<'_> {
        let OthersContact { tangles, beads, .. } = &mut *self.others;
        Side {
            beads,
            load: self.lying.as_mut().filter(|_| self.moves).map(|lying| &mut *lying.load),
            faces: &tangles.faces,
            found_at,
            first: first as usize,
            is_held: true,
        }
    }

    /// Where its particles are at the substep's end, and which of them stand down.
    pub(super) fn places(self) -> (Places<'a>, &'a mut Tangles) {
        let Self { x, d, moves, others, .. } = self;
        (Places { x, d: moves.then_some(d) }, &mut others.tangles)
    }
}

/// Where particles of a cloth are at a substep's end, in its own coordinates.
#[derive(Clone, Copy)]
pub(super) struct Places<'a> {
    x: &'a Soa,
    /// Displacements, where it moves \[m\].
    d: Option<&'a Soa>,
}

impl Places<'_> {
    #[inline]
    pub(super) fn at(&self, slot: u32) -> Vec3 {
        let slot = slot as usize;
        self.x.get(slot) + self.d.map_or(Vec3::ZERO, |d| d.get(slot))
    }
}

/// What is stepped together with others.
pub(in crate::solver) trait Body {
    /// Its parts, where it collides with other cloths.
    fn parts(&mut self) -> Option<Parts<'_>>;
}
