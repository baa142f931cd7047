//! Runs a scene in a window: camera, light, paint; without one it says so and runs headless.

use super::{
    Options, headless,
    light::{View, set_up_view},
    paint::paint,
    picture::{fail, leave_after},
    probe,
    scene::Scene,
};
use bevy::{prelude::*, render::RenderPlugin, window::WindowResolution};
use bevy_drape::{ClothPickingPlugin, prelude::*};

/// Runs a scene in a window, or without one where there can be none.
pub fn run(scene: Scene, options: &Options, title: &str, view: View) -> AppExit {
    run_with(scene, options, title, view, |_| {})
}

/// The same, with more in the app that has a window.
pub fn run_with(
    scene: Scene,
    options: &Options,
    title: &str,
    view: View,
    add: impl FnOnce(&mut App),
) -> AppExit {
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
        // The mouse pulls at every cloth.
        ClothPickingPlugin,
    ))
    .insert_resource(view)
    .insert_resource(GlobalAmbientLight { brightness: 350.0, ..default() })
    .add_systems(Startup, set_up_view)
    .add_systems(Update, paint);
    scene.add_to(&mut app, options.particles);
    #[cfg(feature = "gizmos")]
    if let Some(lines) = &options.gizmos {
        super::gizmos::add_gizmos(&mut app, lines);
    }
    add(&mut app);
    if let Some(frames) = frames {
        leave_after(&mut app, frames, options.screenshot.clone());
    }
    app.run()
}
