//! The rest shape of a rectangular sheet: the immutable part of a cloth, shared by equal cloths.

use crate::solver::settings::MassLumping;
use crate::solver::simd::layout::Layout;
use bevy_math::Vec3;

use crate::solver::simd::soa::Array;

/// Why a set of rest positions is no lattice.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LatticeError {
    /// Fewer than two rows or columns.
    #[error("a lattice needs at least 2 x 2 particles, got {rows} rows x {columns} columns")]
    TooSmall {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
    },
    /// More particles than the indices of a mesh can count.
    #[error("{rows} rows x {columns} columns are more than {limit} particles")]
    TooLarge {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
        /// The largest number of particles.
        limit: usize,
    },
    /// The number of positions is not rows x columns.
    #[error("{rows} rows x {columns} columns need {} positions, got {positions}", rows * columns)]
    WrongLength {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
        /// Positions given.
        positions: usize,
    },
    /// A rest position is NaN, infinite or beyond 1e6 m.
    #[error("the rest position of particle {particle} is not finite, or beyond 1e6 m")]
    NonFinite {
        /// The particle, row by row.
        particle: usize,
    },
    /// Two neighbours along a thread coincide.
    #[error("particles {first} and {second} are neighbours but lie at the same place")]
    Coincident {
        /// One particle, row by row.
        first: usize,
        /// Its neighbour.
        second: usize,
    },
    /// Factors of mass or stiffness are not as many as the particles.
    #[error("there are {got} factors for {expected} particles")]
    WrongFactorCount {
        /// Particles.
        expected: usize,
        /// Factors given.
        got: usize,
    },
    /// A factor of mass or stiffness is not positive and finite.
    #[error("the factor of particle {particle} is {value}, but must be positive and finite")]
    BadFactor {
        /// The particle, row by row.
        particle: usize,
        /// Its factor.
        value: f32,
    },
}

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
        self.layout.slots().map(|i| self.area[i]).sum()
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

/// Rest positions by row and column.
struct Grid<'a> {
    rows: usize,
    columns: usize,
    positions: &'a [Vec3],
}

impl Grid<'_> {
    fn at(&self, row: usize, column: usize) -> Vec3 {
        self.positions[row * self.columns + column]
    }

    /// Length of the warp spring from (row, column) to the next row; 0 outside the sheet.
    fn warp_length(&self, row: Option<usize>, column: usize) -> f32 {
        match row {
            Some(r) if r + 1 < self.rows => self.at(r, column).distance(self.at(r + 1, column)),
            _ => 0.0,
        }
    }

    /// Length of the weft spring from (row, column) to the next column; 0 outside the sheet.
    fn weft_length(&self, row: usize, column: Option<usize>) -> f32 {
        match column {
            Some(c) if c + 1 < self.columns => self.at(row, c).distance(self.at(row, c + 1)),
            _ => 0.0,
        }
    }

    /// Width of cloth across a warp thread at a particle: half of each neighbouring cell.
    fn width_across_warp(&self, row: usize, column: usize, lumping: MassLumping) -> f32 {
        let left = self.weft_length(row, column.checked_sub(1));
        let right = self.weft_length(row, Some(column));
        share(left, right, lumping)
    }

    /// Width of cloth across a weft thread at a particle.
    fn width_across_weft(&self, row: usize, column: usize, lumping: MassLumping) -> f32 {
        let above = self.warp_length(row.checked_sub(1), column);
        let below = self.warp_length(Some(row), column);
        share(above, below, lumping)
    }

    /// Whether all cells are one rectangle of one plane, within rounding.
    fn is_uniform(&self) -> bool {
        let origin = self.at(0, 0);
        let column = (self.at(0, self.columns - 1) - origin) / (self.columns - 1) as f32;
        let row = (self.at(self.rows - 1, 0) - origin) / (self.rows - 1) as f32;
        let tolerance = 1e-4 * column.length().min(row.length());
        let square_corner = column.dot(row).abs() <= 1e-4 * column.length() * row.length();
        square_corner
            && (0..self.rows).all(|r| {
                (0..self.columns).all(|c| {
                    let expected = origin + column * c as f32 + row * r as f32;
                    self.at(r, c).distance(expected) <= tolerance
                })
            })
    }
}

