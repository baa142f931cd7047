//! Runs an example without a window, a tick an update, and reports.

use crate::{
    Example,
    check::check,
    files::asset_folder,
    obj::write_obj,
    report::{Report, Watch, watch},
    run_in_series,
};
use bevy::{
    app::{TaskPoolOptions, TaskPoolPlugin},
    mesh::MeshPlugin,
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_drape::{ClothSleepThreshold, prelude::*};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    fs,
    path::Path,
    thread,
    time::{Duration, Instant},
};

/// How long a bake may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// An app with an example's scene and without a window, which runs a tick an update.
pub fn app(example: Example, particles: u32, threads: usize) -> App {
    let mut app = App::new();
    let pools = TaskPoolOptions::with_num_threads(threads);
    // Where large cloths are shared out. An app before this one has set it up, perhaps.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    app.add_plugins((
        MinimalPlugins.set(TaskPoolPlugin { task_pool_options: pools }),
        asset_folder(),
        MeshPlugin,
        TransformPlugin,
        ClothPlugin::default(),
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    if threads == 1 {
        run_in_series(&mut app);
    }
    // Every tick is to be measured.
    app.add_observer(|added: On<Add, Cloth>, mut commands: Commands| {
        commands.entity(added.entity).insert(ClothSleepThreshold::NEVER);
    });
    example.add_to(&mut app, particles);
    watch(&mut app);
    app.finish();
    app.cleanup();
    app
}

/// Simulates for some seconds, with a progress bar.
///
/// # Errors
/// When time does not start.
pub fn simulate(app: &mut App, seconds: f32) -> Result<Report, String> {
    let timestep = app.world().resource::<Time<Fixed>>().timestep().as_secs_f32();
    let wanted = (seconds / timestep).round() as usize;
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} ticks, {eta} left");
    let bar = ProgressBar::new(wanted as u64)
        .with_message("simulating")
        .with_style(style.map_err(|error| error.to_string())?);
    let started = Instant::now();
    loop {
        let done = app.world().resource::<Watch>().milliseconds.len();
        bar.set_position(done as u64);
        if done >= wanted {
            break;
        }
        if done == 0 && started.elapsed() > PATIENCE {
            return Err("time has not started: a bake does not end, or a file does not come".into());
        }
        app.update();
        if app.world().resource::<Time<Virtual>>().is_paused() {
            thread::sleep(Duration::from_millis(1));
        }
    }
    bar.finish_and_clear();
    Ok(Report::new(app.world_mut()))
}

/// Runs an example, prints the report, writes the meshes into a folder if one is given, and checks.
///
/// # Errors
/// What is wrong, in words.
pub fn run(
    example: Example,
    particles: u32,
    seconds: f32,
    threads: usize,
    folder: Option<&Path>,
) -> Result<(), String> {
    let mut app = app(example, particles, threads);
    let report = simulate(&mut app, seconds)?;
    println!("{report}");
    if let Some(folder) = folder {
        write_meshes(app.world_mut(), folder)?;
    }
    check(app.world_mut())?;
    println!("check: finite, inside the box, above the ground");
    Ok(())
}

fn write_meshes(world: &mut World, folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut drawn = world.query_filtered::<(&Mesh3d, &GlobalTransform), With<Cloth>>();
    let meshes = world.resource::<Assets<Mesh>>();
    for (number, (handle, place)) in drawn.iter(world).enumerate() {
        let mesh = meshes.get(handle).ok_or("a cloth's mesh is not there")?;
        let path = folder.join(format!("cloth_{number}.obj"));
        write_obj(&path, mesh, place).map_err(|error| format!("{}: {error}", path.display()))?;
        println!("wrote {}", path.display());
    }
    Ok(())
}
