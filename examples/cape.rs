//! A cape on the shoulders of a figure that walks in a circle: its collar is pinned to a joint, and each
//! bone is a collider. The cape is a mesh without rows and columns.
//!
//! `cargo run --example cape --features demo`

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A cape on the shoulders of a figure that walks.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.0, 1.4, 4.1), at: Vec3::new(0.0, 0.88, 0.0) };
    window::run(Scene::Cape, &Cli::parse().options, "bevy_drape: cape", view)
}
