//! The data and the machinery that kernels compute with.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `block`, `lanes` | blocks of 16 particles, which the compiler makes vectors of |
//! | `soa`, `slots`, `layout` | arrays by coordinate; access by slot; where particles lie in memory |
//! | `flags` | which blocks are raised, of many that are not |
//! | `gather`, `transpose` | particles of a mesh, gathered by index |
//! | `isa` | one body a kernel, compiled for several instruction sets |
//! | `parallel` | bands of rows that threads share |

pub(crate) mod block;
pub(crate) mod flags;
pub(crate) mod gather;
pub(crate) mod isa;
pub(crate) mod lanes;
pub(crate) mod layout;
pub(crate) mod parallel;
pub(crate) mod slots;
pub(crate) mod soa;
pub(crate) mod transpose;
