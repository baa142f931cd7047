//! A cape on the shoulders of a skinned character that walks in a circle. The cape is a mesh without rows
//! and columns.
//!
//! `cargo run --example cape --features demo`
//!
//! Two things join a cape to a character. Its collar is anchored to a joint, and the joints have
//! colliders, so that it lies on the body:
//!
//! ```
//! commands.entity(upper_arm).insert(SdfCollider::capsule_between(Vec3::ZERO, elbow, 0.045));
//! commands.spawn((
//!     Cloth::of_mesh3d(),
//!     Mesh3d(cape),
//!     ClothPins::vertices(0..32).anchored_to(chest),
//!     // A character that is moved in the fixed schedule is drawn where the last tick took it.
//!     ClothInterpolation::LastTick,
//! ));
//! ```
//!
//! The whole scene is in `common/cape.rs`, the character in `common/figure.rs`, its skin in
//! `common/body.rs`.

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
