//! A curtain on a rail: thirteen rings, each an anchor for a thread of its top hem, slide together, and it falls
//! into folds. Drag a ring along the rail to draw it, or pull at the cloth.
//!
//! `cargo run --example curtain --features demo`
//!
//! ```
//! pins = pins.and(ClothPins::vertices([thread]).anchored_to(ring));
//! ```

mod common;

use bevy::prelude::*;
use clap::Parser;
use common::curtain::{RANGE, Rail, Ring};
use common::{Options, light::View, scene::Scene, window};

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
        app.add_observer(draw);
    })
}

/// A ring that is dragged takes the others along.
fn draw(
    drag: On<Pointer<Drag>>,
    rings: Query<(&Ring, &GlobalTransform)>,
    camera: Single<(&Camera, &GlobalTransform)>,
    mut rail: Single<&mut Rail>,
) {
    let (Ok((ring, place)), (camera, eye)) = (rings.get(drag.entity), *camera) else { return };
    // As wide as the view is at the ring, for as many pixels.
    let across = camera.world_to_viewport(eye, place.translation() + Vec3::X);
    let here = camera.world_to_viewport(eye, place.translation());
    if let (Ok(across), Ok(here)) = (across, here) {
        let way = drag.delta.x / (across.x - here.x).max(1.0) / Rail::WIDTH;
        rail.wanted = (rail.wanted + way / ring.0.max(0.2)).clamp(RANGE.0, RANGE.1);
    }
}
