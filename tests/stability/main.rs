//! Hard cases: what no scene asks for on purpose, and every game does by accident. Each is a test of its own
//! name, on a lattice and on a mesh, at the automatic setting and at the stiffest that is accepted, for the
//! seconds in which it moves. Every tick is looked at.
//!
//! Truths: all is finite; nothing is beyond what its pins let it reach, or its fall; strain is back under
//! twice its limit within a stated number of frames, and stays there; what another cloth goes through
//! changes no bit of the rest. `-- --nocapture` prints what each came to.

mod app;
mod asleep;
mod common;
mod extremes;
mod far;
mod fast_colliders;
mod frames;
mod gravity;
mod handled;
mod lying;
mod masses;
mod medial;
mod other;
mod outside;
mod pinned;
mod pool;
mod pulled;
mod rest;
mod squeezed;
mod starts;
mod teleports;
mod thin;
