//! Cloths and the colliders of Avian.

mod bakes;
mod errors;
mod falls;
mod lifecycle;
mod order;
mod poses;
mod shapes;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
