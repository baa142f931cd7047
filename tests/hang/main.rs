//! Cloth hung by Weil's model, held to closed forms (the catenary, elastic and not, as a curve and as a
//! chain), to the rest lengths of the cloth, and to what little it moves once it is let go.
//!
//! Tests print `what: measured, reference, tolerance`; see them with `-- --nocapture`.

mod catenary;
mod refusals;
mod relax;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
mod surface;
