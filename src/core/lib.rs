//! The numerics of [bevy_drape](https://docs.rs/bevy_drape): cloth without an ECS, a clock or a window.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`solver`] | masses and springs: forces, Verlet integration, correction, contact |
//! | [`sdf`] | what a cloth collides with: signed distances of primitives and of baked meshes |
//! | [`hang`] | where a cloth hangs: Weil's catenaries, and the relaxation that ends them |
//! | [`surface`] | what is drawn of it: places, normals, tangents |
//!
//! A game takes the plugin, which has the first three of these modules too. This is for a solver of one's own: positions,
//! pins and colliders in, positions out.
//!
//! A crate of its own, so that it can be fully optimised where the rest of a dev build is not:
//!
//! ```toml
//! [profile.dev.package.bevy_drape_core]
//! opt-level = 3
//! ```
//!
//! The feature `serialize` is for serde, `asset` makes a distance field one of Bevy's assets.

// On docs.rs each item says which feature it needs.
#![cfg_attr(docsrs, feature(doc_cfg))]
// A library does not print.
#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod hang;
pub mod sdf;
#[cfg(feature = "serialize")]
#[doc(hidden)]
pub mod serialize;
pub mod solver;
pub mod surface;
