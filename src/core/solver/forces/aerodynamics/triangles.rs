//! Air on any triangles: forces by triangle, then gathered by particle.
//!
//! A triangle's velocity is the mean of its corners', and a third of its force goes to each. Every
//! particle adds up those of its triangles in their order, so that nothing is scattered and the sum
//! is the same on every machine.
//!
//! The numbers that a triangle needs of a corner (position, displacement, acceleration) are packed into one
//! cache line a particle first, so that a corner is one load: three arrays of three axes would be nine.

use bevy_math::Vec3;

use crate::solver::forces::aerodynamics::Flow;
use crate::solver::forces::aerodynamics::shares::{Face, shares};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::{Array, Soa};

/// Floats that are packed for a particle: position, displacement, acceleration, position again.
const PACKED: usize = LANES;
/// Numbers of a triangle's force in memory: three, and one to make a vector register.
const FORCE: usize = 4;

/// How the packed numbers of the first, second and third corner are added up to what a triangle needs: an
/// edge, three times its displacement and acceleration, and the other edge.
const SIGNS: [[f32; LANES]; 3] = {
    let mut signs = [[0.0; LANES]; 3];
    let mut i = 0;
    while i < 12 {
        let corners = match i {
            0..3 => [-1.0, 1.0, 0.0],
            3..9 => [1.0, 1.0, 1.0],
            _ => [-1.0, 0.0, 1.0],
        };
        let mut k = 0;
        while k < 3 {
            signs[k][i] = corners[k];
            k += 1;
        }
        i += 1;
    }
    signs
};

/// Triangles by their corners, and which of them are around each particle.
#[derive(Clone, Debug)]
pub(super) struct Triangles {
    layout: Layout,
    /// Particles, counted in whole blocks row by row, of the first, second and third corners; padded to
    /// whole blocks.
    corners: [Vec<u32>; 3],
    /// For each block of particles, row by row, where its entries in `around` begin; one more at the
    /// end.
    begins: Vec<u32>,
    /// [`LANES`] triangles at a time, one of each particle of a block; `none` where it has no more.
    around: Vec<u32>,
    /// Packed particles, which the corners are loaded from.
    packed: Array,
    /// A third of each triangle's force, and a zero behind the last.
    forces: Array,
}

impl Triangles {
    /// Triangles of particles that lie in a layout, row by row; their rest positions, and the area
    /// of cloth that the particle of each slot stands for. Also gives the inverse of the area whose
    /// mass takes each triangle's force \[1/m2\], 0 for padding.
    pub fn new(
        layout: Layout,
        triangles: &[[u32; 3]],
        rest: &[Vec3],
        particle_area: &[f32],
    ) -> (Self, Vec<f32>) {
        let slot = |p: u32| layout.slot(p as usize / layout.columns, p as usize % layout.columns);
        let faces: Vec<_> = triangles
            .iter()
            .map(|&corners| {
                let [a, b, c] = corners.map(|p| rest[p as usize]);
                Face { corners: corners.map(slot), area: 0.5 * (b - a).cross(c - a).length() }
            })
            .collect();
        let padded = faces.len().next_multiple_of(LANES);
        let width = layout.columns.next_multiple_of(LANES) as u32;
        let columns = layout.columns as u32;
        let mut corners = [(); 3].map(|()| vec![0; padded]);
        let mut at_particle = vec![Vec::new(); layout.rows * layout.columns];
        for (i, particles) in triangles.iter().enumerate() {
            for k in 0..3 {
                let (row, column) = (particles[k] / columns, particles[k] % columns);
                corners[k][i] = row * width + column;
                at_particle[particles[k] as usize].push(i as u32);
            }
        }
        let (begins, around) = blocks(layout, &at_particle, padded as u32);
        let packed = Array::zeros(layout.rows * width as usize * PACKED);
        let forces = Array::zeros((padded + 1) * FORCE);
        let mut inverse = shares(&faces, particle_area);
        inverse.resize(padded, 0.0);
        (Self { layout, corners, begins, around, packed, forces }, inverse)
    }

    /// Packs four vectors of each particle.
    #[inline(always)]
    fn pack(&mut self, of: [&Soa; 4]) {
        let mut at = 0;
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let vectors = [0, 1, 2, 3].map(|k: usize| Block3::load(of[k], slot));
                for i in 0..LANES {
                    let to = &mut self.packed[at..at + PACKED];
                    for (k, vector) in vectors.iter().enumerate() {
                        to[3 * k] = vector.x.0[i];
                        to[3 * k + 1] = vector.y.0[i];
                        to[3 * k + 2] = vector.z.0[i];
                    }
                    at += PACKED;
                }
            }
        }
    }

    /// The packed numbers of one corner of a triangle.
    #[inline(always)]
    fn corner(&self, corner: usize, face: usize) -> Block {
        Block::load(&self.packed, self.corners[corner][face] as usize * PACKED)
    }
}

