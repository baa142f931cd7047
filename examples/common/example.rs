//! An example, and how it is run: in a window, or without one.

use crate::{check::Bounds, options::Options, wait::wait_for_tasks};
use bevy::prelude::*;
use clap::{Args, Command, FromArgMatches};

/// An example: a scene, and what is told of it.
#[derive(Clone, Copy)]
pub struct Example {
    /// Its name on the command line.
    pub name: &'static str,
    /// What is seen, in one line.
    pub about: &'static str,
    /// The scene: a plugin beside [`ClothPlugin`](bevy_drape::ClothPlugin).
    pub scene: fn(&mut App),
    /// From where it is seen.
    pub view: View,
    /// The box that its cloths are in at the end \[m\]: its lowest corner, its highest.
    pub bounds: [[f32; 3]; 2],
}

/// Where the camera is, what it looks at \[m\].
#[derive(Resource, Clone, Copy)]
pub struct View {
    /// Where the camera is.
    pub from: Vec3,
    /// What it looks at.
    pub at: Vec3,
}

/// Particles a side of each cloth, as `--particles` asks for.
#[derive(Resource, Clone, Copy)]
pub struct Particles(pub u32);

/// Lines of text, written in front of the camera where there is a window.
#[derive(Resource, Default)]
pub struct Caption(pub Vec<String>);

impl Example {
    /// Reads the command line, and runs in a window; where there can be none, without.
    pub fn show(self) -> AppExit {
        self.show_with(|_| {})
    }

    /// The same, with more in the app that has a window.
    pub fn show_with(self, add: impl FnOnce(&mut App)) -> AppExit {
        let more = "Where there is no display or no graphics adapter it says so and runs headless.";
        // What is told last holds: the options have a description of their own.
        let command = Options::augment_args(Command::new(self.name))
            .about(self.about)
            .long_about(format!("{}.\n\n{more}", self.about));
        let matches = command.get_matches();
        let options = Options::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
        self.run(&options, add)
    }

    #[cfg(feature = "demo")]
    fn run(self, options: &Options, add: impl FnOnce(&mut App)) -> AppExit {
        crate::window::run(self, options, add)
    }

    #[cfg(not(feature = "demo"))]
    fn run(self, options: &Options, _: impl FnOnce(&mut App)) -> AppExit {
        self.run_headless(options)
    }

    /// Runs where there is no window.
    pub(crate) fn run_headless(self, options: &Options) -> AppExit {
        println!("Running headless instead.");
        match crate::headless::run(self, options.particles, options.seconds, 1, None) {
            Ok(()) => AppExit::Success,
            Err(reason) => fail(&reason),
        }
    }

    /// Adds the scene to an app that has a [`ClothPlugin`](bevy_drape::ClothPlugin), meshes and transforms.
    pub fn add_to(self, app: &mut App, particles: u32) {
        let [min, max] = self.bounds.map(Vec3::from);
        app.init_resource::<Assets<Image>>()
            .init_resource::<Caption>()
            .insert_resource(Bounds { min, max })
            .insert_resource(Particles(particles))
            .add_systems(Update, wait_for_tasks);
        (self.scene)(app);
    }
}

/// Says what is wrong.
pub(crate) fn fail(reason: &str) -> AppExit {
    eprintln!("check failed: {reason}");
    AppExit::error()
}
