//! A square cloth held at its corners fills in a steady wind.
//!
//! `cargo run --example sail --features demo`
//!
//! Each corner is a patch of pinned particles, anchored to an entity that moves:
//!
//! ```
//! let patch = ClothPins::within(corner - 0.08, corner + 0.08);
//! pins = pins.and(patch.anchored_to(ring));
//! ```
//!
//! The whole scene is in `common/sail.rs`; how wind is added is told in `flag.rs`.

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A square sail fills in a steady wind.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(2.9, 1.6, 4.1), at: Vec3::new(0.15, 1.2, 0.2) };
    window::run(Scene::Sail, &Cli::parse().options, "bevy_drape: sail", view)
}
