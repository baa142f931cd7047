//! How time grows with the number of particles, and shrinks with the number of threads.

use std::{env, process::Command, thread, time::Instant};

use bevy::{
    app::{TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy},
    prelude::*,
    time::TimeUpdateStrategy,
};
use bevy_drape::{ClothSleepThreshold, prelude::*, solver::MassLumping};
use rayon::ThreadPoolBuilder;

use super::super::run::{self, Method, Run, cloth};
use super::super::{Extent, Job, Measured, Metric, Outcome, Scene};
use super::Sheet;

const SUBSTEPS: u32 = 8;
/// Cloths of the crowd, and their particles a side.
const CROWD: usize = 100;
const SIDE: u32 = 32;

/// A cloth of `n` x `n` particles that hangs; its particles are as far apart whatever their number.
fn hanging(n: usize) -> Outcome<Run<'static>> {
    let side = n as f64 / 64.0;
    let material = run::material(side / (n - 1) as f64);
    let material = bevy_drape::solver::Material { damping: 0.0, max_strain: 10.0, ..material };
    let method = Method::THREADS;
    let settings = method.settings(SUBSTEPS, MassLumping::Lumped);
    let mut cloth = cloth(&Sheet::upright(n, side), &method, material, settings)?;
    cloth.set_pins(&(0..n as u32).collect::<Vec<_>>())?;
    Ok(Run::new(cloth, &[]))
}

fn frames(n: usize) -> usize {
    (4_000_000 / (n * n)).clamp(12, 400)
}

fn size(n: usize) -> Outcome<Measured> {
    let mut run = hanging(n)?;
    run.frames(frames(n));
    Ok(Measured { errors: vec![f64::NAN], varies: true, ..run.measured(Vec::new()) })
}

/// The same, with its rows shared by so many threads; efficiency is against one.
fn shared(n: usize, threads: usize) -> Outcome<Measured> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let (mut one, mut all) = (hanging(n)?, hanging(n)?);
    all.cloth.set_shared(true);
    // In turns, as others use the machine too.
    for _ in 0..frames(n) {
        one.frame();
        pool.install(|| all.frame());
    }
    let (one, all) = (one.measured(Vec::new()), all.measured(Vec::new()));
    let part = median(&one.frames) / median(&all.frames) / threads as f64;
    Ok(Measured { errors: vec![100.0 * part], varies: true, ..all })
}

fn median(times: &[f64]) -> f64 {
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Median milliseconds of an update of an app of 100 cloths, with so many threads for them: what the option
/// `--crowd` prints.
pub fn crowd(threads: usize) -> f64 {
    let policy = |count| TaskPoolThreadAssignmentPolicy {
        min_threads: count,
        max_threads: count,
        percent: 1.0,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    let task_pool_options = TaskPoolOptions {
        compute: policy(threads),
        io: policy(1),
        async_compute: policy(1),
        ..TaskPoolOptions::default()
    };
    let mut app = App::new();
    app.add_plugins(MinimalPlugins.set(TaskPoolPlugin { task_pool_options }))
        .add_plugins(ClothPlugin::default())
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    for i in 0..CROWD {
        let place = Transform::from_xyz((i % 10) as f32 * 2.0, 0.0, (i / 10) as f32 * 2.0);
        let sheet = Cloth::sheet(Vec2::ONE, UVec2::splat(SIDE));
        app.world_mut().spawn((
            sheet,
            ClothPins::vertices([0, SIDE - 1]),
            ClothSleepThreshold::NEVER,
            place,
        ));
    }
    app.finish();
    app.cleanup();
    (0..30).for_each(|_| app.update());
    let times: Vec<_> = (0..120)
        .map(|_| {
            let before = Instant::now();
            app.update();
            before.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    median(&times)
}

/// The same in a process of its own, as an app's threads are there once for all.
fn crowd_apart(threads: usize) -> Outcome<f64> {
    let done =
        Command::new(env::current_exe()?).args(["--crowd", &threads.to_string()]).output()?;
    let said = String::from_utf8_lossy(&done.stdout).trim().to_owned();
    said.parse().map_err(|_| format!("a crowd on {threads} threads said `{said}`").into())
}

fn crowd_on(threads: usize) -> Outcome<Measured> {
    // In turns, as others use the machine too.
    let pair = |_| Ok((crowd_apart(1)?, crowd_apart(threads)?));
    let pairs = (0..5).map(pair).collect::<Outcome<Vec<(f64, f64)>>>()?;
    let mut parts: Vec<_> = pairs.iter().map(|(one, all)| one / all / threads as f64).collect();
    parts.sort_by(f64::total_cmp);
    Ok(Measured {
        frames: pairs.iter().map(|pair| pair.1).collect(),
        errors: vec![100.0 * parts[parts.len() / 2]],
        work: 0,
        allocations: f64::NAN,
        failed: None,
        varies: true,
    })
}

pub fn scene(extent: Extent) -> Outcome<Scene<'static>> {
    let sides: &[usize] = if extent.quick { &[32, 128] } else { &[32, 64, 128, 256, 512, 1000] };
    let mut jobs: Vec<_> = sides
        .iter()
        .map(|&n| Job {
            method: format!("one cloth of {} particles", n * n),
            n,
            knob: format!("{SUBSTEPS} substeps"),
            run: Box::new(move || size(n)),
        })
        .collect();
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let mut threads = 1;
    while threads <= cores {
        let count = threads;
        for &n in sides.iter().filter(|&&n| threads > 1 && n >= 128) {
            jobs.push(Job {
                method: format!("one cloth of {} particles, {count} threads", n * n),
                n,
                knob: format!("{SUBSTEPS} substeps"),
                run: Box::new(move || shared(n, count)),
            });
        }
        jobs.push(Job {
            method: format!("{CROWD} cloths of {SIDE} x {SIDE}, {count} threads"),
            n: SIDE as usize,
            knob: "the default".into(),
            run: Box::new(move || crowd_on(count)),
        });
        threads *= 2;
    }
    Ok(Scene {
        name: "scaling",
        title: "Particles and threads",
        about: format!(
            "A sheet that hangs from its upper row, {SUBSTEPS} substeps, particles 1/64 m apart, on one thread and shared by many; {CROWD} cloths in \
             a Bevy app, an update of 1/64 s. Efficiency is the time on one thread over the time on so many and their number."
        ),
        errors: vec![Metric::new("efficiency", "%")],
        jobs,
        plots: Vec::new(),
    })
}
