//! The six fabrics that have names, each over the same post: at the back silk, cotton and wool, in front
//! denim, canvas and rubber.
//!
//! `cargo run --example fabrics --features demo`
//!
//! ```
//! commands.spawn((Cloth::sheet(Vec2::ONE, UVec2::splat(64)), ClothMaterial::SILK));
//! ```

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// Six fabrics, each over the same post.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.0, 1.9, 3.5), at: Vec3::new(0.0, 0.3, 0.12) };
    window::run(Scene::Fabrics, &Cli::parse().options, "bevy_drape: fabrics", view)
}
