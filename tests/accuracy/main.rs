//! The solver held to closed forms and tables at the accuracy that `f32` allows, and an independent `f64`
//! model (`reference`) held to them at theirs. Each module says which.
//!
//! Tests print `what: measured, reference, tolerance`; see them with `-- --nocapture`.

mod cantilever;
mod capstan;
mod catenary;
mod cloth_order;
mod conservation;
mod contact;
mod energy;
mod limits;
mod mesh_families;
mod mesh_swing;
mod modes;
mod moduli;
mod oscillator;
mod places;
mod poster;
mod provot;
mod reference;
mod scenes;
mod settled;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
mod units;
