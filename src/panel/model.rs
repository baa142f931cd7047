//! The facts that the panel shows, and the actions that it can ask for.

use std::path::PathBuf;

use bevy::prelude::*;

use crate::cloth::air::ClothAir;
use crate::cloth::inter_collision::ClothInterCollision;
use crate::cloth::material::ClothMaterial;
use crate::cloth::pins::ClothPins;
use crate::cloth::self_collision::ClothSelfCollision;
use crate::cloth::settings::ClothSettings;
use crate::cloth::wind::ClothWind;
use crate::panel::history::PanelHistory;
use crate::solver::Plan;

/// The panel: what it has gathered of the chosen cloth, and what it is asked to do.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothPanel, PanelAction, prelude::*};
/// fn make_it_silk(mut panel: ResMut<ClothPanel>) {
///     panel.ask(PanelAction::SetMaterial(ClothMaterial::SILK));
/// }
/// # bevy::ecs::system::assert_is_system(make_it_silk);
/// ```
#[derive(Resource, Debug)]
pub struct ClothPanel {
    /// Whether it is shown. Closed, it measures nothing.
    pub open: bool,
    /// The file that its buttons save the material to and load it from.
    pub path: String,
    /// The last message: that a file was saved, or why not.
    pub(super) message: String,
    pub(super) facts: Option<PanelFacts>,
    pub(super) history: PanelHistory,
    pub(super) asked: Vec<PanelAction>,
}

impl Default for ClothPanel {
    fn default() -> Self {
        Self {
            open: true,
            path: "cloth.ron".into(),
            message: String::new(),
            facts: None,
            history: PanelHistory::default(),
            asked: Vec::new(),
        }
    }
}

impl ClothPanel {
    /// The chosen cloth at the last frame's end; `None` where there is none.
    pub fn facts(&self) -> Option<&PanelFacts> {
        self.facts.as_ref()
    }

    /// The measurements, frame by frame.
    pub fn history(&self) -> &PanelHistory {
        &self.history
    }

    /// The last message: that a file was saved, or why not.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Asks for something, to be done at the frame's end, in the order asked.
    pub fn ask(&mut self, action: PanelAction) {
        self.asked.push(action);
    }
}

/// The facts about the chosen cloth.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelFacts {
    /// All cloths, by name, in the order of their entities' numbers.
    pub cloths: Vec<(Entity, String)>,
    /// The chosen one.
    pub chosen: Entity,
    /// Its particles.
    pub particle_count: usize,
    /// Shortest distance of neighbouring particles at rest \[m\].
    pub spacing: f32,
    /// Its material, as its component has it.
    pub material: ClothMaterial,
    /// Its settings.
    pub settings: ClothSettings,
    /// Its pins.
    pub pins: ClothPins,
    /// How it feels the air, if it does.
    pub air: Option<ClothAir>,
    /// How it collides with itself, if it does.
    pub self_collision: Option<ClothSelfCollision>,
    /// How it collides with other cloths, if it does.
    pub inter_collision: Option<ClothInterCollision>,
    /// Its gravity [m/s2]: that of the world, or its own.
    pub gravity: Vec3,
    /// Its wind: that of the world, or its own.
    pub wind: ClothWind,
    /// Whether it is frozen.
    pub paused: bool,
    /// Whether it sleeps.
    pub asleep: bool,
    /// The solver's plan.
    pub plan: Plan,
    /// The errors on its entity.
    pub errors: Vec<String>,
}

/// An action that the panel can be asked for, on the chosen cloth where nothing else is said.
#[derive(Clone, Debug, PartialEq)]
pub enum PanelAction {
    /// Chooses another cloth.
    Choose(Entity),
    /// Gives it another material.
    SetMaterial(ClothMaterial),
    /// Gives it other settings.
    SetSettings(ClothSettings),
    /// Gives it other pins.
    SetPins(ClothPins),
    /// Lets it feel the air, or not.
    SetAir(Option<ClothAir>),
    /// Lets it collide with itself, or not.
    SetSelfCollision(Option<ClothSelfCollision>),
    /// Lets it collide with other cloths, or not.
    SetInterCollision(Option<ClothInterCollision>),
    /// Another gravity [m/s2]: its own where it has one, else that of the world.
    SetGravity(Vec3),
    /// Another wind: its own where it has one, else that of the world.
    SetWind(ClothWind),
    /// Freezes it, or lets it go on.
    Pause(bool),
    /// Freezes it, and takes a single tick.
    Step,
    /// Puts it back to its rest shape.
    Reset,
    /// Saves its material as RON.
    Save(PathBuf),
    /// Gives it the material of a file.
    Load(PathBuf),
}
