//! Cloth that does less where less is seen, and the time that all cloths together may take.

use bevy::prelude::*;

use crate::cloth::proxy::ClothProxy;
use crate::cloth::settings::ClothSettings;
use crate::solver::{ParameterError, Settings, Substeps};

/// Levels of detail: what a cloth takes less of the further it is away. For crowds.
///
/// At level 0 it is as its other components say. From there on, each level of the list is one more. Which level is in force goes by the
/// distance between what leads the cloth (its entity, its first anchor, or the joint that moves most of it) and the nearest camera that is
/// active. In an app without cameras it is 0. A level is left for a lower one at 85 % of its distance: at a border nothing flickers.
///
/// Cameras differ from one player to the next: a game that must run alike on all machines sets [`ClothLod::given`] by a rule of its own.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::{ClothCulling, ClothLevel, ClothLod, ClothProxy, prelude::*};
/// # fn spawn(mut commands: Commands) {
/// commands.spawn((
///     Cloth::sheet(Vec2::new(1.0, 1.5), UVec2::splat(32)),
///     ClothCulling::default(),
///     ClothLod {
///         levels: vec![
///             ClothLevel::at(8.0).substeps(10),
///             ClothLevel::at(20.0).substeps(5).proxy(ClothProxy::ratio(0.25)),
///         ],
///         ..default()
///     },
/// ));
/// # }
/// ```
///
/// [`ClothSimulation::level`](crate::ClothSimulation::level) tells the level in force. A snapshot has as many particles as its level: it is put
/// back at the same one. [`ClothCulling`](crate::ClothCulling) stops what is not seen at all.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothLod {
    /// The levels, nearest first. The default are two: half of the usual substeps from 10 m on, a quarter from 25 m on.
    pub levels: Vec<ClothLevel>,
    /// The level that a game gives; `None` (the default) goes by distance. One that is beyond the last is the last.
    pub given: Option<u32>,
}

/// A level of [`ClothLod`]: what is in force instead of the cloth's own components.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Debug, PartialEq, Clone)]
pub struct ClothLevel {
    /// Distance from which on it is in force \[m\], above 0 and above that of the level before.
    pub distance: f32,
    /// In the place of [`ClothSettings::substeps`](crate::ClothSettings::substeps); `None` changes nothing. The time of a tick goes in
    /// proportion, down to a few. A cloth of stiff threads that hangs from single points rests a little lower with few.
    pub substeps: Option<Substeps>,
    /// In the place of the cloth's own [`ClothProxy`]; `None` changes nothing. The cloth goes on where it is. Another shape takes
    /// milliseconds to make, so that by distance one cloth a frame gets one.
    pub proxy: Option<ClothProxy>,
}

/// Time that the cloths of an app may take together. Insert the resource to hold them to it: as long as they take longer,
/// the levels of those with [`ClothLod`] are raised, the furthest first; once they take less than 80 %, they come back.
///
/// It measures, so that no two runs are alike, and levels that a game [gives](ClothLod::given) are left alone.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Debug, PartialEq, Clone)]
pub struct ClothBudget {
    /// Time for all ticks of a frame \[ms\], above 0. Another number is told in the log, and raises nothing.
    pub milliseconds: f32,
    /// Time that they take: from gathering to the end of the ticks, averaged over some ten frames \[ms\].
    pub measured: f32,
    /// Levels by which cloths have been raised, all of them together.
    pub raised: u32,
    /// Cloths with [`ClothLod`] at each level, from 0 on, and as the last number those that are culled.
    pub cloths: Vec<u32>,
}

impl ClothLevel {
    /// A level from a distance on \[m\] that changes nothing yet.
    pub fn at(distance: f32) -> Self {
        Self { distance, substeps: None, proxy: None }
    }

    /// With up to so many substeps in 1/60 s, and more for layers of cloth and for bodies that strike it.
    pub fn substeps(self, budget: u32) -> Self {
        Self { substeps: Some(Substeps::Automatic { budget }), ..self }
    }

    /// With a coarser shape.
    pub fn proxy(self, proxy: ClothProxy) -> Self {
        Self { proxy: Some(proxy), ..self }
    }
}

impl Default for ClothLod {
    fn default() -> Self {
        let levels = [(10.0, 10), (25.0, 5)].map(|(at, many)| ClothLevel::at(at).substeps(many));
        Self { levels: levels.into(), given: None }
    }
}

impl ClothBudget {
    /// So many milliseconds a frame.
    pub fn new(milliseconds: f32) -> Self {
        Self { milliseconds, measured: 0.0, raised: 0, cloths: Vec::new() }
    }

    /// The time, where it can be used.
    pub(crate) fn time(&self) -> Option<f32> {
        (self.milliseconds > 0.0).then_some(self.milliseconds)
    }
}

impl ClothLod {
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        let mut before = 0.0;
        for level in &self.levels {
            if !(level.distance > before && level.distance.is_finite()) {
                let range = "finite, above 0 and above that of the level before";
                return Err(ParameterError { name: "distance", value: level.distance, range });
            }
            before = level.distance;
            if let Some(substeps) = level.substeps {
                Settings::from(ClothSettings { substeps, ..default() }).validate()?;
            }
        }
        Ok(())
    }
}
