//! Particles one after the other instead of coordinate by coordinate: what is gathered by index comes
//! in one piece.

use core::ops::Range;

use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::{CutAt, SlotsOf};
use crate::solver::simd::soa::Soa;
use crate::solver::simd::transpose::{Four, Transpose};

/// Particles one after the other, to be gathered by index.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    /// Positions at the substep's start, and inverse masses.
    pub x: Vec<Four>,
    /// Displacements, and zero.
    pub d: Vec<Four>,
    /// Normals of what the particles lie on, and what that bears.
    pub normals: Vec<Four>,
}

impl Places {
    pub fn new(slots: usize) -> Self {
        let none = vec![Four::default(); slots];
        Self { x: none.clone(), d: none.clone(), normals: none }
    }

    /// All of them, to be cut into parts.
    pub fn part_mut(&mut self) -> PlacesMut<'_> {
        let Self { x, d, normals } = self;
        let [x, d, normals] = [x, d, normals].map(|fours| SlotsOf::all(fours));
        PlacesMut { x, d, normals }
    }
}

/// The places of some neighbouring slots, written while others write those of the rest. What is gathered is counted from
/// the first of them.
#[derive(Debug)]
pub(crate) struct PlacesMut<'a> {
    pub x: SlotsOf<'a, Four>,
    pub d: SlotsOf<'a, Four>,
    pub normals: SlotsOf<'a, Four>,
}

impl CutAt for PlacesMut<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let [(x, x_below), (d, d_below), (normals, normals_below)] =
            [self.x, self.d, self.normals].map(|fours| fours.cut(slot));
        (Self { x, d, normals }, Self { x: x_below, d: d_below, normals: normals_below })
    }
}

impl PlacesMut<'_> {
    /// The places of some slots.
    #[inline(always)]
    pub fn within(&mut self, slots: &Range<usize>) -> PlacesMut<'_> {
        let Self { x, d, normals } = self;
        PlacesMut { x: x.within(slots), d: d.within(slots), normals: normals.within(slots) }
    }

    /// Where particles are, and their inverse masses.
    #[inline(always)]
    pub fn gather_moved(&self, t: impl Transpose, slots: &[u32], at: usize) -> (Block3, Block) {
        let slots = row(slots, at);
        // Of one length, so that one check of a slot does for both.
        let (all_x, all_d) = (&*self.x.values, &self.d.values[..self.x.values.len()]);
        let [x, y, z, w] = t.apart(|i| {
            let slot = slots[i] as usize;
            sum(all_x[slot], all_d[slot])
        });
        (Block3 { x, y, z }, w)
    }

    /// Where particles are, their inverse masses, and normals of what they lie on.
    #[inline(always)]
    pub fn gather_lying(
        &self,
        t: impl Transpose,
        slots: &[u32],
        at: usize,
    ) -> (Block3, Block, Block3) {
        let slots = row(slots, at);
        let all_x = &*self.x.values;
        let (all_d, all_n) = (&self.d.values[..all_x.len()], &self.normals.values[..all_x.len()]);
        let [x, y, z, w] = t.apart(|i| {
            let slot = slots[i] as usize;
            sum(all_x[slot], all_d[slot])
        });
        let [nx, ny, nz, _] = t.apart(|i| all_n[slots[i] as usize]);
        (Block3 { x, y, z }, w, Block3 { x: nx, y: ny, z: nz })
    }

    /// [`scatter`](Self::scatter), and adds what the particles lie on bears.
    #[inline(always)]
    pub fn scatter_lying(
        &mut self,
        t: impl Transpose,
        slots: &[u32],
        at: usize,
        by: Block3,
        load: &Block,
    ) {
        let fours = t.together(&[by.x, by.y, by.z, Block::ZERO]);
        let loads = t.together(&[Block::ZERO, Block::ZERO, Block::ZERO, *load]);
        let all_d = &mut *self.d.values;
        let all_n = &mut self.normals.values[..all_d.len()];
        for (i, slot) in row(slots, at).into_iter().enumerate() {
            let slot = slot as usize;
            all_d[slot] = sum(all_d[slot], fours[i]);
            all_n[slot] = sum(all_n[slot], loads[i]);
        }
    }

    /// Displaces particles, which are all different but for those that are displaced by nothing.
    #[inline(always)]
    pub fn scatter(&mut self, t: impl Transpose, slots: &[u32], at: usize, by: Block3) {
        let fours = t.together(&[by.x, by.y, by.z, Block::ZERO]);
        for (by, slot) in fours.into_iter().zip(row(slots, at)) {
            let d = &mut self.d.values[slot as usize];
            *d = sum(*d, by);
        }
    }
}

/// Slots of a row of a table.
#[inline(always)]
fn row(slots: &[u32], at: usize) -> [u32; LANES] {
    let mut out = [0; LANES];
    out.copy_from_slice(&slots[at..at + LANES]);
    out
}

#[inline(always)]
fn sum(mut a: Four, b: Four) -> Four {
    for (a, b) in a.0.iter_mut().zip(b.0) {
        *a += b;
    }
    a
}

/// Vectors of a list.
#[inline(always)]
pub(crate) fn gather(t: impl Transpose, vectors: &[Four], indices: &[u32], at: usize) -> Block3 {
    let indices = row(indices, at);
    let [x, y, z, _] = t.apart(|i| vectors[indices[i] as usize]);
    Block3 { x, y, z }
}

/// Vectors of slots that are counted from one of them.
#[inline(always)]
pub(crate) fn gather_from(vectors: &Soa, first: usize, slots: &[u32], at: usize) -> Block3 {
    let mut out = Block3::ZERO;
    for (i, slot) in row(slots, at).into_iter().enumerate() {
        out.set(i, vectors.get(first + slot as usize));
    }
    out
}

/// Neighbouring vectors and what is with them.
#[inline(always)]
pub(crate) fn load(t: impl Transpose, fours: &[Four], at: usize) -> (Block3, Block) {
    let fours = &fours[at..at + LANES];
    let [x, y, z, w] = t.apart(|i| fours[i]);
    (Block3 { x, y, z }, w)
}

/// Puts neighbouring vectors.
#[inline(always)]
pub(crate) fn store(t: impl Transpose, fours: &mut [Four], at: usize, vector: Block3, w: Block) {
    fours[at..at + LANES].copy_from_slice(&t.together(&[vector.x, vector.y, vector.z, w]));
}
