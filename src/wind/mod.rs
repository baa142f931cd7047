//! The wind: one for the world, another for a cloth that wants it, and zones on top.

pub(crate) mod zone;

use bevy::prelude::*;

use crate::cloth::air::ClothAir;
use crate::cloth::wind::{ClothWind, ClothWindOverride};
use crate::error::ClothComponent;
use crate::error::failures::{Blame, Failures};
use crate::simulation::ClothSimulation;
use crate::solver::{Air, ParameterError, Zone};
use crate::wind::zone::WindZones;

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
        let changed = set_air(cloth, air.map(|air| Air::from(*air)));
        if changed == Ok(true) {
            cloth.sleep.disturb();
            if core::mem::take(&mut cloth.progress.quarantined) {
                failures.clear(entity, Blame::Motion);
            }
        }
        failures.tell_numbers(entity, ClothComponent::ClothAir, changed.map(drop));
        if air.is_some() {
            let wind = own.map_or(wind, |own| own.0);
            cloth.tick.step.set_wind(wind, time.elapsed_secs_f64());
            if blows(&wind, zones.get(), cloth.solver.bounds()) {
                // In wind nothing rests.
                cloth.sleep.disturb();
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
