//! The particles of a cloth one after the other, while pairs of them are met.
//!
//! A batch takes its particles from anywhere. Picked number by number, out of one array for each coordinate, they took nearly half of
//! the response's time.

use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::gather::store;
use crate::solver::simd::isa::{Isa, TransposingKernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;
use crate::solver::simd::transpose::{Four, Transpose};

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

/// A particle.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Bead {
    /// Where the substep began \[m\], and the inverse mass \[1/kg\].
    pub x: Four,
    /// The displacement \[m\], and 1 where it stands down, else 0.
    pub d: Four,
}

/// Particles by slot, those of the blocks that are in pairs. The others are as they were once.
#[derive(Clone, Debug)]
pub(super) struct Beads {
    pub all: Vec<Bead>,
    /// The cloth's normals where pairs were found, and 1 where one is known.
    pub normals: Vec<Four>,
    /// Normals of the colliders that particles lie on, and the part of an inverse mass that moves one along the surface.
    pub onto: Vec<Four>,
    /// How far the surfaces that particles lie on move in the substep \[m\], and the part of their way along them that friction leaves.
    pub carried: Vec<Four>,
    /// By block of slots.
    is_in_pairs: Vec<bool>,
}

/// A cloth that particles are taken from, in a substep.
pub(super) struct TakenFrom<'a> {
    pub x: &'a Soa,
    /// Displacements and inverse masses, where the cloth moves \[m, 1/kg\].
    pub moves: Option<(&'a Soa, &'a [f32])>,
    /// Where its particles lie on colliders, if any do.
    pub lying: Option<&'a Lying<'a>>,
    /// Particles that stand down, where any do.
    pub is_down: Option<&'a [bool]>,
}

impl Beads {
    pub fn new(slots: usize) -> Self {
        let blocks = slots.div_ceil(LANES);
        let none = vec![Four::default(); blocks * LANES];
        Self {
            all: vec![Bead::default(); blocks * LANES],
            normals: none.clone(),
            onto: none.clone(),
            carried: none,
            is_in_pairs: vec![false; blocks],
        }
    }

    /// There are other pairs from now on, of which none is known yet.
    pub fn forget_pairs(&mut self) {
        let Self { normals, is_in_pairs, .. } = self;
        // No others are known.
        for at in Self::blocks(is_in_pairs) {
            normals[at..at + LANES].fill(Four::default());
        }
        is_in_pairs.fill(false);
    }

    /// The particle at a slot is in a pair.
    #[inline(always)]
    pub fn note(&mut self, slot: u32) {
        self.is_in_pairs[slot as usize / LANES] = true;
    }

    /// Takes particles in.
    pub fn take_in(&mut self, isa: Isa, from: TakenFrom<'_>) {
        isa.run_transposing(TakeIn { beads: self, from });
    }

    /// Puts back where particles have come to.
    pub fn put_back(&self, isa: Isa, x: &mut Soa, d: &mut Soa) {
        isa.run_transposing(PutBack { beads: self, x, d });
    }

    /// The first slots of the blocks that are in pairs.
    #[inline(always)]
    fn blocks(is_in_pairs: &[bool]) -> impl Iterator<Item = usize> + '_ {
        let blocks = is_in_pairs.iter().enumerate().filter(|(_, is_in_pairs)| **is_in_pairs);
        blocks.map(|(block, _)| block * LANES)
    }
}

struct TakeIn<'a> {
    beads: &'a mut Beads,
    from: TakenFrom<'a>,
}

impl TransposingKernel for TakeIn<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Beads { all, onto, carried, is_in_pairs, .. } = self.beads;
        let from = &self.from;
        for at in Beads::blocks(is_in_pairs) {
            let mut down = Block::ZERO;
            if let Some(is_down) = from.is_down {
                let is_down = &is_down[at..(at + LANES).min(is_down.len())];
                for (down, &is_down) in down.0.iter_mut().zip(is_down) {
                    *down = if is_down { 1.0 } else { 0.0 };
                }
            }
            let (d, w) = match from.moves {
                Some((d, w)) => (Block3::load(d, at), Block::load(w, at)),
                None => (Block3::ZERO, Block::ZERO),
            };
            let (beads, _) = all[at..].as_chunks_mut();
            let beads: &mut [Bead; LANES] = &mut beads[0];
            let x = Block3::load(from.x, at);
            let [x, d] = [t.together(&[x.x, x.y, x.z, w]), t.together(&[d.x, d.y, d.z, down])];
            for i in 0..LANES {
                beads[i] = Bead { x: x[i], d: d[i] };
            }
            if let Some(Lying { normal, slip, loose, velocity, step, .. }) = from.lying {
                let mut way = Block3::load(*velocity, at);
                for i in 0..LANES {
                    way.set(i, way.at(i) * *step);
                }
                store(t, carried, at, way, Block::load(loose, at));
                store(t, onto, at, Block3::load(*normal, at), Block::load(slip, at));
            }
        }
    }
}

struct PutBack<'a> {
    beads: &'a Beads,
    x: &'a mut Soa,
    d: &'a mut Soa,
}

impl TransposingKernel for PutBack<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Self { beads, x, d } = self;
        for at in Beads::blocks(&beads.is_in_pairs) {
            let beads = &beads.all[at..at + LANES];
            let [px, py, pz, _] = t.apart(|i| beads[i].x);
            let [dx, dy, dz, _] = t.apart(|i| beads[i].d);
            Block3 { x: px, y: py, z: pz }.store(x, at);
            Block3 { x: dx, y: dy, z: dz }.store(d, at);
        }
    }
}
