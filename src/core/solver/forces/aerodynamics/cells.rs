//! Air on a lattice: each cell is one face.
//!
//! The cell's vector area is half the cross product of its diagonals, which is the sum of those of
//! its two triangles whichever diagonal divides it; its velocity is the mean of its corners', and a
//! quarter of its force goes to each. So no diagonal is preferred, and mirrored sheets move alike.

use bevy_math::Vec3;

use crate::solver::forces::aerodynamics::Flow;
use crate::solver::forces::aerodynamics::shares::{Face, shares};
use crate::solver::simd::block::{Block, Block3};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::lattice::Lattice;

/// The cells of a lattice. Row `r`, column `c` is the face `r * width + c`.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    layout: Layout,
    /// Faces of a row, padded to whole blocks.
    width: usize,
    /// Forces of two rows of cells, in turn, with a block of zeros on both sides.
    forces: Soa,
    forces_width: usize,
}

impl Cells {
    /// The cells, and the inverse of the area whose mass takes each one's force \[1/m2\], 0 for what
    /// is no cell.
    pub fn new(lattice: &Lattice) -> (Self, Vec<f32>) {
        let layout = lattice.layout;
        let width = (layout.columns - 1).next_multiple_of(LANES);
        let forces_width = layout.columns.next_multiple_of(LANES) + 2 * LANES;
        let rest = |r: usize, c: usize| lattice.rest_positions[r * layout.columns + c];
        let mut faces = Vec::with_capacity((layout.rows - 1) * (layout.columns - 1));
        for r in 0..layout.rows - 1 {
            for c in 0..layout.columns - 1 {
                let at = [(r, c), (r, c + 1), (r + 1, c), (r + 1, c + 1)];
                faces.push(Face {
                    corners: at.map(|(r, c)| layout.slot(r, c)),
                    area: rest_area(at.map(|(r, c)| rest(r, c))),
                });
            }
        }
        let mut padded = vec![0.0; (layout.rows - 1) * width];
        for (i, share) in shares(&faces, &lattice.area).into_iter().enumerate() {
            let (r, c) = (i / (layout.columns - 1), i % (layout.columns - 1));
            padded[r * width + c] = share;
        }
        (Self { layout, width, forces: Soa::zeros(2 * forces_width), forces_width }, padded)
    }
}

/// Area of a cell that need not be flat: the mean of both ways of dividing it.
fn rest_area([a, b, c, d]: [Vec3; 4]) -> f32 {
    let triangle = |a: Vec3, b: Vec3, c: Vec3| 0.5 * (b - a).cross(c - a).length();
    0.5 * ((triangle(a, b, d) + triangle(a, d, c)) + (triangle(b, a, c) + triangle(b, c, d)))
}

/// Works out where the cells' centres are.
pub(super) struct FindCentres<'a> {
    pub cells: &'a Cells,
    pub x: &'a Soa,
    pub centres: &'a mut Soa,
}

impl Kernel for FindCentres<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let layout = self.cells.layout;
        for row in 0..layout.rows - 1 {
            for column in (0..layout.columns - 1).step_by(LANES) {
                let slot = layout.slot(row, column);
                mean(self.x, slot, layout.stride)
                    .store(self.centres, row * self.cells.width + column);
            }
        }
    }
}

/// Adds what the air does to the cells to the particles' accelerations.
pub(super) struct PushCells<'a> {
    pub cells: &'a mut Cells,
    pub flow: Flow<'a>,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a Soa,
    /// Accelerations by all other forces, then by all forces.
    pub a: &'a mut Soa,
}

impl Kernel for PushCells<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let rows = self.cells.layout.rows;
        // Beside the sheet there is no cell.
        self.clear(1);
        for row in 0..rows {
            if row + 1 < rows {
                self.push(row);
            } else {
                self.clear(row);
            }
            self.gather(row);
        }
    }
}

impl PushCells<'_> {
    #[inline(always)]
    fn clear(&mut self, row: usize) {
        let at = row % 2 * self.cells.forces_width;
        for column in (0..self.cells.forces_width).step_by(LANES) {
            Block3::ZERO.store(&mut self.cells.forces, at + column);
        }
    }

    /// Forces on a row of cells. The accelerations of its particles are still without air: those of
    /// a row are changed when both of its rows of cells are done.
    #[inline(always)]
    fn push(&mut self, row: usize) {
        let Layout { columns, stride, .. } = self.cells.layout;
        for column in (0..columns - 1).step_by(LANES) {
            let slot = self.cells.layout.slot(row, column);
            let face = row * self.cells.width + column;
            let area = vector_area(self.x, slot, stride);
            let d = mean(self.d, slot, stride);
            let a = mean(self.a, slot, stride);
            let force = self.flow.forces(face, area, d, a);
            let at = row % 2 * self.cells.forces_width + LANES + column;
            force.store(&mut self.cells.forces, at);
        }
    }

    /// A quarter of the forces of the four cells around each particle of a row, in an order that
    /// mirrored sheets share.
    #[inline(always)]
    fn gather(&mut self, row: usize) {
        let layout = self.cells.layout;
        let [above, below] = [row + 1, row].map(|r| r % 2 * self.cells.forces_width + LANES);
        let forces = &self.cells.forces;
        for column in (0..layout.columns).step_by(LANES) {
            let slot = layout.slot(row, column);
            let a00 = Block3::load(forces, above + column - 1);
            let a01 = Block3::load(forces, above + column);
            let a10 = Block3::load(forces, below + column - 1);
            let a11 = Block3::load(forces, below + column);
            let w = Block::load(self.inverse_mass, slot);
            let mut a = Block3::load(self.a, slot);
            for i in 0..LANES {
                let sum = (a00.at(i) + a11.at(i)) + (a01.at(i) + a10.at(i));
                a.set(i, a.at(i) + sum * (0.25 * w.0[i]));
            }
            a.store(self.a, slot);
        }
    }
}

/// The mean over the corners of cells, their first corners at `slot` and on.
#[inline(always)]
fn mean(of: &Soa, slot: usize, stride: usize) -> Block3 {
    let a00 = Block3::load(of, slot);
    let a01 = Block3::load(of, slot + 1);
    let a10 = Block3::load(of, slot + stride);
    let a11 = Block3::load(of, slot + stride + 1);
    let mut out = Block3::ZERO;
    for i in 0..LANES {
        out.set(i, ((a00.at(i) + a11.at(i)) + (a01.at(i) + a10.at(i))) * 0.25);
    }
    out
}

#[inline(always)]
fn vector_area(x: &Soa, slot: usize, stride: usize) -> Block3 {
    let a00 = Block3::load(x, slot);
    let a01 = Block3::load(x, slot + 1);
    let a10 = Block3::load(x, slot + stride);
    let a11 = Block3::load(x, slot + stride + 1);
    let mut out = Block3::ZERO;
    for i in 0..LANES {
        out.set(i, (a11.at(i) - a00.at(i)).cross(a10.at(i) - a01.at(i)) * 0.5);
    }
    out
}
