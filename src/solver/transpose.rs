//! Tiles of 16 x 16 particles with rows and columns exchanged.

use super::lanes::{Block, LANES};

/// The columns of a tile as rows.
#[inline(always)]
pub(super) fn transposed(tile: &[Block; LANES]) -> [Block; LANES] {
    let mut out = [Block::ZERO; LANES];
    for (i, line) in tile.iter().enumerate() {
        for (j, &value) in line.0.iter().enumerate() {
            out[j].0[i] = value;
        }
    }
    out
}
