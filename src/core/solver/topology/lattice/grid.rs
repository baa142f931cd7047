//! Springs and areas of a lattice, from rest positions by row and column.

use bevy_math::Vec3;

use crate::solver::settings::MassLumping;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Array;
use crate::solver::topology::lattice::Family;
use crate::solver::topology::lattice::error::LatticeError;

/// Rest positions by row and column.
pub(crate) struct Grid<'a> {
    pub rows: usize,
    pub columns: usize,
    pub positions: &'a [Vec3],
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
    pub(crate) fn is_uniform(&self) -> bool {
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

pub(crate) fn structural(
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
pub(crate) fn shear(layout: Layout, grid: &Grid) -> (Family, Array) {
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
pub(crate) fn crowd(grid: &Grid) -> f32 {
    let cells = (0..grid.rows - 1).flat_map(|r| (0..grid.columns - 1).map(move |c| (r, c)));
    let cosine = |(r, c): (usize, usize)| {
        let first = (grid.at(r + 1, c + 1) - grid.at(r, c)).normalize_or_zero();
        first.dot((grid.at(r + 1, c) - grid.at(r, c + 1)).normalize_or_zero()).abs()
    };
    1.0 + cells.map(cosine).fold(0.0, f32::max)
}

pub(crate) fn areas(layout: Layout, grid: &Grid, lumping: MassLumping) -> Vec<f32> {
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
