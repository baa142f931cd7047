//! Cloths and the colliders of bevy_rapier.

mod falls;
mod lifecycle;
mod shapes;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
