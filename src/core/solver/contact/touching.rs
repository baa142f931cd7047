//! Particles that touch a body, block by block.

use crate::solver::simd::block::{Block, Block3};

/// The particles of a block that touch a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touching {
    pub slot: usize,
    /// Their masses \[kg\]; zero where a particle does not touch.
    pub masses: Block,
    /// From the body's centre \[m\].
    pub arms: Block3,
    /// The axes along which they press on it, and how far they were pressed \[m\].
    pub n: Block3,
    pub pressed: Block,
    /// How far they go with it along the surface, from 0 to 1.
    pub sticks: Block,
}

impl Touching {
    /// None of any block.
    pub const NONE: Self = Self {
        slot: 0,
        masses: Block::ZERO,
        arms: Block3::ZERO,
        n: Block3::ZERO,
        pressed: Block::ZERO,
        sticks: Block::ZERO,
    };
}