/// Lists by particle as lists by block, each as long as its longest.
fn blocks(layout: Layout, at_particle: &[Vec<u32>], none: u32) -> (Vec<u32>, Vec<u32>) {
    let (mut begins, mut around) = (vec![0], Vec::new());
    for row in at_particle.chunks(layout.columns) {
        for block in row.chunks(LANES) {
            let longest = block.iter().map(Vec::len).max().unwrap_or(0);
            for i in 0..longest {
                let lane = |l: usize| block.get(l).and_then(|list| list.get(i)).copied();
                around.extend((0..LANES).map(|l| lane(l).unwrap_or(none)));
            }
            begins.push(around.len() as u32);
        }
    }
    (begins, around)
}

/// Works out where the triangles' centres are.
pub(super) struct FindCentres<'a> {
    pub triangles: &'a mut Triangles,
    pub x: &'a Soa,
    pub centres: &'a mut Soa,
}

impl Kernel for FindCentres<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.triangles.pack([self.x; 4]);
        for face in (0..self.triangles.corners[0].len()).step_by(LANES) {
            let mut tile = [Block::ZERO; LANES];
            for (i, sum) in tile.iter_mut().enumerate() {
                let [a, b, c] = [0, 1, 2].map(|k| self.triangles.corner(k, face + i));
                for l in 0..LANES {
                    sum.0[l] = (a.0[l] + b.0[l] + c.0[l]) * (1.0 / 3.0);
                }
            }
            vectors(&tile, 0).store(self.centres, face);
        }
    }
}

/// Adds what the air does to the triangles to the particles' accelerations.
pub(super) struct PushTriangles<'a> {
    pub triangles: &'a mut Triangles,
    pub flow: Flow<'a>,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// Accelerations by all other forces, then by all forces.
    pub a: &'a mut Soa,
}

impl Kernel for PushTriangles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.triangles.pack([self.x, self.d, self.a, self.x]);
        for face in (0..self.triangles.corners[0].len()).step_by(LANES) {
            self.push(face);
        }
        let layout = self.triangles.layout;
        let mut block = 0;
        for row in 0..layout.rows {
            for column in (0..layout.columns).step_by(LANES) {
                self.gather(block, layout.slot(row, column));
                block += 1;
            }
        }
    }
}

impl PushTriangles<'_> {
    #[inline(always)]
    fn push(&mut self, face: usize) {
        let mut tile = [Block::ZERO; LANES];
        for (i, out) in tile.iter_mut().enumerate() {
            let a = self.triangles.corner(0, face + i);
            let b = self.triangles.corner(1, face + i);
            let c = self.triangles.corner(2, face + i);
            for (l, sum) in out.0.iter_mut().enumerate() {
                *sum = a.0[l] * SIGNS[0][l] + b.0[l] * SIGNS[1][l] + c.0[l] * SIGNS[2][l];
            }
        }
        let (edge, other) = (vectors(&tile, 0), vectors(&tile, 9));
        let (mut d, mut a) = (vectors(&tile, 3), vectors(&tile, 6));
        let mut area = Block3::ZERO;
        for i in 0..LANES {
            area.set(i, edge.at(i).cross(other.at(i)) * 0.5);
            d.set(i, d.at(i) * (1.0 / 3.0));
            a.set(i, a.at(i) * (1.0 / 3.0));
        }
        let force = self.flow.forces(face, area, d, a);
        for i in 0..LANES {
            let at = (face + i) * FORCE;
            let to = &mut self.triangles.forces[at..at + FORCE];
            to[0] = force.x.0[i] * (1.0 / 3.0);
            to[1] = force.y.0[i] * (1.0 / 3.0);
            to[2] = force.z.0[i] * (1.0 / 3.0);
        }
    }

    #[inline(always)]
    fn gather(&mut self, block: usize, slot: usize) {
        let Triangles { begins, around, forces, .. } = &*self.triangles;
        let mut sums = [[0.0; FORCE]; LANES];
        let (from, to) = (begins[block] as usize, begins[block + 1] as usize);
        for lanes in around[from..to].chunks_exact(LANES) {
            for (sum, &face) in sums.iter_mut().zip(lanes) {
                let at = face as usize * FORCE;
                let force = &forces[at..at + FORCE];
                for l in 0..FORCE {
                    sum[l] += force[l];
                }
            }
        }
        let w = Block::load(self.inverse_mass, slot);
        let mut a = Block3::load(self.a, slot);
        for (i, [x, y, z, _]) in sums.into_iter().enumerate() {
            a.set(i, a.at(i) + Vec3::new(x, y, z) * w.0[i]);
        }
        a.store(self.a, slot);
    }
}

/// Three neighbouring numbers of each triangle, as vectors.
#[inline(always)]
fn vectors(tile: &[Block; LANES], from: usize) -> Block3 {
    let mut out = Block3::ZERO;
    for (i, triangle) in tile.iter().enumerate() {
        out.set(i, Vec3::new(triangle.0[from], triangle.0[from + 1], triangle.0[from + 2]));
    }
    out
}
