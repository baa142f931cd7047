//! The panel: what a cloth is made of, how it is solved and what blows on it, changed while it moves.
//!
//! `cargo run --example panel --features demo,panel`
//!
//! One more plugin in any game shows it:
//!
//! ```
//! app.add_plugins((DefaultPlugins, ClothPlugin::default(), ClothPanelPlugin));
//! ```

mod common;

use bevy::prelude::*;
use bevy_drape::ClothPanelPlugin;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// Cloths to be tuned by the panel.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.1, 1.55, 5.7), at: Vec3::new(0.05, 0.85, 0.0) };
    window::run_with(Scene::Tuned, &Cli::parse().options, "bevy_drape: panel", view, |app| {
        app.add_plugins(ClothPanelPlugin);
    })
}
