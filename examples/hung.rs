//! Two curtains on rings that are nearer to each other than their corners: one starts hung, at rest, by
//! Weil's geometric model; the other starts flat, and swings down.
//!
//! `cargo run --example hung --features demo`

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A curtain that starts hung, beside one that starts flat.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.0, 1.7, 5.4), at: Vec3::new(0.0, 1.2, 0.0) };
    window::run(Scene::Hung, &Cli::parse().options, "bevy_drape: hung", view)
}
