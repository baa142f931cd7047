//! The width of blocks.

/// Particles in a block. Rows are padded to a whole number of blocks.
pub const LANES: usize = 16;
