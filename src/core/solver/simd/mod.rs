//! What kernels compute with: blocks of particles, instruction sets, bands that threads share.

pub(crate) mod gather;
pub(crate) mod isa;
pub(crate) mod lanes;
pub(crate) mod parallel;
pub(crate) mod transpose;
