//! How particles lie in memory.

use crate::solver::simd::lanes::LANES;

/// Rows of padding before the first and after the last row, so that a particle's neighbours two
/// rows away are always in memory.
const PAD_ROWS: usize = 2;

/// How particles are laid out in memory: rows of `columns` particles, padded so that rows are whole
/// blocks and every neighbour of a particle is in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub rows: usize,
    pub columns: usize,
    /// Distance between rows in memory.
    pub stride: usize,
    /// The slot of the first particle.
    first: usize,
    /// Slots of memory, padding included.
    len: usize,
}

impl Layout {
    pub fn new(rows: usize, columns: usize) -> Self {
        // A block of padding at least, of which neighbours of a row's blocks are part and the next row is not.
        let stride = columns.next_multiple_of(LANES) + LANES;
        let first = PAD_ROWS * stride;
        let len = (rows.next_multiple_of(LANES) + 2 * PAD_ROWS) * stride + LANES;
        Self { rows, columns, stride, first, len }
    }

    /// Particles in one row, without neighbours in memory; at least one slot after the last of them
    /// is padding.
    pub fn one_row(particles: usize) -> Self {
        let len = (particles + 1).next_multiple_of(LANES);
        Self { rows: 1, columns: particles, stride: len, first: 0, len }
    }

    /// Slots of memory, padding included.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The slot of a particle.
    #[inline(always)]
    pub fn slot(&self, row: usize, column: usize) -> usize {
        // The row after the last one is where blocks end, and padding.
        debug_assert!(
            row <= self.rows && column < self.stride,
            "row {row}, column {column}: {self:?}"
        );
        self.first + row * self.stride + column
    }

    /// The slots of all particles, row by row.
    pub fn slots(&self) -> impl Iterator<Item = usize> + use<> {
        let layout = *self;
        (0..self.rows).flat_map(move |r| (0..layout.columns).map(move |c| layout.slot(r, c)))
    }

    /// Blocks of a row.
    #[inline(always)]
    pub fn blocks_across(&self) -> usize {
        self.columns.div_ceil(LANES)
    }

    /// Blocks from that of a particle in the first row to that of the last one below it, both included.
    #[inline(always)]
    pub fn blocks_down(&self) -> usize {
        (self.rows - 1) * (self.stride / LANES) + 1
    }

    /// The layout with rows and columns exchanged.
    pub fn transposed(&self) -> Self {
        Self::new(self.columns, self.rows)
    }
}
