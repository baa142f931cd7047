//! Changed components change a running cloth.

use bevy::prelude::*;

use crate::cloth::material::ClothMaterial;
use crate::cloth::settings::ClothSettings;
use crate::cloth::weights::ClothWeights;
use crate::error::failures::{Blame, Failures};
use crate::error::{ClothComponent, ClothErrorKind};
use crate::mesh::rest_cache::RestCache;
use crate::simulation::ClothSimulation;
use crate::simulation::complaints::solver_error;
use crate::simulation::setup::in_force;
use crate::simulation::shaping::topology;
use crate::solver::{ClothSolver, SolverError};

/// Applies changed materials, settings and weights. Numbers out of range are refused, the last good
/// ones stay.
pub(crate) fn apply_changes(
    mut cloths: Query<(
        Entity,
        Option<Ref<ClothMaterial>>,
        Option<Ref<ClothSettings>>,
        Option<Ref<ClothWeights>>,
        &mut ClothSimulation,
    )>,
    mut cache: ResMut<RestCache>,
    mut failures: Failures,
) {
    for (entity, material, settings, weights, mut cloth) in &mut cloths {
        // What was taken away is looked at until it has no effect any more.
        let gone = |differs: bool, blame| differs || failures.blames(entity, blame);
        let material_changed = match &material {
            Some(material) => material.is_changed(),
            None => gone(
                cloth.in_force.material != ClothMaterial::default(),
                Blame::Component(ClothComponent::ClothMaterial),
            ),
        };
        let settings_changed = match &settings {
            Some(settings) => settings.is_changed(),
            None => gone(
                cloth.in_force.settings != cloth.lod.settings(ClothSettings::default()),
                Blame::Component(ClothComponent::ClothSettings),
            ),
        };
        let weights_changed = match &weights {
            Some(weights) => weights.is_changed(),
            None => gone(cloth.in_force.weights.is_some(), Blame::Weights),
        };
        let settings = cloth.lod.settings(in_force(&settings));
        let level_changed = cloth.lod.take_changed();
        if !(material_changed || settings_changed || level_changed || weights_changed) {
            continue;
        }
        let material = in_force(&material);
        let cloth = &mut *cloth;
        let mut changed = false;
        let outcome = apply_material(cloth, material, &mut changed).map_err(solver_error);
        failures.tell(entity, Blame::Component(ClothComponent::ClothMaterial), outcome);
        let outcome = apply_settings(cloth, settings, &mut cache, &mut changed);
        failures.tell(entity, Blame::Component(ClothComponent::ClothSettings), outcome);
        let outcome = apply_weights(cloth, weights.as_deref(), &mut cache, &mut changed);
        failures.tell(entity, Blame::Weights, outcome);
        // More or fewer substeps move nothing that is at rest.
        if changed && (material_changed || settings_changed || weights_changed) {
            cloth.wake();
        }
        if changed && cloth.progress.quarantined {
            cloth.progress.quarantined = false;
            failures.clear(entity, Blame::Motion);
        }
    }
}

fn apply_material(
    cloth: &mut ClothSimulation,
    material: ClothMaterial,
    changed: &mut bool,
) -> Result<(), SolverError> {
    if material != cloth.in_force.material {
        cloth.solver.set_material(material.into())?;
        cloth.in_force.material = material;
        *changed = true;
    }
    Ok(())
}

fn apply_settings(
    cloth: &mut ClothSimulation,
    settings: ClothSettings,
    cache: &mut RestCache,
    changed: &mut bool,
) -> Result<(), ClothErrorKind> {
    if settings != cloth.in_force.settings {
        if settings.masses == cloth.in_force.settings.masses {
            cloth.solver.set_settings(settings.into()).map_err(solver_error)?;
        } else {
            let weights = cloth.in_force.weights.as_ref();
            cloth.solver = remade(cloth, settings, weights, cache)?;
        }
        cloth.in_force.settings = settings;
        *changed = true;
    }
    Ok(())
}

fn apply_weights(
    cloth: &mut ClothSimulation,
    weights: Option<&ClothWeights>,
    cache: &mut RestCache,
    changed: &mut bool,
) -> Result<(), ClothErrorKind> {
    if weights != cloth.in_force.weights.as_ref() {
        cloth.solver = remade(cloth, cloth.in_force.settings, weights, cache)?;
        cloth.in_force.weights = weights.cloned();
        *changed = true;
    }
    Ok(())
}

/// The solver over a rest shape of other masses or weights, in the same place and motion.
fn remade(
    cloth: &ClothSimulation,
    settings: ClothSettings,
    weights: Option<&ClothWeights>,
    cache: &mut RestCache,
) -> Result<ClothSolver, ClothErrorKind> {
    let scale = cloth.in_force.placed.scale;
    let topology = topology(&cloth.in_force.rest_shape, scale, settings.masses, weights, cache)?;
    cloth.solver.remade(topology, settings.into()).map_err(solver_error)
}
