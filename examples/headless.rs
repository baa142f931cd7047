//! The same scenes without a window, under `MinimalPlugins`: a report, the final meshes, a check.
//!
//! `cargo run --example headless`

// A program may print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod gallery;

use clap::Parser;
use examples_common::{Example, headless, seconds};
use std::{path::PathBuf, process::ExitCode};

/// Runs a scene without a window, reports, and writes the final meshes.
///
/// The exit code is 1 if a cloth is not finite, has left its box, or is below the ground.
#[derive(Parser)]
struct Cli {
    /// What to run.
    #[arg(default_value = "drape", value_parser = gallery::parser())]
    scene: Example,
    /// Particles a side of each cloth.
    #[arg(short, long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=512))]
    particles: u32,
    /// Seconds to simulate.
    #[arg(short, long, default_value_t = 5.0, value_parser = seconds)]
    seconds: f32,
    /// Threads; with one, the time is that of one core.
    #[arg(short, long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Folder for the final meshes, as OBJ.
    #[arg(short, long, default_value = "target/headless")]
    out: PathBuf,
}

fn main() -> ExitCode {
    let Cli { scene, particles, seconds, threads, out } = Cli::parse();
    match headless::run(scene, particles, seconds, threads.into(), Some(&out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("check failed: {reason}");
            ExitCode::FAILURE
        }
    }
}
