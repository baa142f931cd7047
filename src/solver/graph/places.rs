//! Particles one after the other instead of coordinate by coordinate: what is gathered by index comes
//! in one piece.

use bevy::math::Vec3;

use crate::solver::isa::Kernel;
use crate::solver::lanes::{Block, Block3, LANES, Soa};

/// Position and inverse mass, then displacement, of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Place {
    pub x: [f32; 4],
    pub d: [f32; 4],
}

impl Place {
    /// Where the particle is.
    #[inline(always)]
    pub fn position(&self) -> Vec3 {
        Vec3::new(self.x[0] + self.d[0], self.x[1] + self.d[1], self.x[2] + self.d[2])
    }

    #[inline(always)]
    pub fn inverse_mass(&self) -> f32 {
        self.x[3]
    }

    #[inline(always)]
    pub fn displace(&mut self, by: Vec3) {
        self.d[0] += by.x;
        self.d[1] += by.y;
        self.d[2] += by.z;
    }
}

/// Slots of a row of a table.
#[inline(always)]
pub(super) fn row(slots: &[u32], at: usize) -> [u32; LANES] {
    let mut out = [0; LANES];
    out.copy_from_slice(&slots[at..at + LANES]);
    out
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
