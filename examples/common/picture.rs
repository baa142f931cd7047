//! Leaves after some frames, with a check and a picture of the last one.

use super::check::check;
use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
    time::TimeUpdateStrategy,
};
use std::path::PathBuf;

/// Ticks that a frame takes, however long it is: the picture is always the same.
const TICKS: u32 = 4;

/// Frames that are drawn before a picture. The others only pass: without a graphics card, drawing takes
/// most of the time.
const DRAWN: u32 = 3;

/// The frames to come, and where the picture goes.
#[derive(Resource)]
struct Frames {
    left: u32,
    picture: Option<PathBuf>,
}

/// Lets an app leave after so many frames.
pub fn leave_after(app: &mut App, frames: u32, picture: Option<PathBuf>) {
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(TICKS))
        .insert_resource(Frames { left: frames, picture })
        .add_systems(Last, count_down);
}

fn count_down(
    mut frames: ResMut<Frames>,
    mut cameras: Query<&mut Camera>,
    time: Res<Time<Virtual>>,
    mut commands: Commands,
) {
    if time.is_paused() || frames.left == 0 {
        return;
    }
    frames.left -= 1;
    for mut camera in &mut cameras {
        camera.is_active = frames.picture.is_none() || frames.left < DRAWN;
    }
    match &frames.picture {
        _ if frames.left > 0 => {}
        None => commands.queue(leave),
        Some(path) => {
            commands
                .spawn(Screenshot::primary_window())
                .observe(save_to_disk(path.clone()))
                .observe(|_: On<ScreenshotCaptured>, mut commands: Commands| {
                    commands.queue(leave);
                });
        }
    }
}

/// The last frame is done.
fn leave(world: &mut World) {
    let exit = check(world).map_or_else(fail, |()| {
        println!("check: finite, inside the box, above the ground");
        AppExit::Success
    });
    world.write_message(exit);
}

/// Says what is wrong.
pub fn fail(reason: String) -> AppExit {
    eprintln!("check failed: {reason}");
    AppExit::error()
}
