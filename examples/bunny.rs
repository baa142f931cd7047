//! The Stanford bunny, baked to a distance field at the start, hops through a curtain.
//!
//! `cargo run --example bunny --features demo`
//!
//! A mesh that cloth is to meet takes one component, and may move at will once it is baked:
//!
//! ```
//! commands.spawn((Mesh3d(bunny), BakeSdf::with_cells(96), Transform::default()));
//! ```
//!
//! The whole scene is in `common/bunny.rs`. `bake.rs` bakes ahead of time, to a file.

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// The Stanford bunny hops through a curtain.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(1.9, 1.6, 4.3), at: Vec3::new(0.05, 0.75, 0.3) };
    window::run(Scene::Bunny, &Cli::parse().options, "bevy_drape: bunny", view)
}
