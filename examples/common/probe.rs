//! Finds out whether a window can be had: a display, the libraries that it takes, a graphics adapter.
//!
//! What is missing shows up as panics deep in the windowing and graphics libraries. So the program
//! starts itself once more, with `--probe`, tries with an invisible window, and tells by its exit
//! code.

use bevy::prelude::*;
use std::{
    env, panic,
    process::{Child, Command, Stdio, exit},
    thread,
    time::{Duration, Instant},
};

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// Whether a window can be had.
///
/// # Errors
/// Why not.
pub(crate) fn ask() -> Result<(), String> {
    let child = env::current_exe().and_then(|program| {
        Command::new(program)
            .arg("--probe")
            .env("RUST_LOG", "off")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
    });
    wait(child.map_err(|error| error.to_string())?)
}

fn wait(mut child: Child) -> Result<(), String> {
    let asked = Instant::now();
    while child.try_wait().map_err(|error| error.to_string())?.is_none() {
        if asked.elapsed() > PATIENCE {
            let _ = child.kill();
            return Err(format!("no answer in {} s", PATIENCE.as_secs()));
        }
        thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stderr);
    let reason = text.lines().rfind(|line| !line.trim().is_empty());
    match (output.status.success(), reason) {
        (true, _) => Ok(()),
        (false, Some(reason)) => Err(format!("{reason} ({})", output.status)),
        (false, None) => Err(output.status.to_string()),
    }
}

/// Tries: opens an invisible window and draws a few frames.
pub(crate) fn answer() -> AppExit {
    // A panic in a background task would leave the window waiting for it for ever.
    panic::set_hook(Box::new(|panic| {
        let payload = panic.payload_as_str().unwrap_or("a panic without words");
        eprintln!("{}", payload.replace('\n', " "));
        exit(1);
    }));
    let window = Window { visible: false, ..default() };
    let mut frames = 0;
    App::new()
        .add_plugins(DefaultPlugins.set(WindowPlugin { primary_window: Some(window), ..default() }))
        .add_systems(Update, move |mut exit: MessageWriter<AppExit>| {
            frames += 1;
            if frames == 3 {
                exit.write(AppExit::Success);
            }
        })
        .run()
}
