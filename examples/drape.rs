//! The main job: one cloth comes down on three spheres, another on a mesh, the Stanford bunny, whose
//! distance field is baked at the start.
//!
//! `cargo run --example drape --features demo`

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A cloth comes down on three spheres, and beside it one on the Stanford bunny.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.0, 1.75, 4.6), at: Vec3::new(0.0, 0.5, 0.0) };
    window::run(Scene::Drape, &Cli::parse().options, "bevy_drape: drape", view)
}
