//! A cloth held by two corners swings down; the rings that hold it slide together, and it falls into
//! folds.
//!
//! `cargo run --example curtain --features demo`

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A cloth hangs from two rings that slide together.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(1.0, 1.6, 4.2), at: Vec3::new(0.0, 1.2, 0.0) };
    window::run(Scene::Curtain, &Cli::parse().options, "bevy_drape: curtain", view)
}
