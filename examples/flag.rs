//! A flag held at its mast streams and flutters in a gusty wind.
//!
//! `cargo run --example flag --features demo`

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A flag flutters in a gusty wind.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.6, 1.45, 4.0), at: Vec3::new(0.15, 1.3, 0.0) };
    window::run(Scene::Flag, &Cli::parse().options, "bevy_drape: flag", view)
}
