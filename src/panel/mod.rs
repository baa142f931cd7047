//! A panel to tune cloths by: what a cloth is and does, gathered into plain numbers; what is asked of it, done
//! through its components; and windows drawn from the one, that ask for the other.
//!
//! - `model`: [`ClothPanel`], the facts and the actions.
//! - `gather`: a system that looks at the chosen cloth once a frame.
//! - `act`: a system that does what was asked.
//! - `history`: what the plots show.
//! - `explain`: what the solver chose and why, in words.
//! - `file`: materials as RON.
//! - `view`, `plots`: egui.

mod act;
mod explain;
mod file;
mod gather;
mod history;
mod model;
mod plots;
mod view;

use bevy::prelude::*;
use bevy_egui::{EguiPlugin, EguiPrimaryContextPass};

pub use crate::panel::explain::explain;
pub use crate::panel::file::{MaterialFileError, load_material, save_material};
pub use crate::panel::history::{PanelHistory, PanelSample};
pub use crate::panel::model::{ClothPanel, PanelAction, PanelFacts};

use crate::diagnostics::ClothDiagnosticsPlugin;
use crate::simulation::ClothSimulation;

/// A window to tune cloths by, and to see what they do: choose a cloth; change its material, pins, settings and
/// air, the wind and gravity; pause it, step it, reset it; save its material and load another. Plots show its
/// strain, energy, depth in colliders, and the milliseconds of all cloths; and it says what the solver chose,
/// and why.
///
/// Add it after `DefaultPlugins`, and after `EguiPlugin` where the game has it. It brings `EguiPlugin` and [`ClothDiagnosticsPlugin`] where they are not
/// there. Every change goes through the cloth's public components. [`ClothPanel::open`] closes it, and as long
/// as it is closed nothing is measured for it.
///
/// ```no_run
/// use bevy::prelude::*;
/// use bevy_drape::{ClothPanelPlugin, prelude::*};
///
/// App::new().add_plugins((DefaultPlugins, ClothPlugin::default(), ClothPanelPlugin)).run();
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothPanelPlugin;

impl Plugin for ClothPanelPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<EguiPlugin>() {
            app.add_plugins(EguiPlugin::default());
        }
        app.add_plugins(ClothPanelModelPlugin)
            .add_systems(EguiPrimaryContextPass, view::draw_panel);
    }
}

/// The panel without its window: [`ClothPanel`] gathers and acts. For a window of your own, and for tests.
/// [`ClothPanelPlugin`] brings it.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClothPanelModelPlugin;

impl Plugin for ClothPanelModelPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ClothDiagnosticsPlugin>() {
            app.add_plugins(ClothDiagnosticsPlugin);
        }
        app.init_resource::<ClothPanel>().add_systems(
            Last,
            (act::act.run_if(resource_exists::<ClothPanel>), gather::gather.run_if(is_open))
                .chain(),
        );
    }
}

fn is_open(panel: Option<Res<ClothPanel>>, cloths: Query<(), With<ClothSimulation>>) -> bool {
    panel.is_some_and(|panel| panel.open && (!cloths.is_empty() || panel.facts().is_some()))
}
