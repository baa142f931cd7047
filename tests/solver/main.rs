//! The solver, held to closed forms, reference tables and invariants. Each module says which.
//!
//! Tests print `what: measured, reference, tolerance`; see them with `-- --nocapture`.

mod air;
mod automatic;
mod bending;
mod bending_friction;
mod bodies;
mod carry;
mod contact;

mod determinism;
mod fast;
mod fingerprints;
mod free_flight;
mod garments;
mod graph;
mod graph_bending;
mod graph_determinism;
mod graph_refusals;
mod hanging;
mod integrators;
mod inter_collision;
mod levels;
mod limit;
mod loads;
mod momentum;
mod motion;
mod passed_over;
mod pulled;
mod push;
mod refusals;
mod seams;
mod self_collision;
mod shared;
mod shifts;
mod skin;
mod soft;
mod spring;
mod stability;
mod strikes;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
mod survival;
mod symmetry;
mod tethers;
mod weights;
mod wind;
