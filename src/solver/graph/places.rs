//! Particles one after the other instead of coordinate by coordinate: what is gathered by index comes
//! in one piece.

use bevy::math::Vec3;

use crate::solver::isa::Kernel;
use crate::solver::lanes::{Block, Block3, LANES, Soa};

/// Position and inverse mass, then displacement and zero, of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Place {
    pub x: [f32; 4],
    pub d: [f32; 4],
}

impl Place {
    #[inline(always)]
    pub fn inverse_mass(&self) -> f32 {
        self.x[3]
    }
}

/// Slots of a row of a table.
#[inline(always)]
fn row(slots: &[u32], at: usize) -> [u32; LANES] {
    let mut out = [0; LANES];
    out.copy_from_slice(&slots[at..at + LANES]);
    out
}

/// What is gathered, before its coordinates are put apart: in this form each piece is one load.
type Tile = [[f32; 4]; LANES];

#[inline(always)]
fn apart(tile: &Tile) -> (Block3, Block) {
    let (mut vector, mut fourth) = (Block3::ZERO, Block::ZERO);
    for (i, piece) in tile.iter().enumerate() {
        vector.x.0[i] = piece[0];
        vector.y.0[i] = piece[1];
        vector.z.0[i] = piece[2];
        fourth.0[i] = piece[3];
    }
    (vector, fourth)
}

/// Where particles are, and their inverse masses.
#[inline(always)]
pub(super) fn gather_moved(places: &[Place], slots: &[u32], at: usize) -> (Block3, Block) {
    let mut tile: Tile = [[0.0; 4]; LANES];
    for (piece, slot) in tile.iter_mut().zip(row(slots, at)) {
        let place = &places[slot as usize];
        for (sum, (x, d)) in piece.iter_mut().zip(place.x.iter().zip(&place.d)) {
            *sum = x + d;
        }
    }
    apart(&tile)
}

/// Where particles were at the substep's start.
#[inline(always)]
pub(super) fn gather_positions(places: &[Place], slots: &[u32], at: usize) -> Block3 {
    let mut tile: Tile = [[0.0; 4]; LANES];
    for (piece, slot) in tile.iter_mut().zip(row(slots, at)) {
        *piece = places[slot as usize].x;
    }
    apart(&tile).0
}

/// Vectors of a list.
#[inline(always)]
pub(super) fn gather_vectors(vectors: &[[f32; 4]], indices: &[u32], at: usize) -> Block3 {
    let mut tile: Tile = [[0.0; 4]; LANES];
    for (piece, index) in tile.iter_mut().zip(row(indices, at)) {
        *piece = vectors[index as usize];
    }
    apart(&tile).0
}

/// Vectors that lie coordinate by coordinate.
#[inline(always)]
pub(super) fn gather_soa(vectors: &Soa, slots: &[u32], at: usize) -> Block3 {
    let mut out = Block3::ZERO;
    for (i, slot) in row(slots, at).into_iter().enumerate() {
        out.set(i, vectors.get(slot as usize));
    }
    out
}

/// Displaces particles.
#[inline(always)]
pub(super) fn scatter(places: &mut [Place], slots: &[u32], at: usize, by: &Block3) {
    let mut tile: Tile = [[0.0; 4]; LANES];
    for (i, piece) in tile.iter_mut().enumerate() {
        *piece = [by.x.0[i], by.y.0[i], by.z.0[i], 0.0];
    }
    for (piece, slot) in tile.iter().zip(row(slots, at)) {
        for (d, by) in places[slot as usize].d.iter_mut().zip(piece) {
            *d += by;
        }
    }
}

/// Fills the places.
pub(crate) struct FillPlaces<'a> {
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    pub places: &'a mut [Place],
}

impl Kernel for FillPlaces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (block, places) in self.places.chunks_exact_mut(LANES).enumerate() {
            let slot = block * LANES;
            let (x, d) = (Block3::load(self.x, slot), Block3::load(self.d, slot));
            let w = Block::load(self.inverse_mass, slot);
            for (i, place) in places.iter_mut().enumerate() {
                place.x = [x.x.0[i], x.y.0[i], x.z.0[i], w.0[i]];
                place.d = [d.x.0[i], d.y.0[i], d.z.0[i], 0.0];
            }
        }
    }
}

/// Takes the displacements back.
pub(crate) struct TakeDisplacements<'a> {
    pub places: &'a [Place],
    pub d: &'a mut Soa,
}

impl Kernel for TakeDisplacements<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (block, places) in self.places.chunks_exact(LANES).enumerate() {
            let mut d = Block3::ZERO;
            for (i, place) in places.iter().enumerate() {
                d.set(i, Vec3::new(place.d[0], place.d[1], place.d[2]));
            }
            d.store(self.d, block * LANES);
        }
    }
}
