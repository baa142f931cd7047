//! What particles rest on: other particles that are held themselves, by a collider, a pin, or again by others. So what holds the
//! lowest layer of a pile holds all layers, as far as friction and pressure allow.
//!
//! Particles that touch are moved apart pair by pair. A particle in the middle of a pile that is pushed by the one above would give
//! way, as though nothing were below it, and be stopped only in the next substep: the layer above would sink in and creep down any
//! slope by what one substep does. So a push sees what rests on something as hard to move, and the push goes on downwards from
//! layer to layer (Guendelman, Bridson and Fedkiw 2003, *Nonconvex Rigid Bodies with Stacking*, section 8, propagate a shock upwards
//! in this way). It is given all momentum all the same.
//!
//! What rested on what in a substep is known in the next one.

use bevy_math::Vec3;

use crate::solver::simd::block::{Block3, larger};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::{Array, Soa};

/// Cosine of the angle between two supports, one on the other, from which on the lower one bears the upper one.
const UPRIGHT: f32 = 0.5;

/// What a particle rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::solver) struct Rest {
    /// The direction in which that faces, of length one.
    pub normal: Vec3,
    /// Velocity of what holds it in the end \[m/s\].
    pub velocity: Vec3,
    /// Part of its way along the surface that friction leaves it.
    pub loose: f32,
    /// How many particles there are between it and what holds it in the end, and one.
    pub level: f32,
}

impl Rest {
    /// Whether it bears a push in some direction.
    #[inline(always)]
    pub fn bears(&self, push: Vec3) -> bool {
        self.normal.dot(push) < 0.0
    }

    /// What rests on a particle that rests on this: it faces in a direction, and friction takes that part of its way along the surface.
    #[inline(always)]
    pub fn handed_on(&self, normal: Vec3, braked: f32) -> Option<Self> {
        let loose = 1.0 - braked * (1.0 - self.loose);
        let bears = self.normal.dot(normal) >= UPRIGHT;
        bears.then_some(Self { normal, loose, level: self.level + 1.0, ..*self })
    }
}

/// What the particles of a cloth rest on.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Support {
    /// As pushes see it in this substep.
    pub now: Rests,
    /// As they have found it, for the next one.
    pub next: Rests,
}

impl Support {
    pub fn new(slots: usize) -> Self {
        let rests = Rests::new(slots);
        Self { now: rests.clone(), next: rests }
    }

    /// Goes on to the next substep.
    pub fn turn(&mut self) {
        core::mem::swap(&mut self.now, &mut self.next);
        self.next.clear();
    }

    /// What each particle rests on that rests on anything, between two substeps.
    pub fn kept(&self) -> Vec<(usize, Rest)> {
        let slots = 0..self.next.loose.len();
        slots.filter_map(|slot| self.next.get(slot).map(|rest| (slot, rest))).collect()
    }

    /// Puts that back.
    pub fn put_back(&mut self, rests: &[(usize, Rest)]) {
        self.clear();
        for &(slot, rest) in rests {
            self.next.set(slot, rest);
        }
    }

    /// Forgets all of it.
    pub fn clear(&mut self) {
        self.now.clear();
        self.next.clear();
    }
}

/// What particles rest on in a substep, by slot.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Rests {
    any: bool,
    /// Whether any of a block rests on something.
    blocks: Vec<bool>,
    /// Zero where it rests on nothing.
    normal: Soa,
    velocity: Soa,
    loose: Array,
    level: Array,
}

impl Rests {
    fn new(slots: usize) -> Self {
        Self {
            any: false,
            blocks: vec![false; slots / LANES],
            normal: Soa::zeros(slots),
            velocity: Soa::zeros(slots),
            loose: Array::zeros(slots),
            level: Array::zeros(slots),
        }
    }

    fn clear(&mut self) {
        if !core::mem::take(&mut self.any) {
            return;
        }
        for (block, has_any) in self.blocks.iter_mut().enumerate() {
            if core::mem::take(has_any) {
                Block3::ZERO.store(&mut self.normal, block * LANES);
            }
        }
    }

    /// What the particle of a slot rests on.
    #[inline(always)]
    pub fn get(&self, slot: usize) -> Option<Rest> {
        if !self.any {
            return None;
        }
        let normal = self.normal.get(slot);
        (normal != Vec3::ZERO).then(|| Rest {
            normal,
            velocity: self.velocity.get(slot),
            loose: self.loose[slot],
            level: self.level[slot],
        })
    }

    /// Notes what a particle rests on. Of several, that which holds it best counts.
    #[inline(always)]
    pub fn note(&mut self, slot: usize, rest: Rest) {
        if self.normal.get(slot) == Vec3::ZERO || rest.loose < self.loose[slot] {
            self.set(slot, rest);
        }
    }

    pub fn set(&mut self, slot: usize, rest: Rest) {
        let Rest { normal, velocity, loose, level } = rest;
        self.any = true;
        self.blocks[slot / LANES] = true;
        self.normal.set(slot, normal);
        self.velocity.set(slot, velocity);
        self.loose[slot] = loose;
        self.level[slot] = level;
    }

    /// How many layers there are below it in the mean, where it rests on any.
    pub fn mean_level(&self) -> f32 {
        let (mut sum, mut count) = (0.0, 0.0);
        let blocks = self.blocks.iter().enumerate().filter(|&(_, &has_any)| self.any && has_any);
        for (block, _) in blocks {
            for slot in block * LANES..(block + 1) * LANES {
                if self.normal.get(slot) != Vec3::ZERO {
                    sum += self.level[slot];
                    count += 1.0;
                }
            }
        }
        sum / larger(count, 1.0)
    }
}
