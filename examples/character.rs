//! Writes the character of the example `skirt`, a glTF file as a modelling program would export it.
//!
//! `cargo run --example character -- assets/character.glb`

// A program may print.
#![allow(clippy::print_stdout)]

use clap::Parser;
use examples_common::character::character;
use std::{fs, io, path::PathBuf};

/// Writes a character with a skirt, a walk and a sprint, as a binary glTF file.
#[derive(Parser)]
struct Cli {
    /// The file to write.
    output: PathBuf,
}

fn main() -> io::Result<()> {
    let Cli { output } = Cli::parse();
    let bytes = character();
    fs::write(&output, &bytes)?;
    println!("wrote {}: {} bytes", output.display(), bytes.len());
    Ok(())
}
