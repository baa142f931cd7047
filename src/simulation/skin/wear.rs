//! Cloths follow their skins until they begin; changed limits are applied, and changed sizes.

use bevy::prelude::*;

use crate::cloth::skin::ClothSkin;
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::error::skin::SkinProblem;
use crate::mesh::drawn::ClothMesh;
use crate::mesh::rest_cache::RestCache;
use crate::mesh::source::{MeshSource, source_of};
use crate::simulation::ClothSimulation;
use crate::simulation::complaints::solver_error;
use crate::simulation::holding::hold_anew;
use crate::simulation::in_force::OTHER_SIZE;
use crate::simulation::resizing::{ask_for_layers_again, in_size};
use crate::simulation::skin::make::{Skins, limit};
use crate::solver::SkinLimit;

/// Change that is too much for threads to take up.
const LEAP: f32 = 0.1;

/// Keeps cloths in the limits that their components ask for, in the size of their skeletons, and, until they begin, where their skins are.
pub(crate) fn wear_skins(
    mut cloths: Query<(
        Entity,
        Ref<ClothSkin>,
        Option<&Mesh3d>,
        Option<&ClothMesh>,
        &mut ClothSimulation,
    )>,
    skins: Skins,
    mut meshes: MeshSource,
    mut cache: ResMut<RestCache>,
    mut failures: Failures,
) {
    for (entity, asked, mesh3d, own, mut cloth) in &mut cloths {
        let cloth = &mut *cloth;
        if cloth.skin.is_none() {
            continue;
        }
        let is_other = cloth.in_force.skin.as_ref() != Some(&*asked);
        if asked.is_changed() && (is_other || failures.blames(entity, Blame::Skin)) {
            let source = source_of(mesh3d, own);
            let outcome = limit_anew(cloth, &asked, &skins, &meshes, source);
            if let (Ok(()), Some(own)) = (&outcome, own) {
                meshes.show_colors(own, !asked.hides_colors());
            }
            failures.tell(entity, Blame::Skin, outcome);
        }
        match resize(cloth, &mut cache) {
            Ok(true) => ask_for_layers_again(entity, &mut failures),
            Ok(false) => {}
            Err(problem) => failures.report(entity, problem),
        }
        start_at_skin(entity, cloth, &skins, &mut failures);
    }
}

fn limit_anew(
    cloth: &mut ClothSimulation,
    asked: &ClothSkin,
    skins: &Skins,
    meshes: &MeshSource,
    source: Option<&Handle<Mesh>>,
) -> Result<(), ClothErrorKind> {
    let problem = |problem| ClothErrorKind::Skin(SkinProblem::Mesh(problem));
    let Some(mesh) = meshes.get(source).map_err(problem)? else { return Ok(()) };
    let Some(mut skin) = cloth.skin.take() else { return Ok(()) };
    let shapes = (&cloth.in_force.rest_shape, cloth.drawn_shape());
    let scale = cloth.in_force.placed.scale;
    let limits = skins.limits(asked, &skin, mesh, shapes, scale).map_err(ClothErrorKind::Skin);
    let outcome = limits.and_then(|limits| limit(cloth, &mut skin, &limits));
    cloth.skin = Some(skin);
    outcome?;
    cloth.in_force.skin = Some(asked.clone());
    hold_anew(cloth);
    Ok(())
}

/// Gives the cloth another size, where its skeleton has. Tells whether it did.
fn resize(cloth: &mut ClothSimulation, cache: &mut RestCache) -> Result<bool, ClothErrorKind> {
    let Some(skin) = &cloth.skin else { return Ok(false) };
    let before = cloth.in_force.placed.scale;
    // An uneven one is told in the tick, and the cloth keeps its size.
    let Ok(scale) = skin.scale() else { return Ok(false) };
    let ratio = scale / before;
    if (ratio - 1.0).abs() <= OTHER_SIZE {
        return Ok(false);
    }
    let mut solver = in_size(cloth, scale, cache)?;
    let larger = |limit: &SkinLimit| limit.scaled(ratio);
    let limits: Vec<_> = solver.skin().unwrap_or_default().iter().map(larger).collect();
    solver.set_skin(Some(&limits)).map_err(solver_error)?;
    if (ratio - 1.0).abs() > LEAP {
        let about = |(i, place): (usize, &Vec3)| place + (solver.position(i) - place) * ratio;
        let places: Vec<_> = skin.places().iter().enumerate().map(about).collect();
        solver.place(&places).map_err(solver_error)?;
        cloth.shape_version += 1;
    }
    cloth.solver = solver;
    cloth.in_force.placed.scale = scale;
    cloth.wake();
    Ok(true)
}

/// Puts a cloth that has not begun where its skin is.
fn start_at_skin(
    entity: Entity,
    cloth: &mut ClothSimulation,
    skins: &Skins,
    failures: &mut Failures,
) {
    if cloth.progress.tick_count > 0 || cloth.is_culled() {
        return;
    }
    let ClothSimulation { skin: Some(skin), solver, shape_version, start, .. } = cloth else {
        return;
    };
    if skin.start_anew(&skins.joints) {
        start.is_held = false;
        if let Err(problem) = solver.place(skin.places()) {
            failures.report(entity, ClothErrorKind::Solver(problem));
        }
        *shape_version += 1;
    }
}
