//! HANG and DRAPE: two scenes with known answers, for speed against error.
//!
//! HANG: a square of 1 m, held by two corners, falls from rest. While its threads do not stretch every
//! column moves as the same chain of rigid links, whose motion is known exactly
//! (`tests/data/hang_exact.csv`). DRAPE: a square of 2 m falls onto a sphere of radius 0.5 m, friction
//! 0.5. Both with equal masses, 0.2 kg/m2, no damping, frames of 1/60 s, 3 s long, on one core, with
//! one and the same material and the automatic settings.
//!
//! `cargo run --example hang_drape`

use std::{error::Error, fs, sync::Arc, time::Instant};

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    ClothSolver, Collider, DampingForm, Lattice, MassLumping, Material, PinMotion, Pose, Settings,
    StepInput, Substeps,
};
use clap::Parser;

/// Measures speed and error of the HANG and DRAPE scenes.
#[derive(Parser)]
struct Options {
    /// Particles a side: 32, 64 or 128 have an exact motion to compare with.
    #[arg(short, long, value_delimiter = ',', default_values_t = [32, 64, 128])]
    n: Vec<usize>,
    /// Substeps a frame; the automatic choice if left out.
    #[arg(short, long, value_delimiter = ',')]
    substeps: Vec<u32>,
    /// Runs of each scene; the median frame of the median run is printed.
    #[arg(short, long, default_value_t = 5)]
    runs: usize,
}

const FRAME: f32 = 1.0 / 60.0;
const RADIUS: f32 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let exact =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hang_exact.csv"))?;
    let mut choices = vec![Substeps::default()];
    if !options.substeps.is_empty() {
        choices = options.substeps.iter().map(|&n| Substeps::Fixed(n)).collect();
    }
    println!("scene    n  ms/frame   RMS mm  p99 strain %  depth mm  plan");
    for &n in &options.n {
        for scene in [Scene::Hang, Scene::Drape] {
            for &substeps in &choices {
                let mut runs = (0..options.runs.max(1))
                    .map(|_| run(scene, n, substeps, &exact))
                    .collect::<Result<Vec<_>, _>>()?;
                runs.sort_by(|a, b| a.milliseconds.total_cmp(&b.milliseconds));
                println!("{}", runs[runs.len() / 2].line);
            }
        }
    }
    Ok(())
}

#[derive(Clone, Copy, PartialEq)]
enum Scene {
    Hang,
    Drape,
}

struct Run {
    milliseconds: f64,
    line: String,
}

fn run(scene: Scene, n: usize, substeps: Substeps, exact: &str) -> Result<Run, Box<dyn Error>> {
    let (side, offset) = match scene {
        Scene::Hang => (1.0, Vec3::new(0.0, 0.0, 0.5)),
        Scene::Drape => (2.0, Vec3::new(0.0, 0.6, 0.0)),
    };
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(side), n, n, MassLumping::Equal)?);
    let start: Vec<Vec3> = lattice.rest_positions().iter().map(|&p| p + offset).collect();
    let settings = Settings { substeps, lumping: MassLumping::Equal, ..Settings::default() };
    let mut cloth = ClothSolver::new(lattice, &start, MATERIAL, settings)?;
    if scene == Scene::Hang {
        cloth.set_pins(&[0, n as u32 - 1])?;
    }
    let pins: Vec<_> = cloth.pins().iter().map(|&p| PinMotion::still(start[p as usize])).collect();
    let sphere = Sphere::new(RADIUS);
    let ball =
        Collider { shape: &sphere, start: Pose::IDENTITY, end: Pose::IDENTITY, friction: 0.5 };
    let colliders = if scene == Scene::Drape { vec![ball] } else { Vec::new() };
    let gravity = Vec3::new(0.0, -9.81, 0.0);
    let input = StepInput { dt: FRAME, gravity, pins: &pins, colliders: &colliders };

    let (mut times, mut square, mut p99, mut depth) = (Vec::new(), 0.0, 0.0_f32, 0.0_f32);
    for frame in 1..=180_usize {
        let before = Instant::now();
        cloth.tick(&input)?;
        times.push(before.elapsed().as_secs_f64() * 1e3);
        if scene == Scene::Hang && frame % 6 == 0 && frame <= 36 {
            square += mean_square(&cloth, n, frame as f64 / 60.0, exact)? / 6.0;
        }
        if scene == Scene::Drape {
            let deepest = |depth: f32, i| depth.max(RADIUS - cloth.position(i).length());
            depth = (0..n * n).fold(depth, deepest);
        }
        if frame % 60 == 0 {
            p99 = p99.max(cloth.strain().p99);
        }
    }
    times.sort_by(f64::total_cmp);
    let milliseconds = times[times.len() / 2];
    let name = if scene == Scene::Hang { "HANG" } else { "DRAPE" };
    let rms = if scene == Scene::Hang {
        format!("{:8.2}", square.sqrt() * 1e3)
    } else {
        "       -".into()
    };
    let (strain, deep, plan) = (p99 * 100.0, depth * 1e3, cloth.plan());
    let line =
        format!("{name:5} {n:4}  {milliseconds:8.3} {rms}  {strain:12.3}  {deep:8.3}  {plan}");
    Ok(Run { milliseconds, line })
}

/// Threads that do not stretch, as the scenes ask; no bending, no damping.
const MATERIAL: Material = Material {
    area_density: 0.2,
    thread_stiffness: 1e6,
    shear_stiffness: 1e6,
    flexural_rigidity: 0.0,
    damping: 0.0,
    damping_form: DampingForm::Axial,
    drag: 0.0,
    max_strain: 0.1,
    friction: 0.5,
    thickness: 0.0,
};

/// Mean square distance [m2] to the exact motion at time `t`; NaN where it is not known for this `n`.
fn mean_square(cloth: &ClothSolver, n: usize, t: f64, exact: &str) -> Result<f64, Box<dyn Error>> {
    let (mut sum, mut count) = (0.0, 0);
    for line in exact.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())) {
        let row = line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let [rows, time, row, out, y] = row[..] else {
            return Err("a row needs five numbers".into());
        };
        if rows as usize != n || (time - t).abs() > 1e-6 {
            continue;
        }
        for column in 0..n {
            let p = cloth.position(row as usize * n + column).as_dvec3();
            let x = column as f64 / (n - 1) as f64 - 0.5;
            sum += (p.x - x).powi(2) + (p.y - y).powi(2) + (p.z - out).powi(2);
            count += 1;
        }
    }
    Ok(sum / f64::from(count))
}
