//! Hard cases: what breaks a cloth elsewhere. Each is a test of its own name, for ten seconds of a
//! lattice and of a mesh, at the automatic setting and at the stiffest that is accepted.
//!
//! Truths: all is finite in every frame; nothing is beyond what its pins let it reach, or its fall;
//! strain is back under twice its limit within a stated number of frames, and stays there; what another
//! cloth goes through changes no bit of the rest. `-- --nocapture` prints what each came to.

mod app;
mod common;
mod fast_colliders;
mod frames;
mod masses;
mod pulled;
mod starts;
mod teleports;
