//! What sleep saves: cloths that lie on the ground, asleep and awake, time and mesh uploads a tick.
//!
//! `cargo run --example rest`

use std::{process::ExitCode, time::Instant};

use bevy::{
    app::{TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    asset::AssetPlugin,
    mesh::MeshPlugin,
    prelude::*,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
};
use bevy_drape::prelude::*;
use clap::Parser;

/// Lays cloths on the ground, waits until all sleep, and measures what they cost then.
///
/// The exit code is 1 if one does not fall asleep within 20 s of the scene, or a mesh is written while
/// all sleep.
#[derive(Parser)]
struct Cli {
    /// Number of cloths.
    #[arg(short, long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    cloths: u32,
    /// Particles a side of each cloth.
    #[arg(short, long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=256))]
    particles: u32,
    /// Ticks to measure; the median is printed.
    #[arg(short, long, default_value_t = 400, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    ticks: u32,
}

/// What a tick came to.
struct Measured {
    /// Median time [us].
    time: f64,
    /// Meshes written, of all ticks.
    written: usize,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let empty = measure(&mut app(0, cli.particles, ClothSleep::default()), cli.ticks).time;
    let mut awake = app(cli.cloths, cli.particles, ClothSleep::NEVER);
    let mut asleep = app(cli.cloths, cli.particles, ClothSleep::default());
    for _ in 0..20 * 64 {
        awake.update();
        asleep.update();
    }
    let world = asleep.world_mut();
    let still = world.query::<&ClothSimulation>().iter(world).filter(|c| !c.is_asleep()).count();
    println!("                us/cloth/tick  meshes written/tick");
    let mut written = 0;
    for (name, app) in [("awake", &mut awake), ("asleep", &mut asleep)] {
        let measured = measure(app, cli.ticks);
        let time = (measured.time - empty) / f64::from(cli.cloths);
        written = measured.written;
        println!("{name:12} {time:16.3}  {:19.2}", written as f64 / f64::from(cli.ticks));
    }
    if still + written > 0 {
        eprintln!("check failed: {still} cloths do not sleep, {written} meshes were written");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// An app on one thread, with cloths in rows above the ground.
fn app(cloths: u32, particles: u32, sleep: ClothSleep) -> App {
    let one = TaskPoolThreadAssignmentPolicy {
        min_threads: 1,
        max_threads: 1,
        percent: 1.0,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    let task_pool_options =
        TaskPoolOptions { compute: one, ..TaskPoolOptions::with_num_threads(1) };
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins.set(TaskPoolPlugin { task_pool_options }),
        AssetPlugin::default(),
        MeshPlugin,
        TransformPlugin,
        ClothPlugin::default(),
    ))
    .init_resource::<Assets<Image>>()
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.finish();
    app.cleanup();
    app.world_mut().spawn(SdfCollider::from(InfinitePlane3d::default()));
    for i in 0..cloths {
        let place = Vec3::new((i % 20) as f32 * 2.0, 0.05, (i / 20) as f32 * 2.0);
        let cloth = Cloth::sheet(Vec2::ONE, UVec2::splat(particles));
        app.world_mut().spawn((cloth, sleep, Transform::from_translation(place)));
    }
    app
}

fn measure(app: &mut App, ticks: u32) -> Measured {
    let mut times = Vec::new();
    let mut written = 0;
    for _ in 0..ticks {
        let before = Instant::now();
        app.update();
        times.push(before.elapsed().as_secs_f64() * 1e6);
        let events = app.world().resource::<Messages<AssetEvent<Mesh>>>();
        written += events
            .iter_current_update_messages()
            .filter(|event| matches!(event, AssetEvent::Modified { .. }))
            .count();
    }
    times.sort_by(f64::total_cmp);
    Measured { time: times[times.len() / 2], written }
}
