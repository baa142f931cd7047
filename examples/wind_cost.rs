//! What air and wind cost, a particle and substep.
//!
//! A cloth of 2 m held by two corners, on one core. Each line is the median of many ticks, and what it
//! adds to a cloth that feels no air.

use std::{error::Error, sync::Arc, time::Instant};

use bevy::math::{Vec2, Vec3, primitives::Sphere};
use bevy_drape::solver::{
    Air, ClothSolver, FormChoice, Gusts, Lattice, MassLumping, Material, PinMotion, Pose, Settings,
    StepInput, Substeps, Wind, WindFlow, WindShape, Zone,
};
use clap::Parser;

/// Measures what air and wind cost.
#[derive(Parser)]
struct Options {
    /// Particles a side.
    #[arg(short, long, default_value_t = 64)]
    particles: usize,
    /// Substeps a tick.
    #[arg(short, long, default_value_t = 20)]
    substeps: u32,
    /// Ticks to measure.
    #[arg(short, long, default_value_t = 400)]
    ticks: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let wind = Wind { velocity: Vec3::new(1.0, 0.0, 6.0), ..Wind::default() };
    let gusts = Gusts { strength: 3.0, ..Gusts::default() };
    let zone = |distance: f32| Zone {
        shape: WindShape::from(Sphere::new(1.5)),
        flow: WindFlow::Radial(5.0),
        falloff: 0.3,
        pose: Pose::from_translation(Vec3::new(distance, -0.5, -0.5)),
    };
    let (near, far) = ([zone(0.0)], vec![zone(100.0); 1000]);
    let drag = Air { lift: 0.0, ..Air::default() };
    let steep = Air { lift: 2.0, ..Air::default() };
    let cases = [
        ("no air", None, wind),
        ("drag", Some(drag), wind),
        ("drag and lift", Some(Air::default()), wind),
        ("more lift than drag", Some(steep), wind),
        ("with 1000 zones far away", Some(drag), Wind { zones: &far, ..wind }),
        ("with a zone", Some(drag), Wind { zones: &near, ..wind }),
        ("with gusts", Some(drag), Wind { gusts, ..wind }),
    ];
    println!("ns a particle and substep");
    for form in [FormChoice::Threads, FormChoice::Springs] {
        let mut without = 0.0;
        for (name, air, wind) in cases {
            let time = measure(&options, form, air, wind)?;
            if air.is_none() {
                without = time;
            }
            println!("{form:?}, {name:26} {time:6.2}  {:+6.2}", time - without);
        }
    }
    Ok(())
}

/// Nanoseconds a particle and substep.
fn measure(
    options: &Options,
    form: FormChoice,
    air: Option<Air>,
    wind: Wind<'_>,
) -> Result<f64, Box<dyn Error>> {
    let n = options.particles;
    let lattice = Arc::new(Lattice::sheet(Vec2::splat(2.0), n, n, MassLumping::Lumped)?);
    let material = Material {
        area_density: 0.2,
        thread_stiffness: if form == FormChoice::Springs { 50.0 } else { 2000.0 },
        shear_stiffness: 20.0,
        flexural_rigidity: 0.0,
        damping: 0.0,
        damping_form: Default::default(),
        drag: 0.2,
        max_strain: 10.0,
        friction: 0.5,
        thickness: 0.005,
    };
    let settings =
        Settings { form, substeps: Substeps::Fixed(options.substeps), ..Settings::default() };
    let start = lattice.rest_positions().to_vec();
    let mut cloth = ClothSolver::new(lattice, &start, material, settings)?;
    cloth.set_pins(&[0, n as u32 - 1])?;
    cloth.set_air(air)?;
    let pins = [0, n - 1].map(|particle| PinMotion::still(start[particle]));
    let gravity = Vec3::new(0.0, -9.81, 0.0);
    let mut times = Vec::with_capacity(options.ticks);
    for tick in 0..options.ticks.max(1) {
        let wind = Wind { time: tick as f64 / 64.0, ..wind };
        let dt = 1.0 / 64.0;
        let input = StepInput { dt, gravity, pins: &pins, wind, ..StepInput::default() };
        let before = Instant::now();
        cloth.tick(&input)?;
        times.push(before.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    let steps = (n * n) as f64 * f64::from(options.substeps);
    Ok(times[times.len() / 2] * 1e9 / steps)
}
