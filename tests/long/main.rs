//! What takes minutes to show: `cargo test --test long`, for which `cargo test` does not wait.
//!
//! Truth: a cloth at rest stays there for ten minutes (the hard case `h17`; the others are in `tests/stability`); what
//! has been dropped on a solid falls asleep; without damping, contact makes no energy in a minute.
//!
//! Tests print `what: measured, at most`; see them with `-- --nocapture`.

mod asleep;
mod energy;
mod rest;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
