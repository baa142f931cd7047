//! A curtain on a rail: thirteen rings, each an anchor for a thread of its top hem, slide together, and it falls
//! into folds. Drag a ring along the rail to draw it, or pull at the cloth.
//!
//! `cargo run --example curtain --features demo`
//!
//! ```
//! pins = pins.and(ClothPins::vertices([thread]).anchored_to(ring));
//! ```
//!
//! The rail is in `common/curtain.rs`, what the mouse does in `common/rings.rs`.

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, rings::draw_by_mouse, scene::Scene, window};

/// A curtain on a rail, that the mouse draws.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(0.6, 1.5, 4.2), at: Vec3::new(-0.15, 1.2, 0.0) };
    window::run_with(Scene::Curtain, &Cli::parse().options, "bevy_drape: curtain", view, |app| {
        app.add_observer(draw_by_mouse);
    })
}
