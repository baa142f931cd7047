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
    /// By slot, the part of its way along the surface that the collider's friction leaves it.
    pub loose: &'a [f32],
    /// By slot, velocity of the collider's surface \[m/s\], and the substep's length \[s\].
    pub velocity: &'a Soa,
    pub step: f32,
    /// By slot, what the collider bears \[kg m\].
    pub load: &'a mut [f32],
}

impl Lying<'_> {
    /// The same, for a while.
    pub fn reborrow(&mut self) -> Lying<'_> {
        Lying { load: self.load, ..*self }
    }
}

/// How a particle lies on a collider, if it does.
pub(super) struct Lies {
    /// Normal of the collider, zero where it lies on none.
    pub onto: Vec3,
    /// Part of its inverse mass that moves it along the surface, and part that is left of that when friction has held it.
    pub slip: f32,
    pub loose: f32,
    /// Part of its displacement that the collider's friction is to undo \[m\].
    pub undone: Vec3,
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
    /// Whether friction with colliders holds particles where they are pushed without speed. Layers that lie on each other creep by what
    /// it does not hold. A heap of one cloth would be held in its tangles.
    pub is_held: bool,
}

impl Side<'_> {
    /// The surface's normal at a particle, where it was when pairs were found.
    #[inline(always)]
    pub fn normal(&mut self, slot: usize) -> Vec3 {
        let Self { normals, faces, found_at, first, .. } = self;
        normals.get(slot, |slot| faces.normal(slot, |slot| found_at.get(*first + slot as usize)))
    }

    /// How a particle lies on a collider.
    #[inline(always)]
    pub fn lies(&self, slot: usize) -> Lies {
        match &self.lying {
            Some(Lying { normal, slip, loose, velocity, step, .. }) => {
                let (onto, loose) = (normal.get(slot), loose[slot]);
                let undone = (self.d.get(slot) - velocity.get(slot) * *step) * (1.0 - loose);
                let undone = undone - onto * onto.dot(undone);
                let undone = if onto == Vec3::ZERO { Vec3::ZERO } else { undone };
                Lies { onto, slip: slip[slot], loose, undone }
            }
            None => Lies { onto: Vec3::ZERO, slip: 1.0, loose: 1.0, undone: Vec3::ZERO },
        }
    }

    #[inline(always)]
    pub fn is_down(&self, slot: usize) -> bool {
        match self.is_down {
            Some(is_down) => is_down[slot],
            None => false,
        }
    }

    /// Gives a particle momentum, and moves it without speed: by a push \[kg m\], and by a way \[m\].
    #[inline(always)]
    pub fn give(&mut self, slot: usize, mut momentum: Vec3, mut pushed: Vec3, mut back: Vec3) {
        let mut w = self.inverse_mass[slot];
        let mut held = 1.0;
        if let Some(Lying { normal, slip, loose, load, .. }) = &mut self.lying {
            let onto = normal.get(slot);
            let borne = onto.dot(momentum);
            load[slot] += borne;
            momentum -= onto * borne;
            pushed -= onto * onto.dot(pushed);
            back -= onto * onto.dot(back);
            w *= slip[slot];
            held = if self.is_held { loose[slot] } else { 1.0 };
        }
        self.d.set(slot, self.d.get(slot) + momentum * w);
        self.x.set(slot, self.x.get(slot) + pushed * (w * held) + back);
    }
}
