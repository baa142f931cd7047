//! The wind: one for the world, another for a cloth that wants it, and zones on top.

mod zone;

pub use zone::WindZone;

pub(crate) use zone::{WindZones, forget_zone, gather_zones};

use crate::{
    cloth::{ClothAir, ClothSimulation},
    error::{Blame, ClothError, Failures},
    solver::{Air, Gusts, ParameterError, Wind, Zone},
};
use bevy::prelude::*;

/// The wind for all cloths that have [`ClothAir`]. Still air unless it is set.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
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
    /// What comes and goes, on top of it. The same seed in the same tick is the same to the bit.
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

/// Takes the air of each cloth, and its wind.
pub(crate) fn gather_air(
    mut cloths: Query<(
        Entity,
        &mut ClothSimulation,
        Option<&ClothAir>,
        Option<&ClothWindOverride>,
    )>,
    wind: Option<Res<ClothWind>>,
    zones: Res<WindZones>,
    time: Res<Time>,
    mut failures: Failures,
) {
    let wind = wind.as_deref().copied().unwrap_or_default();
    for (entity, mut cloth, air, own) in &mut cloths {
        let cloth = &mut *cloth;
        match set_air(cloth, air.map(|air| Air::from(*air))) {
            Ok(changed) => {
                failures.clear(entity, Blame::Air);
                if changed {
                    cloth.rest.disturb();
                }
                if changed && cloth.quarantined {
                    cloth.quarantined = false;
                    failures.clear(entity, Blame::Motion);
                }
            }
            Err(problem) => {
                let component = "ClothAir";
                failures.report(entity, ClothError::Parameter { entity, component, problem });
            }
        }
        if air.is_some() {
            let wind = own.map_or(wind, |own| own.0);
            cloth.step.set_wind(wind, time.elapsed_secs_f64());
            if blows(&wind, zones.get(), cloth.solver.bounds()) {
                // In wind nothing rests.
                cloth.rest.disturb();
            }
        }
    }
}

/// Whether there is any wind in a box, given by its corners.
fn blows(wind: &ClothWind, zones: &[Zone], place: (Vec3, Vec3)) -> bool {
    let everywhere = wind.velocity != Vec3::ZERO || wind.gusts.strength != 0.0;
    everywhere || zones.iter().any(|zone| zone.reaches(place))
}

/// Tells whether it is other air than before.
fn set_air(cloth: &mut ClothSimulation, air: Option<Air>) -> Result<bool, ParameterError> {
    let changed = cloth.solver.air().copied() != air;
    if changed {
        cloth.solver.set_air(air)?;
    }
    Ok(changed)
}
