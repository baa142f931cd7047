//! Bakes the closed mesh of an OBJ file to a distance field, for colliders to load.
//!
//! `cargo run --example bake -- assets/bunny.obj bunny.sdf`

// A program may print.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use bevy::math::Vec3;
use bevy_drape::sdf::{BakeSettings, DistanceField, SignedDistance};
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    error::Error,
    fmt::Display,
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
    time::{Duration, Instant},
};

/// Bakes the closed mesh of an OBJ file to a distance field, an `.sdf` file.
///
/// The exit code is 1 if the mesh cannot be baked or a file cannot be read or written.
#[derive(Parser)]
#[command(allow_negative_numbers = true)]
pub struct Cli {
    /// The mesh, an OBJ file. All of its objects are taken as one.
    input: PathBuf,
    /// The file to write; the input's name with `.sdf` where none is given.
    output: Option<PathBuf>,
    /// Cells along the longest side of the mesh.
    #[arg(short, long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=4096))]
    cells: u32,
    /// Size of a cell [m], in place of their number.
    #[arg(short = 's', long, value_name = "METRES", conflicts_with = "cells")]
    cell_size: Option<f32>,
    /// How far the field reaches beyond the mesh [m]; two cells where none is given.
    #[arg(short, long, value_name = "METRES")]
    margin: Option<f32>,
}

/// Bakes, reports, saves, and holds what was saved against what was baked.
///
/// # Errors
/// When the mesh cannot be baked, or a file cannot be read or written.
pub fn run(cli: &Cli) -> Result<(), Box<dyn Error>> {
    let output = cli.output.clone().unwrap_or_else(|| cli.input.with_extension("sdf"));
    if output.extension().is_none_or(|extension| extension != "sdf") {
        return Err(format!("`{}` must end in `.sdf`, to be loaded", output.display()).into());
    }
    // Before the bake, which may take minutes.
    if output.parent().is_some_and(|folder| folder != Path::new("") && !folder.is_dir()) {
        return Err(format!("{}: there is no such folder", output.display()).into());
    }
    let (positions, indices) = read_obj(&cli.input)?;
    println!("{}: {} triangles", cli.input.display(), indices.len() / 3);

    let mut settings = BakeSettings::for_mesh(&positions, cli.cells);
    if let Some(cell_size) = cli.cell_size {
        settings = BakeSettings { cell_size, margin: 2.0 * cell_size };
    }
    settings.margin = cli.margin.unwrap_or(settings.margin);
    let (field, time) = bake(&positions, &indices, &settings).map_err(of(&cli.input))?;
    let [x, y, z] = field.dims().to_array();
    println!(
        "baked in {:.2} s: {x} x {y} x {z} nodes, {:.4} m apart, {:.2} MiB",
        time.as_secs_f32(),
        field.cell_size(),
        field.memory_bytes() as f32 / 1_048_576.0
    );
    println!("between nodes, distances are at most {:.4} m too large", field.overestimate());

    let bytes = field.to_bytes();
    fs::write(&output, &bytes).map_err(of(&output))?;
    let start = Instant::now();
    let read = fs::read(&output).map_err(of(&output))?;
    let back = DistanceField::from_bytes(&read).map_err(of(&output))?;
    let time = start.elapsed();
    if back != field || read != bytes {
        return Err(format!("{}: what was read is not what was written", output.display()).into());
    }
    println!("{}: {} bytes, read back in {:.2?}, identical", output.display(), bytes.len(), time);
    Ok(())
}

/// Names the file that an error is about.
fn of<E: Display>(path: &Path) -> impl Fn(E) -> String {
    move |error| format!("{}: {error}", path.display())
}

/// Positions and indices of all objects.
fn read_obj(path: &Path) -> Result<(Vec<Vec3>, Vec<u32>), Box<dyn Error>> {
    // The parser would not say what is wrong with a file that is not there, or is no text.
    let text = fs::read_to_string(path).map_err(of(path))?;
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(&mut text.as_bytes(), &tobj::GPU_LOAD_OPTIONS, no_materials)
            .map_err(of(path))?;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for model in models {
        let first = positions.len() as u32;
        positions.extend(model.mesh.positions.as_chunks().0.iter().map(|p| Vec3::from_array(*p)));
        indices.extend(model.mesh.indices.iter().map(|index| first + index));
    }
    Ok((positions, indices))
}

/// Bakes behind a progress bar, and takes the time.
fn bake(
    positions: &[Vec3],
    indices: &[u32],
    settings: &BakeSettings,
) -> Result<(DistanceField, Duration), Box<dyn Error>> {
    const STEPS: f32 = 1000.0;
    let style = ProgressStyle::with_template("baking {wide_bar} {percent:>3} % {elapsed}")?;
    let bar = ProgressBar::new(STEPS as u64).with_style(style);
    let mut show = |share: f32| bar.set_position((STEPS * share) as u64);
    let start = Instant::now();
    let field = DistanceField::bake_with_progress(positions, indices, settings, &mut show);
    bar.finish_and_clear();
    Ok((field?, start.elapsed()))
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
