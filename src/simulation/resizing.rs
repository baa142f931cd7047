//! A running cloth follows the scale of its entity.

use bevy::prelude::*;

use crate::error::failures::{Blame, Failures};
use crate::error::{ClothComponent, ClothErrorKind};
use crate::mesh::rest_cache::RestCache;
use crate::pose::pose_now;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Attachments;
use crate::simulation::complaints::{scale_at_fault, solver_error};
use crate::simulation::in_force::OTHER_SIZE;
use crate::simulation::shaping::topology;
use crate::solver::ClothSolver;

/// Gives cloths the size that the scale of their entities asks for. Worn ones have that of their skeleton.
pub(crate) fn follow_scales(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    transforms: TransformHelper,
    mut cache: ResMut<RestCache>,
    mut failures: Failures,
) {
    for (entity, mut cloth) in &mut cloths {
        if let Some(scale) = other_scale(entity, &cloth, &transforms) {
            follow_scale(entity, &mut cloth, scale, &transforms, &mut cache, &mut failures);
        }
    }
}

/// The scale of an entity, where its cloth is to follow that and does not have it.
pub(crate) fn other_scale(
    entity: Entity,
    cloth: &ClothSimulation,
    transforms: &TransformHelper,
) -> Option<f32> {
    let has_begun = cloth.progress.tick_count > 0 || cloth.start.has_begun();
    if !has_begun || cloth.is_hanging() || cloth.skin.is_some() || cloth.is_culled() {
        return None;
    }
    // One that cannot be used is told in the tick, and the cloth keeps its size.
    let scale = pose_now(transforms, entity).ok()?.scale;
    ((scale / cloth.in_force.placed.scale - 1.0).abs() > OTHER_SIZE).then_some(scale)
}

/// Gives a cloth another scale, and its anchors their places.
pub(crate) fn follow_scale(
    entity: Entity,
    cloth: &mut ClothSimulation,
    scale: f32,
    transforms: &TransformHelper,
    cache: &mut RestCache,
    failures: &mut Failures,
) {
    let ratio = scale / cloth.in_force.placed.scale;
    match resize(cloth, scale, cache) {
        Ok(about) => {
            scale_anchors(&mut cloth.held.attachments, transforms, about, ratio);
            ask_for_layers_again(entity, failures);
        }
        Err(problem) => failures.report(entity, problem),
    }
}

/// The cloth's solver over its rest shape in another size, in the same place and motion.
pub(crate) fn in_size(
    cloth: &ClothSimulation,
    scale: f32,
    cache: &mut RestCache,
) -> Result<ClothSolver, ClothErrorKind> {
    let (shape, weights) = (&cloth.in_force.rest_shape, cloth.in_force.weights.as_ref());
    let settings = cloth.in_force.settings;
    let topology = topology(shape, scale, settings.masses, weights, cache)
        .map_err(|error| scale_at_fault(error, scale))?;
    cloth.solver.remade(topology, settings.into()).map_err(solver_error)
}

/// Lets a cloth of another size take its contact of layers from its components anew: a distance that one size does not allow may be
/// good in another.
pub(crate) fn ask_for_layers_again(entity: Entity, failures: &mut Failures) {
    for component in [ClothComponent::ClothSelfCollision, ClothComponent::ClothInterCollision] {
        failures.clear(entity, Blame::Component(component));
    }
}

/// Gives a cloth another size: about the anchor that leads it if anything holds it, about its middle if not. Its velocities relative to
/// their mean grow alike. Returns the place that it is scaled about.
fn resize(
    cloth: &mut ClothSimulation,
    scale: f32,
    cache: &mut RestCache,
) -> Result<Vec3, ClothErrorKind> {
    let ratio = scale / cloth.in_force.placed.scale;
    let mut solver = in_size(cloth, scale, cache)?;
    let particles = 0..solver.topology().particle_count();
    let places: Vec<_> = particles.clone().map(|i| solver.position(i)).collect();
    let velocities: Vec<_> = particles.map(|i| solver.velocity(i)).collect();
    let mean = |vectors: &[Vec3]| vectors.iter().sum::<Vec3>() / vectors.len() as f32;
    let about = held_about(&cloth.held.attachments).unwrap_or_else(|| mean(&places));
    let drift = mean(&velocities);
    let places: Vec<_> = places.iter().map(|place| about + (place - about) * ratio).collect();
    solver.place(&places).map_err(ClothErrorKind::Solver)?;
    for (particle, velocity) in velocities.into_iter().enumerate() {
        let velocity = drift + (velocity - drift) * ratio;
        solver.set_velocity(particle, velocity).map_err(ClothErrorKind::Solver)?;
    }
    cloth.solver = solver;
    cloth.in_force.placed.scale = scale;
    cloth.shape_version += 1;
    cloth.wake();
    Ok(about)
}

/// Where the anchor is that leads a cloth, if it is held at all.
fn held_about(attachments: &Attachments) -> Option<Vec3> {
    let is_held = !attachments.attached.is_empty() || !attachments.pulled.is_empty();
    let leading = attachments.reference().filter(|_| is_held)?;
    Some(attachments.anchors[leading].pose.end().translation)
}

/// Scales the ways of the anchors that have got the same scale, so that what they hold goes on from its new place. Those that keep theirs
/// hold particles where they held them.
fn scale_anchors(
    attachments: &mut Attachments,
    transforms: &TransformHelper,
    about: Vec3,
    ratio: f32,
) {
    let leading = attachments.reference().map(|leading| &attachments.anchors[leading].pose);
    let about_seen = leading.map_or(about, |pose| pose.seen().translation);
    for anchor in &mut attachments.anchors {
        let Ok(now) = pose_now(transforms, anchor.entity) else { continue };
        let own = now.scale / anchor.pose.end().scale;
        if (own / ratio - 1.0).abs() <= OTHER_SIZE {
            anchor.pose.scale([about, about_seen], own);
        }
    }
}
