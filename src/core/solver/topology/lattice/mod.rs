//! The rest shape of a rectangular sheet: the immutable part of a cloth, shared by equal cloths.

mod error;
mod grid;
mod weights;

use bevy_math::Vec3;

pub use crate::solver::topology::lattice::error::LatticeError;

use crate::solver::settings::MassLumping;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Array;
use crate::solver::topology::lattice::grid::{Grid, areas, crowd, shear, structural};

/// One family of springs between neighbours, an entry a spring, stored at the slot of its first end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Family {
    /// Rest length \[m\]; 0 where there is no spring.
    pub rest: Array,
    /// Shape factor: the spring's constant is this times the material's stiffness. It is the width
    /// of cloth that the spring stands for over its length, 0 where there is no spring.
    pub shape: Array,
    /// 1 / `shape`; infinite where there is no spring, so that its correction is zero.
    pub compliance: Array,
}

impl Family {
    fn empty(len: usize) -> Self {
        let mut compliance = Array::zeros(len);
        compliance.fill(f32::INFINITY);
        Self { rest: Array::zeros(len), shape: Array::zeros(len), compliance }
    }

    pub(crate) fn set(&mut self, at: usize, rest: f32, shape: f32) {
        self.rest[at] = rest;
        self.shape[at] = shape;
        self.compliance[at] = 1.0 / shape;
    }

    pub(crate) fn transposed(&self, from: Layout) -> Self {
        let mut out = Self::empty(from.transposed().len());
        for r in 0..from.rows {
            for c in 0..from.columns {
                let (a, b) = (from.slot(r, c), from.transposed().slot(c, r));
                out.rest[b] = self.rest[a];
                out.shape[b] = self.shape[a];
                out.compliance[b] = self.compliance[a];
            }
        }
        out
    }
}

/// The rest shape of a rectangular sheet of `rows` x `columns` particles. Warp threads run along the
/// columns (from row to row), weft threads along the rows.
///
/// Cells need not be square, and the sheet need not be flat: every spring keeps its own rest length.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    pub(crate) layout: Layout,
    pub(crate) lumping: MassLumping,
    /// Rest positions \[m\], row by row, without padding.
    pub(crate) rest_positions: Vec<Vec3>,
    /// Springs to the next row.
    pub(crate) warp: Family,
    /// Springs to the next column.
    pub(crate) weft: Family,
    /// The same, in the transposed layout.
    pub(crate) weft_transposed: Family,
    /// Shear springs from (r, c) to (r + 1, c + 1); `shape` and `compliance` serve both diagonals.
    pub(crate) diagonal: Family,
    /// Rest lengths \[m\] of the shear springs from (r, c + 1) to (r + 1, c), at the slot of (r, c).
    pub(crate) antidiagonal_rest: Array,
    /// How much more the shear springs at a particle pull together than those of square cells do.
    pub(crate) crowd: f32,
    /// Area of cloth that a particle stands for \[m2\].
    pub(crate) area: Vec<f32>,
    /// Area of cloth that all particles stand for \[m2\].
    pub(crate) total_area: f32,
    /// Area of cloth that a particle weighs as much as \[m2\].
    pub(crate) mass_area: Vec<f32>,
    /// Whether all cells are the same rectangle of a flat sheet.
    pub(crate) uniform: bool,
    /// Whether rest distances through space are distances along the cloth (flat and convex).
    pub(crate) flat: bool,
}

impl Lattice {
    /// Particles a lattice may have at most.
    pub const MAX_PARTICLES: usize = 1 << 24;

    /// A lattice at rest in the given positions \[m\], row by row.
    ///
    /// # Errors
    /// [`LatticeError`] where the positions make no lattice.
    pub fn new(
        rows: usize,
        columns: usize,
        positions: &[Vec3],
        lumping: MassLumping,
    ) -> Result<Self, LatticeError> {
        check_count(rows, columns)?;
        if positions.len() != rows * columns {
            return Err(LatticeError::WrongLength { rows, columns, positions: positions.len() });
        }
        let too_far = |p: &Vec3| !(p.is_finite() && p.abs().max_element() <= 1e6);
        if let Some(particle) = positions.iter().position(too_far) {
            return Err(LatticeError::NonFinite { particle });
        }
        let layout = Layout::new(rows, columns);
        let grid = Grid { rows, columns, positions };
        let (warp, weft) = structural(layout, &grid, lumping)?;
        let (diagonal, antidiagonal_rest) = shear(layout, &grid);
        let uniform = grid.is_uniform();
        let area = areas(layout, &grid, lumping);
        let total_area = layout.slots().map(|slot| area[slot]).sum();
        Ok(Self {
            layout,
            lumping,
            rest_positions: positions.to_vec(),
            weft_transposed: weft.transposed(layout),
            warp,
            weft,
            diagonal,
            antidiagonal_rest,
            crowd: crowd(&grid),
            mass_area: area.clone(),
            area,
            total_area,
            uniform,
            flat: uniform,
        })
    }

