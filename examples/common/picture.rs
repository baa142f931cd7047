//! Leaves after some frames, with a check and a picture of the last one, or pictures of all.

use crate::{check::check, example::fail};
use bevy::{
    prelude::*,
    render::view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
    time::TimeUpdateStrategy,
};
use std::path::PathBuf;

/// Ticks that a frame takes, however long it is: the picture is always the same. A film's frames take fewer.
const TICKS: u32 = 4;
const FILM_TICKS: u32 = 2;

/// Frames that are drawn before a picture. The others only pass: without a graphics card, drawing takes
/// most of the time.
const DRAWN: u32 = 3;

/// In a picture's name, where the number of its frame goes.
const NUMBER: char = '#';

/// The frames to come, and where the picture goes.
#[derive(Resource)]
struct Frames {
    left: u32,
    picture: Option<PathBuf>,
}

impl Frames {
    /// Whether there is a picture of each.
    fn are_all_kept(&self) -> bool {
        let name = self.picture.as_ref().and_then(|path| path.to_str());
        name.is_some_and(|name| name.contains(NUMBER))
    }

    /// The file for the frame that is drawn now; none where none is to be kept.
    fn file(&self) -> Option<PathBuf> {
        let path = self.picture.as_ref()?;
        if self.are_all_kept() {
            // Counted down, so that none has to know how many there are.
            let number = format!("{:05}", 99_999 - self.left);
            return Some(path.to_str()?.replace(NUMBER, &number).into());
        }
        (self.left == 0).then(|| path.clone())
    }
}

/// Lets an app leave after so many frames.
pub(crate) fn leave_after(app: &mut App, frames: u32, picture: Option<PathBuf>) {
    let frames = Frames { left: frames, picture };
    let ticks = if frames.are_all_kept() { FILM_TICKS } else { TICKS };
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(ticks))
        .insert_resource(frames)
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
    let always = frames.picture.is_none() || frames.are_all_kept();
    for mut camera in &mut cameras {
        camera.is_active = always || frames.left < DRAWN;
    }
    let is_last = frames.left == 0;
    let Some(file) = frames.file() else {
        if is_last {
            commands.queue(leave);
        }
        return;
    };
    let mut picture = commands.spawn(Screenshot::primary_window());
    picture.observe(save_to_disk(file));
    if is_last {
        picture.observe(|_: On<ScreenshotCaptured>, mut commands: Commands| commands.queue(leave));
    }
}

/// The last frame is done.
fn leave(world: &mut World) {
    let exit = check(world).map_or_else(
        |reason| fail(&reason),
        |()| {
            println!("check: finite, inside the box, above the ground");
            AppExit::Success
        },
    );
    world.write_message(exit);
}
