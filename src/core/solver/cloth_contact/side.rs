//! A cloth whose particles meet others, as one side of pairs.

use bevy_math::Vec3;

use crate::solver::cloth_contact::faces::FacesAt;
use crate::solver::cloth_contact::normals::Normals;
use crate::solver::cloth_contact::support::{Rest, Support};
use crate::solver::simd::soa::Soa;

/// Where the particles of a cloth lie on colliders, which bear a part of what pushes them (`contact::active_set`).
pub(in crate::solver) struct Lying<'a> {
    /// By slot, of length one; zero where a particle lies on none.
    pub normal: &'a Soa,
    /// By slot, the part of its inverse mass that moves a particle along the surface.
    pub slip: &'a [f32],
    /// By slot, the part of its way along the surface that the collider's friction leaves it.
    pub loose: &'a [f32],
    /// By slot, velocity of the collider's surface \[m/s\].
    pub velocity: &'a Soa,
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
    /// What its particles rest on, where that is known.
    pub support: Option<&'a mut Support>,
    /// The substep's length \[s\].
    pub step: f32,
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

    /// How a particle lies on a collider, or rests on what bears a push in some direction.
    #[inline(always)]
    pub fn lies(&self, slot: usize, push: Vec3) -> Lies {
        let free = Lies { onto: Vec3::ZERO, slip: 1.0, loose: 1.0, undone: Vec3::ZERO };
        if let Some(Lying { normal, slip, loose, velocity, .. }) = &self.lying {
            let onto = normal.get(slot);
            if onto != Vec3::ZERO {
                let undone = self.undone(slot, onto, velocity.get(slot), loose[slot]);
                return Lies { onto, slip: slip[slot], loose: loose[slot], undone };
            }
            // One that has been pushed out of a collider for long is heavy.
            if slip[slot] != 1.0 {
                return Lies { slip: slip[slot], loose: loose[slot], ..free };
            }
        }
        match self.rest(slot).filter(|rest| rest.bears(push)) {
            Some(Rest { normal, velocity, loose, .. }) => {
                let undone = self.undone(slot, normal, velocity, loose);
                Lies { onto: normal, loose, undone, ..free }
            }
            None => match self.near_rest(slot).filter(|rest| rest.bears(push)) {
                Some(Rest { normal, velocity, loose, .. }) => {
                    let undone = self.undone(slot, normal, velocity, loose);
                    Lies { loose, undone, ..free }
                }
                None => free,
            },
        }
    }

    /// What holds the one of a particle's neighbours best that rests on something: threads hold the particle to that.
    fn near_rest(&self, slot: usize) -> Option<Rest> {
        let support = self.support.as_ref()?;
        let mut best: Option<Rest> = None;
        for corner in self.faces.of(slot).flatten() {
            if let Some(rest) = support.now.get(corner as usize)
                && best.is_none_or(|best| rest.loose < best.loose)
            {
                best = Some(rest);
            }
        }
        best
    }

    /// The part of a particle's displacement along a surface that friction is to undo \[m\].
    #[inline(always)]
    fn undone(&self, slot: usize, onto: Vec3, velocity: Vec3, loose: f32) -> Vec3 {
        let undone = (self.d.get(slot) - velocity * self.step) * (1.0 - loose);
        undone - onto * onto.dot(undone)
    }

    #[inline(always)]
    fn rest(&self, slot: usize) -> Option<Rest> {
        self.support.as_ref().and_then(|support| support.now.get(slot))
    }

    /// What holds a particle against a push in some direction, if anything does.
    #[inline(always)]
    pub fn holds(&self, slot: usize, push: Vec3) -> Option<Rest> {
        if self.inverse_mass[slot] == 0.0 {
            let velocity = self.d.get(slot) / self.step;
            return Some(Rest { normal: -push, velocity, loose: 0.0, level: 0.0 });
        }
        if let Some(Lying { normal, loose, velocity, .. }) = &self.lying {
            let normal = normal.get(slot);
            if normal != Vec3::ZERO {
                let (velocity, loose) = (velocity.get(slot), loose[slot]);
                return Some(Rest { normal, velocity, loose, level: 0.0 });
            }
        }
        self.rest(slot).or_else(|| self.near_rest(slot))
    }

    /// Notes that a particle rests on something.
    #[inline(always)]
    pub fn note(&mut self, slot: usize, rest: Rest) {
        if let Some(support) = &mut self.support {
            support.next.note(slot, rest);
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
        if let Some(Lying { normal, slip, load, .. }) = &mut self.lying {
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
