//! Cloths and the colliders of Avian.
//!
//! Truths: parry's own distances at random points; contact sampled; bit equality between frame rates; counted fields; what is on
//! an entity after each change.

mod bakes;
mod bodies;
mod errors;
mod example;
mod falls;
mod lifecycle;
mod order;
mod poses;
mod shapes;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
