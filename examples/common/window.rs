//! Runs a scene in a window: camera, light, paint; without one it says so and runs headless.

use super::{
    Options,
    check::check,
    headless,
    light::{View, set_up_view},
    paint::paint,
    probe,
    scene::Scene,
};
use bevy::{
    prelude::*,
    render::{
        RenderPlugin,
        view::screenshot::{Screenshot, ScreenshotCaptured, save_to_disk},
    },
    time::TimeUpdateStrategy,
    window::WindowResolution,
};
use bevy_drape::prelude::*;

/// Frames before a picture that are drawn; the others only pass, which is faster without a graphics card.
const DRAWN: u32 = 3;

/// Runs a scene in a window, or without one where there can be none.
pub fn run(scene: Scene, options: &Options, title: &str, view: View) -> AppExit {
    if options.probe {
        return probe::answer();
    }
    if let Err(reason) = probe::ask() {
        println!("No window can be had here: {reason}");
        println!("Running headless instead.");
        let ran = headless::run(scene, options.particles, options.seconds, 1, None);
        return ran.map_or_else(fail, |()| AppExit::Success);
    }
    let window =
        Window { title: title.into(), resolution: WindowResolution::new(1280, 720), ..default() };
    let frames = options.frames.or(options.screenshot.is_some().then_some(80));
    // What is counted in frames must show all from the first.
    let render = RenderPlugin { synchronous_pipeline_compilation: frames.is_some(), ..default() };
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }).set(render),
        ClothPlugin::default(),
    ))
    .insert_resource(view)
    .insert_resource(GlobalAmbientLight { brightness: 350.0, ..default() })
    .add_systems(Startup, set_up_view)
    .add_systems(Update, paint);
    scene.add_to(&mut app, options.particles);
    #[cfg(feature = "gizmos")]
    if options.gizmos {
        app.add_plugins(bevy_drape::ClothGizmosPlugin);
    }
    if let Some(frames) = frames {
        // However long a frame takes, the picture is the same.
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(4));
        let picture = options.screenshot.clone();
        let mut left = frames;
        app.add_systems(
            Last,
            move |time: Res<Time<Virtual>>,
                  mut commands: Commands,
                  mut cameras: Query<&mut Camera>| {
                if time.is_paused() || left == 0 {
                    return;
                }
                left -= 1;
                for mut camera in &mut cameras {
                    camera.is_active = picture.is_none() || left < DRAWN;
                }
                match &picture {
                    _ if left > 0 => {}
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
            },
        );
    }
    app.run()
}

/// The last frame is done.
fn leave(world: &mut World) {
    let exit = check(world).map_or_else(fail, |()| {
        println!("check: finite, inside the box, above the ground");
        AppExit::Success
    });
    world.write_message(exit);
}

fn fail(reason: String) -> AppExit {
    eprintln!("check failed: {reason}");
    AppExit::error()
}
