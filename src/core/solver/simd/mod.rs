//! What kernels compute with: blocks of particles, instruction sets, bands that threads share.

pub(crate) mod block;
pub(crate) mod gather;
pub(crate) mod isa;
pub(crate) mod layout;
pub(crate) mod parallel;
pub(crate) mod slots;
pub(crate) mod soa;
pub(crate) mod transpose;
