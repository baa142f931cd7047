//! Cloths and the colliders of Rapier.
//!
//! Truths: parry's own distances at random points; contact sampled; what is on an entity after each change.

mod bodies;
#[cfg(feature = "avian")]
mod both;
mod errors;
mod example;
mod falls;
mod lifecycle;
mod order;
#[cfg(feature = "avian")]
mod pendulum;
mod poses;
mod shapes;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
