//! Cloth hung by Weil's model, held to closed forms (the catenary, elastic and not, as a curve and as a
//! chain), to the rest lengths of the cloth, and to what little it moves once it is let go.
//!
//! Tests print `what: measured, reference, tolerance`; see them with `-- --nocapture`.

mod catenary;
#[path = "../solver/common.rs"]
#[allow(dead_code)]
mod common;
mod refusals;
mod relax;
mod surface;
