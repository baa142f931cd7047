//! A running cloth follows the scale of its entity.

use bevy::prelude::*;

use crate::error::ClothErrorKind;
use crate::error::failures::Failures;
use crate::mesh::rest_cache::RestCache;
use crate::pose::{PoseTrack, pose_now};
use crate::simulation::ClothSimulation;
use crate::simulation::complaints::{scale_at_fault, solver_error};
use crate::simulation::setup::topology;
use crate::solver::Pose;

/// Change of the scale from which on a cloth gets another size \[1\].
pub(crate) const OTHER_SIZE: f32 = 0.01;

/// Gives cloths the size that the scale of their entities asks for. Worn ones have that of their skeleton.
pub(crate) fn follow_scales(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    transforms: TransformHelper,
    mut cache: ResMut<RestCache>,
    mut failures: Failures,
) {
    for (entity, mut cloth) in &mut cloths {
        if cloth.progress.tick_count == 0 || cloth.skin.is_some() || cloth.is_culled() {
            continue;
        }
        // A scale that cannot be used is told in the tick, and the cloth keeps its size.
        let Ok(pose) = pose_now(&transforms, entity) else { continue };
        let ratio = pose.scale / cloth.in_force.placed.scale;
        if (ratio - 1.0).abs() > OTHER_SIZE
            && let Err(problem) = resize(&mut cloth, entity, pose, &mut cache)
        {
            failures.report(entity, problem);
        }
    }
}

/// Gives a cloth another size: about its entity if anything holds it, about its middle if not. It moves on, as much faster.
fn resize(
    cloth: &mut ClothSimulation,
    entity: Entity,
    pose: Pose,
    cache: &mut RestCache,
) -> Result<(), ClothErrorKind> {
    let scale = pose.scale;
    let ratio = scale / cloth.in_force.placed.scale;
    let (shape, weights) = (&cloth.in_force.rest_shape, cloth.in_force.weights.as_ref());
    let settings = cloth.in_force.settings;
    let topology = topology(shape, scale, settings.masses, weights, cache)
        .map_err(|error| scale_at_fault(error, scale))?;
    let mut solver = cloth.solver.remade(topology, settings.into()).map_err(solver_error)?;
    let particles = 0..solver.topology().particle_count();
    let places: Vec<_> = particles.clone().map(|i| solver.position(i)).collect();
    let velocities: Vec<_> = particles.map(|i| solver.velocity(i) * ratio).collect();
    let is_held = !cloth.pinned().is_empty();
    let middle = || places.iter().sum::<Vec3>() / places.len() as f32;
    let about = if is_held { pose.translation } else { middle() };
    let places: Vec<_> = places.iter().map(|place| about + (place - about) * ratio).collect();
    solver.place(&places).map_err(ClothErrorKind::Solver)?;
    for (particle, velocity) in velocities.into_iter().enumerate() {
        solver.set_velocity(particle, velocity).map_err(ClothErrorKind::Solver)?;
    }
    cloth.solver = solver;
    // What it holds itself is where it is put, and is not led there in the tick.
    let anchors = cloth.held.attachments.anchors.iter_mut();
    for anchor in anchors.filter(|anchor| anchor.entity == entity) {
        anchor.pose = PoseTrack::new(pose);
    }
    cloth.in_force.placed.scale = scale;
    cloth.shape_version += 1;
    cloth.wake();
    Ok(())
}
