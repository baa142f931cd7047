//! The wind that cloths feel.

use bevy::prelude::*;

use crate::solver::{Gusts, Wind, Zone};

/// The wind for all cloths that have [`ClothAir`](crate::ClothAir). Still air unless it is set.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # use bevy_drape::solver::Gusts;
/// let breeze = ClothWind::steady(Vec3::X * 4.0);
/// let weather = breeze.with_gusts(Gusts { strength: 3.0, seed: 7, ..default() });
/// # App::new().insert_resource(weather);
/// ```
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Resource, Default, Debug, PartialEq, Clone)]
pub struct ClothWind {
    /// Velocity of the steady wind [m/s]. Longer blows harder.
    pub velocity: Vec3,
    /// Gusts on top of it. The same seed in the same tick gives the same bits.
    pub gusts: Gusts,
}

impl ClothWind {
    /// A wind without gusts [m/s].
    pub fn steady(velocity: Vec3) -> Self {
        Self { velocity, ..default() }
    }

    /// With these gusts.
    pub fn with_gusts(self, gusts: Gusts) -> Self {
        Self { gusts, ..self }
    }

    /// The wind at a time \[s\].
    pub(crate) fn at<'a>(&self, time: f64, zones: &'a [Zone]) -> Wind<'a> {
        Wind { velocity: self.velocity, gusts: self.gusts, time, zones }
    }
}

/// The wind for this cloth, in place of [`ClothWind`]. Zones add to it all the same.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Deref, DerefMut)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Debug, PartialEq, Clone)]
pub struct ClothWindOverride(pub ClothWind);
