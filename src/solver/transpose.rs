//! Tiles of 16 x 16 particles with rows and columns exchanged.

use super::lanes::{Block, LANES};

/// The columns of a tile as rows.
#[inline(always)]
pub(super) fn transposed(tile: &[Block; LANES]) -> [Block; LANES] {
    let mut out = [Block::ZERO; LANES];
    for i in 0..LANES {
        for j in 0..LANES {
            out[j].0[i] = tile[i].0[j];
        }
    }
    out
}
