//! What looks at cloths and pulls at them: gizmos, panel, mouse. Headless: what would be drawn is counted
//! and looked at, clicks are rays.
//!
//! Truths: closed forms (a plane's normal, circles around a sphere's middle, an anchor's place), counts, and
//! that what is off draws nothing.

mod gizmos;
mod panel;
mod picking;
mod rings;
// Each test crate uses a part of it.
#[allow(dead_code, unused_imports)]
#[path = "../support/mod.rs"]
mod support;
