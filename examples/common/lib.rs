//! What the examples share: a window with camera and light, paint, options, the run without a window, and the
//! check that each ends in.
//!
//! What an example shows is in its own file alone. That knows nothing of windows or graphics cards, so that
//! `headless`, `soak` and `tests/examples` run the same scene.

// A program may print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

pub mod bodies;
mod body;
mod bunny;
#[cfg(all(feature = "demo", feature = "gizmos"))]
mod caption;
pub mod character;
pub mod check;
mod example;
pub mod figure;
mod files;
#[cfg(all(feature = "demo", feature = "gizmos"))]
mod gizmos;
pub mod headless;
#[cfg(feature = "demo")]
mod light;
mod look;
mod obj;
mod options;
#[cfg(feature = "demo")]
mod paint;
#[cfg(feature = "demo")]
mod picture;
#[cfg(feature = "demo")]
mod probe;
pub mod report;
mod repository;
mod series;
mod shirt;
mod wait;
#[cfg(feature = "demo")]
mod window;

pub use bunny::load_bunny;
pub use example::{Caption, Example, Particles, View};
pub use files::add_gltf;
pub use look::{BRASS, CORAL, INDIGO, IVORY, Look, SAND, TEAL, clay, ground, linen, metal};
pub use options::{Options, seconds};
pub use repository::repository;
pub use series::run_in_series;
pub use shirt::shirt;
pub use wait::Awaited;
