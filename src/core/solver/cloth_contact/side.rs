//! A cloth whose particles meet others, as one side of pairs.

use bevy_math::Vec3;

use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::normals::Normals;
use crate::solver::simd::soa::Soa;

/// Where the particles of a cloth lie on colliders, which bear a part of what pushes them (`contact::active_set`).
pub(in crate::solver) struct Lying<'a> {
    /// By slot, of length one; zero where a particle lies on none.
    pub normal: &'a Soa,
    /// By slot, the part of its inverse mass that moves a particle along the surface.
    pub slip: &'a [f32],
    /// By slot, what the collider bears \[kg m\].
    pub load: &'a mut [f32],
}

impl Lying<'_> {
    /// The same, for a while.
    pub fn reborrow(&mut self) -> Lying<'_> {
        Lying { normal: self.normal, slip: self.slip, load: self.load }
    }
}

/// The particles of a cloth, by slot.
pub(super) struct Side<'a> {
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    pub lying: Option<Lying<'a>>,
    /// Particles that stand down, where any do.
    pub is_down: Option<&'a [bool]>,
    pub normals: &'a mut Normals,
    pub faces: &'a FacesAt,
    /// Where its particles were when pairs were found, and the place of its first slot there \[m\].
    pub found_at: &'a Soa,
    pub first: usize,
}

impl Side<'_> {
    /// The surface's normal at a particle, where it was when pairs were found.
    #[inline(always)]
    pub fn normal(&mut self, slot: usize) -> Vec3 {
        let Self { normals, faces, found_at, first, .. } = self;
        normals.get(slot, |slot| faces.normal(slot, |slot| found_at.get(*first + slot as usize)))
    }

    /// Normal of the collider that a particle lies on, zero where it lies on none, and the part of its inverse mass that moves it along
    /// its surface.
    #[inline(always)]
    pub fn lies_on(&self, slot: usize) -> (Vec3, f32) {
        match &self.lying {
            Some(lying) => (lying.normal.get(slot), lying.slip[slot]),
            None => (Vec3::ZERO, 1.0),
        }
    }

    #[inline(always)]
    pub fn is_down(&self, slot: usize) -> bool {
        match self.is_down {
            Some(is_down) => is_down[slot],
            None => false,
        }
    }

    /// Gives a particle momentum, and moves it without speed \[kg m\].
    #[inline(always)]
    pub fn give(&mut self, slot: usize, mut momentum: Vec3, mut pushed: Vec3) {
        let mut w = self.inverse_mass[slot];
        if let Some(Lying { normal, slip, load }) = &mut self.lying {
            let onto = normal.get(slot);
            let borne = onto.dot(momentum);
            load[slot] += borne;
            momentum -= onto * borne;
            pushed -= onto * onto.dot(pushed);
            w *= slip[slot];
        }
        self.d.set(slot, self.d.get(slot) + momentum * w);
        self.x.set(slot, self.x.get(slot) + pushed * w);
    }
}
