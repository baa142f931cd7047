//! A cloth comes down on a table, and after some seconds is pulled away by its hem.
//!
//! `cargo run --example tablecloth --features demo`
//!
//! What pulls is an anchor: pins that are added to a running cloth take hold of it where it is by then.
//!
//! ```
//! *pins = ClothPins::from(PinSelection::LastRow).anchored_to(hand);
//! ```

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::{Options, light::View, scene::Scene, window};

/// A cloth comes down on a table, and is pulled away.
///
/// Where there is no display or no graphics adapter it says so and runs headless.
#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    options: Options,
}

fn main() -> AppExit {
    let view = View { from: Vec3::new(1.75, 1.55, 2.75), at: Vec3::new(0.05, 0.42, 0.2) };
    window::run(Scene::Tablecloth, &Cli::parse().options, "bevy_drape: tablecloth", view)
}
