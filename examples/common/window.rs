//! Runs a scene in a window: camera, light, paint; without one it says so and runs headless.

use crate::{
    Example, Options, files::asset_folder, light::set_up_view, paint::paint, picture::leave_after,
    probe,
};
use bevy::{prelude::*, render::RenderPlugin, window::WindowResolution};
use bevy_drape::{ClothPickingPlugin, prelude::*};

/// Runs an example in a window, or without one where there can be none.
pub(crate) fn run(example: Example, options: &Options, add: impl FnOnce(&mut App)) -> AppExit {
    if options.probe {
        return probe::answer();
    }
    if let Err(reason) = probe::ask() {
        println!("No window can be had here: {reason}");
        return example.run_headless(options);
    }
    let window = Window {
        title: format!("bevy_drape: {}", example.name),
        resolution: WindowResolution::new(1280, 720),
        ..default()
    };
    let frames = options.frames.or(options.screenshot.is_some().then_some(80));
    // What is counted in frames must show all from the first.
    let render = RenderPlugin { synchronous_pipeline_compilation: frames.is_some(), ..default() };
    let mut app = App::new();
    app.add_plugins((
        DefaultPlugins
            .set(WindowPlugin { primary_window: Some(window), ..default() })
            .set(render)
            .set(asset_folder()),
        ClothPlugin::default(),
        // The mouse pulls at every cloth.
        ClothPickingPlugin,
    ))
    .insert_resource(example.view)
    .insert_resource(GlobalAmbientLight { brightness: 350.0, ..default() })
    .add_systems(Startup, set_up_view)
    .add_systems(Update, paint);
    example.add_to(&mut app, options.particles);
    #[cfg(feature = "gizmos")]
    {
        crate::caption::show_caption(&mut app);
        if let Some(lines) = &options.gizmos {
            crate::gizmos::add_gizmos(&mut app, lines);
        }
    }
    add(&mut app);
    if let Some(frames) = frames {
        leave_after(&mut app, frames, options.screenshot.clone());
    }
    app.run()
}
