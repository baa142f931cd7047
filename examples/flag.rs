//! A flag held at its mast streams and flutters in a gusty wind.
//!
//! `cargo run --example flag --features demo`
//!
//! Wind takes two things: a resource that says how it blows, and `ClothAir` on each cloth that is to feel
//! it. The rest is a cloth with its first column pinned:
//!
//! ```
//! use bevy::prelude::*;
//! use bevy_drape::prelude::*;
//! use std::f32::consts::PI;
//!
//! fn set_flag(mut commands: Commands) {
//!     // 6 m/s from the mast, with gusts of another 7 m/s as large as the flag.
//!     let gusts = Gusts { strength: 7.0, scale: 1.2, period: 0.5, ..default() };
//!     commands.insert_resource(ClothWind::steady(Vec3::X * 6.0).with_gusts(gusts));
//!     commands.spawn((
//!         Cloth::sheet(Vec2::new(1.5, 1.0), UVec2::new(64, 42)),
//!         ClothPins::from(PinSelection::FirstColumn),
//!         ClothAir::default(),
//!         // A sheet lies flat; now it stands, its first column along the mast.
//!         Transform::from_xyz(0.0, 1.75, 0.0).with_rotation(Quat::from_rotation_x(PI / 2.0)),
//!     ));
//! }
//! ```
//!
//! The whole scene is in `common/flag.rs`, the light and the camera in `common/light.rs`. Wind in places
//! (a fan, a blast) is a `WindZone`; wind for one cloth alone is a `ClothWindOverride`.

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
    let view = View { from: Vec3::new(0.6, 1.45, 4.2), at: Vec3::new(0.15, 1.25, 0.0) };
    window::run(Scene::Flag, &Cli::parse().options, "bevy_drape: flag", view)
}
