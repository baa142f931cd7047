//! A cloth, as contact with others takes it.

use bevy_math::Vec3;

use crate::solver::cloth_contact::others::OthersContact;
use crate::solver::cloth_contact::side::{Lying, Side};
use crate::solver::cloth_contact::tangles::Tangles;
use crate::solver::simd::isa::Isa;
use crate::solver::simd::soa::{Array, Soa};

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
    /// As a side of a couple, whose first slot in `found_at` is given. What does not move has displacements and inverse masses of zero.
    pub(super) fn side(
        &mut self,
        first: u32,
        found_at: &'a Soa,
        still: Option<&'a mut (Soa, Array)>,
    ) -> Side<'_> {
        if let Some((d, inverse_mass)) = still {
            (self.d, self.inverse_mass, self.lying) = (d, inverse_mass, None);
        }
        let OthersContact { tangles, normals, .. } = &mut *self.others;
        let Tangles { faces, any, is_down, .. } = tangles;
        Side {
            inverse_mass: self.inverse_mass,
            x: self.x,
            d: self.d,
            lying: self.lying.as_mut().map(Lying::reborrow),
            is_down: any.then_some(&**is_down),
            normals,
            faces,
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
