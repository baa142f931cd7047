//! What is asked for on the command line.

use clap::Args;
use std::path::PathBuf;

/// Options of every windowed example.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Particles a side of each cloth.
    #[arg(short, long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(2..=512))]
    pub particles: u32,
    /// Seconds to simulate where there is no window.
    #[arg(short, long, default_value_t = 5.0, value_parser = seconds)]
    pub seconds: f32,
    /// Leave after so many frames of 1/16 s each (of a film 1/32 s), with the final check.
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(1..))]
    pub frames: Option<u32>,
    /// Save the last of the frames as a picture, or all where the name has a `#`; 80 frames where none are given.
    #[arg(long, value_name = "PNG")]
    pub screenshot: Option<PathBuf>,
    /// Draw lines to look inside: all of these, or threads and pins where none is named.
    #[cfg(all(feature = "demo", feature = "gizmos"))]
    #[arg(short, long, value_enum, value_delimiter = ',', num_args = 0..)]
    pub gizmos: Option<Vec<crate::gizmos::Lines>>,
    /// Only find out whether a window can be had: exit code 0 if so.
    #[arg(long, hide = true)]
    pub probe: bool,
}

/// Reads a time that can be simulated \[s\].
///
/// # Errors
/// What to give in its place.
pub fn seconds(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err("give a number of seconds from 0.1 to 3600".into()),
    }
}
