//! The width of blocks.

/// Particles in a block. Rows are padded to a whole number of blocks.
pub const LANES: usize = 16;

/// Whether any lane is not zero.
#[inline(always)]
pub(crate) fn is_any(lanes: &[u32; LANES]) -> bool {
    let mut any = 0;
    for lane in lanes {
        any |= lane;
    }
    any != 0
}