/// Half of the cells on both sides; a whole cell on the border where masses are equal.
fn share(before: f32, after: f32, lumping: MassLumping) -> f32 {
    let on_border = before == 0.0 || after == 0.0;
    if on_border && lumping == MassLumping::Equal { before + after } else { 0.5 * (before + after) }
}

fn structural(
    layout: Layout,
    grid: &Grid,
    lumping: MassLumping,
) -> Result<(Family, Family), LatticeError> {
    let mut warp = Family::empty(layout.len());
    let mut weft = Family::empty(layout.len());
    let checked = |length: f32, (r, c): (usize, usize), (r2, c2): (usize, usize)| {
        if length > f32::MIN_POSITIVE {
            Ok(length)
        } else {
            Err(LatticeError::Coincident {
                first: r * grid.columns + c,
                second: r2 * grid.columns + c2,
            })
        }
    };
    for r in 0..grid.rows {
        for c in 0..grid.columns {
            if r + 1 < grid.rows {
                let rest = checked(grid.warp_length(Some(r), c), (r, c), (r + 1, c))?;
                let width = 0.5
                    * (grid.width_across_warp(r, c, lumping)
                        + grid.width_across_warp(r + 1, c, lumping));
                warp.set(layout.slot(r, c), rest, width / rest);
            }
            if c + 1 < grid.columns {
                let rest = checked(grid.weft_length(r, Some(c)), (r, c), (r, c + 1))?;
                let width = 0.5
                    * (grid.width_across_weft(r, c, lumping)
                        + grid.width_across_weft(r, c + 1, lumping));
                weft.set(layout.slot(r, c), rest, width / rest);
            }
        }
    }
    Ok((warp, weft))
}

/// Both diagonals of every cell. A cell of sides a, b and diagonal l under the shear angle g stores
/// `k g^2 a^2 b^2 / l^2` in its two springs and `G g^2 a b / 2` in the cloth: `k = G l^2 / (2 a b)`,
/// which is G in a square cell.
fn shear(layout: Layout, grid: &Grid) -> (Family, Array) {
    let mut diagonal = Family::empty(layout.len());
    let mut antidiagonal_rest = Array::zeros(layout.len());
    for r in 0..grid.rows - 1 {
        for c in 0..grid.columns - 1 {
            let first = grid.at(r, c).distance(grid.at(r + 1, c + 1));
            let second = grid.at(r, c + 1).distance(grid.at(r + 1, c));
            let a = 0.5 * (grid.weft_length(r, Some(c)) + grid.weft_length(r + 1, Some(c)));
            let b = 0.5 * (grid.warp_length(Some(r), c) + grid.warp_length(Some(r), c + 1));
            let slot = layout.slot(r, c);
            diagonal.set(slot, first, first * second / (2.0 * a * b));
            antidiagonal_rest[slot] = second;
        }
    }
    (diagonal, antidiagonal_rest)
}

/// Diagonals at an angle g pull together up to `1 + |cos g|` times as strongly as those of a square.
fn crowd(grid: &Grid) -> f32 {
    let cells = (0..grid.rows - 1).flat_map(|r| (0..grid.columns - 1).map(move |c| (r, c)));
    let cosine = |(r, c): (usize, usize)| {
        let first = (grid.at(r + 1, c + 1) - grid.at(r, c)).normalize_or_zero();
        first.dot((grid.at(r + 1, c) - grid.at(r, c + 1)).normalize_or_zero()).abs()
    };
    1.0 + cells.map(cosine).fold(0.0, f32::max)
}

fn areas(layout: Layout, grid: &Grid, lumping: MassLumping) -> Vec<f32> {
    let mut area = vec![0.0; layout.len()];
    let mut total = 0.0_f64;
    for r in 0..grid.rows {
        for c in 0..grid.columns {
            let share = grid.width_across_warp(r, c, MassLumping::Lumped)
                * grid.width_across_weft(r, c, MassLumping::Lumped);
            area[layout.slot(r, c)] = share;
            total += f64::from(share);
        }
    }
    if lumping == MassLumping::Equal {
        let each = (total / (grid.rows * grid.columns) as f64) as f32;
        for slot in layout.slots() {
            area[slot] = each;
        }
    }
    area
}
