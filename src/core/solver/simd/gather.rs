//! Particles one after the other instead of coordinate by coordinate: what is gathered by index comes
//! in one piece.

use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::lanes::LANES;
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

    /// Where particles are, and their inverse masses.
    #[inline(always)]
    pub fn gather_moved(&self, t: impl Transpose, slots: &[u32], at: usize) -> (Block3, Block) {
        let slots = row(slots, at);
        // Of one length, so that one check of a slot does for both.
        let (all_x, all_d) = (&self.x[..], &self.d[..self.x.len()]);
        let [x, y, z, w] = t.apart(|i| {
            let slot = slots[i] as usize;
            sum(all_x[slot], all_d[slot])
        });
        (Block3 { x, y, z }, w)
    }

    /// Normals of what particles lie on.
    #[inline(always)]
    pub fn gather_normals(&self, t: impl Transpose, slots: &[u32], at: usize) -> Block3 {
        gather(t, &self.normals, slots, at)
    }

    /// Adds what the particles lie on bears.
    #[inline(always)]
    pub fn load(&mut self, t: impl Transpose, slots: &[u32], at: usize, load: &Block) {
        let fours = t.together(&[Block::ZERO, Block::ZERO, Block::ZERO, *load]);
        for (load, slot) in fours.into_iter().zip(row(slots, at)) {
            let to = &mut self.normals[slot as usize];
            *to = sum(*to, load);
        }
    }

    /// Displaces particles, which are all different but for the one beside the cloth.
    #[inline(always)]
    pub fn scatter(&mut self, t: impl Transpose, slots: &[u32], at: usize, by: Block3) {
        let fours = t.together(&[by.x, by.y, by.z, Block::ZERO]);
        for (by, slot) in fours.into_iter().zip(row(slots, at)) {
            let d = &mut self.d[slot as usize];
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
