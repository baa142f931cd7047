//! How particles lie in memory.

use crate::solver::simd::lanes::LANES;

/// Rows of padding before the first and after the last row, so that a particle's neighbours two
/// rows away are always in memory.
const PAD_ROWS: usize = 2;

/// Particles in a page of a mesh. Sixteen of them are the least that a thread takes on.
const PAGE: usize = 256;

/// How particles are laid out in memory. Those of a lattice are in its rows, padded so that rows are whole blocks and
/// every neighbour of a particle is in memory; those of a mesh are one after the other, in rows that are pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub rows: usize,
    pub columns: usize,
    /// Distance between rows in memory.
    pub stride: usize,
    /// Particles in all: the last page of a mesh need not be full.
    particles: usize,
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
        Self { rows, columns, stride, particles: rows * columns, first, len }
    }

    /// Particles one after the other, in pages, without neighbours in memory; at least one slot after the last of them
    /// is padding.
    pub fn paged(particles: usize) -> Self {
        let whole = if particles < PAGE { LANES } else { PAGE };
        let len = (particles + 1).next_multiple_of(whole);
        let stride = if particles < PAGE { len } else { PAGE };
        Self { rows: len / stride, columns: particles.min(PAGE), stride, particles, first: 0, len }
    }

    /// Particles in all.
    pub fn particles(&self) -> usize {
        self.particles
    }

    /// Particles from one of a row on to the row's end; the rest of the row is padding.
    #[inline(always)]
    pub fn inside(&self, row: usize, column: usize) -> usize {
        let before = row * self.columns + column;
        self.particles.saturating_sub(before).min(self.columns - column)
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
        let all = (0..self.rows).flat_map(move |r| (0..layout.columns).map(move |c| (r, c)));
        all.take(self.particles).map(move |(r, c)| layout.slot(r, c))
    }

    /// The slots above, below, before and after a particle's in a lattice; its own where there is none.
    #[inline(always)]
    pub fn around(&self, slot: usize) -> [usize; 4] {
        let (row, column) = ((slot - self.first) / self.stride, (slot - self.first) % self.stride);
        [
            if row > 0 { slot - self.stride } else { slot },
            if row + 1 < self.rows { slot + self.stride } else { slot },
            if column > 0 { slot - 1 } else { slot },
            if column + 1 < self.columns { slot + 1 } else { slot },
        ]
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
