//! Air on any triangles: forces by triangle, then gathered by particle.
//!
//! A triangle's velocity is the mean of its corners', and a third of its force goes to each. Every
//! particle adds up those of its triangles in their order, so that nothing is scattered and the sum
//! is the same on every machine.

use bevy::math::Vec3;

use super::super::isa::Kernel;
use super::super::lanes::{Block, Block3, LANES, Soa};
use super::super::lattice::Layout;
use super::Flow;
use super::shares::{Face, shares};

/// Triangles by the slots of their corners, and which of them are around each particle.
#[derive(Clone, Debug)]
pub(super) struct Triangles {
    layout: Layout,
    /// Slots of the first, second and third corners, padded to whole blocks.
    corners: [Vec<u32>; 3],
    /// For each block of particles, row by row, where its entries in `around` begin; one more at the
    /// end.
    begins: Vec<u32>,
    /// [`LANES`] triangles at a time, one of each particle of a block; `none` where it has no more.
    around: Vec<u32>,
    /// A third of each triangle's force, and a zero behind the last.
    forces: Soa,
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
        let mut corners = [(); 3].map(|()| vec![layout.slot(0, 0) as u32; padded]);
        let mut at_particle = vec![Vec::new(); layout.rows * layout.columns];
        for (i, (face, particles)) in faces.iter().zip(triangles).enumerate() {
            for k in 0..3 {
                corners[k][i] = face.corners[k] as u32;
                at_particle[particles[k] as usize].push(i as u32);
            }
        }
        let (begins, around) = blocks(layout, &at_particle, padded as u32);
        let forces = Soa::zeros(padded + LANES);
        let mut inverse = shares(&faces, particle_area);
        inverse.resize(padded, 0.0);
        (Self { layout, corners, begins, around, forces }, inverse)
    }

    /// The slots of one corner of [`LANES`] triangles.
    #[inline(always)]
    fn slots(&self, corner: usize, face: usize) -> [u32; LANES] {
        let mut out = [0; LANES];
        out.copy_from_slice(&self.corners[corner][face..face + LANES]);
        out
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
    pub triangles: &'a Triangles,
    pub x: &'a Soa,
    pub centres: &'a mut Soa,
}

impl Kernel for FindCentres<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for face in (0..self.triangles.corners[0].len()).step_by(LANES) {
            let corners = Corners::load(self.triangles, face, self.x);
            corners.mean().store(self.centres, face);
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
        let x = Corners::load(self.triangles, face, self.x);
        let d = Corners::load(self.triangles, face, self.d).mean();
        let a = Corners::load(self.triangles, face, self.a).mean();
        let mut force = self.flow.forces(face, x.vector_area(), d, a);
        for i in 0..LANES {
            force.set(i, force.at(i) * (1.0 / 3.0));
        }
        force.store(&mut self.triangles.forces, face);
    }

    #[inline(always)]
    fn gather(&mut self, block: usize, slot: usize) {
        let Triangles { begins, around, forces, .. } = &*self.triangles;
        let mut sum = Block3::ZERO;
        let (from, to) = (begins[block] as usize, begins[block + 1] as usize);
        for lanes in around[from..to].chunks_exact(LANES) {
            for i in 0..LANES {
                sum.set(i, sum.at(i) + forces.get(lanes[i] as usize));
            }
        }
        let w = Block::load(self.inverse_mass, slot);
        let mut a = Block3::load(self.a, slot);
        for i in 0..LANES {
            a.set(i, a.at(i) + sum.at(i) * w.0[i]);
        }
        a.store(self.a, slot);
    }
}

/// Vectors at the three corners of [`LANES`] triangles.
struct Corners([Block3; 3]);

impl Corners {
    #[inline(always)]
    fn load(triangles: &Triangles, face: usize, from: &Soa) -> Self {
        let mut out = [Block3::ZERO; 3];
        for (k, corner) in out.iter_mut().enumerate() {
            let slots = triangles.slots(k, face);
            for i in 0..LANES {
                corner.set(i, from.get(slots[i] as usize));
            }
        }
        Self(out)
    }

    #[inline(always)]
    fn mean(&self) -> Block3 {
        let [a, b, c] = &self.0;
        let mut out = Block3::ZERO;
        for i in 0..LANES {
            out.set(i, (a.at(i) + b.at(i) + c.at(i)) * (1.0 / 3.0));
        }
        out
    }

    #[inline(always)]
    fn vector_area(&self) -> Block3 {
        let [a, b, c] = &self.0;
        let mut out = Block3::ZERO;
        for i in 0..LANES {
            out.set(i, (b.at(i) - a.at(i)).cross(c.at(i) - a.at(i)) * 0.5);
        }
        out
    }
}