    /// A flat sheet in the xz plane, centred at the origin: columns along x, rows along z.
    ///
    /// # Errors
    /// [`LatticeError`] where the size is not positive and finite, or there are too few particles.
    pub fn sheet(
        size: bevy_math::Vec2,
        rows: usize,
        columns: usize,
        lumping: MassLumping,
    ) -> Result<Self, LatticeError> {
        check_count(rows, columns)?;
        if !size.is_finite() || size.min_element() <= 0.0 {
            return Err(LatticeError::BadSize(size));
        }
        // In halves of a cell from the middle, so that both sides are mirror images to the bit.
        let along = |i: usize, n: usize, length: f32| {
            0.5 * length * ((2 * i) as f32 - (n - 1) as f32) / (n - 1) as f32
        };
        let positions: Vec<_> = (0..rows)
            .flat_map(|r| (0..columns).map(move |c| (r, c)))
            .map(|(r, c)| Vec3::new(along(c, columns, size.x), 0.0, along(r, rows, size.y)))
            .collect();
        Self::new(rows, columns, &positions, lumping)
    }

    /// Whether a sheet of this size could be made.
    ///
    /// # Errors
    /// As [`Lattice::sheet`].
    pub fn check_sheet(
        size: bevy_math::Vec2,
        rows: usize,
        columns: usize,
    ) -> Result<(), LatticeError> {
        check_count(rows, columns)?;
        Self::sheet(size, 2, 2, MassLumping::Lumped).map(|_| ())
    }

    /// Rows of particles.
    pub fn rows(&self) -> usize {
        self.layout.rows
    }

    /// Columns of particles.
    pub fn columns(&self) -> usize {
        self.layout.columns
    }

    /// Particles of the sheet.
    pub fn particle_count(&self) -> usize {
        self.layout.rows * self.layout.columns
    }

    /// Structural and shear springs of the sheet.
    pub fn spring_count(&self) -> usize {
        let (r, c) = (self.layout.rows, self.layout.columns);
        r * (c - 1) + (r - 1) * c + 2 * (r - 1) * (c - 1)
    }

    /// The structural springs: both particles, row by row, and the rest length \[m\].
    pub fn structural_springs(&self) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
        let columns = self.layout.columns;
        self.layout.slots().enumerate().flat_map(move |(particle, slot)| {
            [(1, self.weft.rest[slot]), (columns, self.warp.rest[slot])]
                .into_iter()
                .filter(|&(_, rest)| rest > 0.0)
                .map(move |(hop, rest)| (particle, particle + hop, rest))
        })
    }

    /// The slot of a particle in the layout with rows and columns exchanged.
    pub(crate) fn transposed_slot(&self, slot: usize) -> usize {
        let from_first = slot - self.layout.slot(0, 0);
        let (row, column) = (from_first / self.layout.stride, from_first % self.layout.stride);
        self.layout.transposed().slot(column, row)
    }

    /// Rest positions \[m\], row by row.
    pub fn rest_positions(&self) -> &[Vec3] {
        &self.rest_positions
    }

    /// Area of the sheet at rest \[m2\].
    pub fn total_area(&self) -> f32 {
        self.total_area
    }
}

fn check_count(rows: usize, columns: usize) -> Result<(), LatticeError> {
    let limit = Lattice::MAX_PARTICLES;
    if rows < 2 || columns < 2 {
        Err(LatticeError::TooSmall { rows, columns })
    } else if rows.checked_mul(columns).is_none_or(|count| count > limit) {
        Err(LatticeError::TooLarge { rows, columns, limit })
    } else {
        Ok(())
    }
}
