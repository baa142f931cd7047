//! What each optional part costs, each with and without in turns; and that what is unused costs and changes
//! nothing.
//!
//! `cargo run --release --example costs`

// A program may print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod app;
mod bodies;
mod body;
mod crowd;
mod edges;
#[cfg(feature = "avian")]
mod engines;
mod fields;
mod ground;
mod proxy;
mod skinned;
mod solver;
mod turns;

use clap::{Parser, ValueEnum};
use examples_common::repository;
use std::{error::Error, path::PathBuf, process::ExitCode};
use turns::Wrong;

/// Measures what each optional part costs: medians of times taken in turns with and without it, on one
/// thread.
///
/// The exit code is 1 if anything that is not a time is wrong: a cloth fails, something that is unused changes
/// a bit, or a cloth that sleeps wakes or is drawn.
#[derive(Parser)]
struct Cli {
    /// Parts to measure; all if left out.
    parts: Vec<Part>,
    /// Particles a side of each cloth.
    #[arg(short, long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(4..=256))]
    particles: u32,
    /// Ticks to measure, with and without.
    #[arg(short, long, default_value_t = 400, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    ticks: u32,
    /// A glTF file of a character that capsules are fitted to. May be given several times.
    #[arg(long = "character", value_name = "FILE", default_values_os_t = [repository("assets/character.glb")])]
    characters: Vec<PathBuf>,
}

#[derive(ValueEnum, Clone, Copy, PartialEq)]
enum Part {
    /// Meshes solved as graphs.
    Graphs,
    /// A thousand colliders; teleport and inertia.
    Colliders,
    /// Ten bodies that a cloth lies on.
    Bodies,
    /// The body of a character.
    Body,
    /// Colliders of Avian.
    #[cfg(feature = "avian")]
    Engines,
    /// Cloths that sleep.
    Sleep,
    /// A hundred cloths, of which ten are seen.
    Crowd,
    /// A sheet that is drawn finer than it is simulated.
    Proxy,
    /// Air, wind and zones.
    Wind,
    /// Max distance, backstop, drive, and where the skin is.
    Skin,
    /// Impulses, swept contact, edges, soft pins, a cloth on hills.
    Contact,
    /// Baked fields, and baking them.
    Fields,
    /// Height fields: what a point costs.
    Ground,
    /// The plugin around the solver.
    Plugin,
}

fn main() -> ExitCode {
    let mut wrong = Wrong::default();
    if let Err(error) = measure(&Cli::parse(), &mut wrong) {
        wrong.0.push(error.to_string());
    }
    for wrong in &wrong.0 {
        eprintln!("check failed: {wrong}");
    }
    if wrong.0.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn measure(cli: &Cli, wrong: &mut Wrong) -> Result<(), Box<dyn Error>> {
    let (n, side, ticks) = (cli.particles, cli.particles as usize, cli.ticks as usize);
    println!("{n} x {n} particles, medians of {ticks} ticks with and without, in turns");
    for part in Part::value_variants() {
        if !cli.parts.is_empty() && !cli.parts.contains(part) {
            continue;
        }
        match part {
            Part::Graphs => solver::graphs(side, ticks, wrong)?,
            Part::Colliders => app::colliders_and_components(n, ticks, wrong),
            Part::Bodies => bodies::bodies(n, ticks, wrong),
            Part::Body => body::bodies_of(&cli.characters, ticks.min(100), wrong),
            #[cfg(feature = "avian")]
            Part::Engines => engines::engines(n, ticks, wrong),
            Part::Sleep => app::sleep(ticks, wrong),
            Part::Crowd => crowd::crowd_of_few_seen(ticks, wrong),
            Part::Proxy => proxy::few_carry_many(ticks, wrong),
            Part::Wind => solver::wind(side, ticks, wrong)?,
            Part::Skin => {
                solver::skin(side, ticks, wrong)?;
                skinned::skinning(ticks);
            }
            Part::Contact => {
                solver::contact(side, ticks, wrong)?;
                edges::edges(ticks.min(250), wrong)?;
                ground::lying(ticks.min(250), wrong)?;
            }
            Part::Fields => fields::fields(side, ticks, wrong)?,
            Part::Ground => ground::ground()?,
            Part::Plugin => app::plugin(n, ticks, wrong),
        }
    }
    Ok(())
}
