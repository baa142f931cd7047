//! Writes a cloth's mesh, once a frame and in place, and not at all while nothing moved.

use bevy::camera::primitives::{Aabb, Frustum};
use bevy::math::{Affine3A, Mat3A};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::Fixed;
use bevy_drape_core::surface::{Placing, Tangents, has_moved};

use crate::cloth::settings::ClothInterpolation;
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::error::problems::MeshProblem;
use crate::mesh::drawn::{ClothMesh, Drawn};
use crate::mesh::intake::NormalPlan;
use crate::mesh::rest_shape::RestShape;
use crate::pose::skeleton::Joints;
use crate::pose::{pose_now, pose_of, to_world};
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Attachments;
use crate::simulation::skin::Skin;
use crate::solver::{Pose, RigidMotion};

/// Largest displacement that is not worth a write, as a part of the cloth's half extent. Above the
/// rounding noise of a cloth at rest, far below a pixel. It is taken from what was last written, so
/// nothing drifts.
const UNSEEN: f32 = 1e-5;

/// Draws all cloths that have moved.
pub(crate) fn draw_cloths(
    mut cloths: Query<(
        Entity,
        &ClothSimulation,
        &mut ClothMesh,
        Option<&ClothInterpolation>,
        Option<&mut Aabb>,
    )>,
    transforms: TransformHelper,
    joints: Joints,
    views: Query<(&Camera, &Frustum)>,
    meshes: Option<ResMut<Assets<Mesh>>>,
    time: Option<Res<Time<Fixed>>>,
    mut failures: Failures,
) {
    let Some(mut meshes) = meshes else {
        return;
    };
    let overstep = time.map_or(1.0, |time| time.overstep_fraction().min(1.0));
    for (entity, cloth, mut own, interpolation, aabb) in &mut cloths {
        let own = &mut *own;
        let Ok(global) = transforms.compute_global_transform(entity) else {
            continue;
        };
        if cloth.is_culled()
            && let Some(bounds) = cloth.culled_bounds(&transforms, &global.affine())
            && !may_be_seen(&bounds, &global.affine(), &views)
        {
            if let Some(mut aabb) = aabb {
                *aabb = bounds;
            }
            continue;
        }
        let blend = match interpolation.copied().unwrap_or_default() {
            ClothInterpolation::Blend => overstep,
            ClothInterpolation::LastTick => 1.0,
        };
        let now = Drawn {
            tick: cloth.progress.tick_count,
            version: cloth.shape_version,
            blend,
            transform: global.affine(),
            settled: !cloth.solver.has_moved(),
        };
        let anchors_moved = note_anchors(&cloth.held.attachments, &mut own.anchors, &transforms);
        let skin_moved = cloth.skin.as_ref().is_some_and(|skin| note_joints(skin, own, &joints));
        if !anchors_moved && !skin_moved && !looks_different(own.drawn, now) {
            continue;
        }
        let Some(bounds) = place(cloth, own, now) else {
            continue;
        };
        let first = own.drawn.replace(now).is_none();
        if !first && !visibly_moved(own, bounds) {
            continue;
        }
        match write(own, &mut meshes) {
            Ok(()) => {
                if let Some(mut aabb) = aabb {
                    *aabb = bounds;
                }
                failures.clear(entity, Blame::Drawing);
            }
            Err(problem) => failures.report(entity, ClothErrorKind::Draw(problem)),
        }
    }
}

/// Whether any camera looks there.
fn may_be_seen(bounds: &Aabb, frame: &Affine3A, views: &Query<(&Camera, &Frustum)>) -> bool {
    let mut active = views.iter().filter(|(camera, _)| camera.is_active);
    active.any(|(_, frustum)| frustum.intersects_obb(bounds, frame, true, true))
}

/// Whether any point is elsewhere than it was last written.
fn visibly_moved(own: &ClothMesh, bounds: Aabb) -> bool {
    let tolerance = UNSEEN * bounds.half_extents.max_element();
    has_moved(&own.points, &own.written, tolerance)
}

fn looks_different(drawn: Option<Drawn>, now: Drawn) -> bool {
    drawn.is_none_or(|drawn| {
        let same_instant = drawn.tick == now.tick && drawn.blend == now.blend;
        let still = drawn.settled && now.settled;
        let same_place = drawn.version == now.version && drawn.transform == now.transform;
        !same_place || !(same_instant || still)
    })
}

/// Looks where the anchors are now; true if one has moved since the last frame. The cloth's own entity
/// is left out: its transform is looked at anyway.
fn note_anchors(
    attachments: &Attachments,
    seen: &mut Vec<Option<Pose>>,
    transforms: &TransformHelper,
) -> bool {
    seen.resize(attachments.anchors.len(), None);
    let mut moved = false;
    for (anchor, seen) in attachments.anchors.iter().zip(seen) {
        let is_own = attachments.own_entity == Some(anchor.entity);
        let now = if is_own { None } else { pose_now(transforms, anchor.entity).ok() };
        moved |= now != *seen;
        *seen = now;
    }
    moved
}

/// Looks where the joints of a skin are now; true if one has moved since the last frame.
fn note_joints(skin: &Skin, own: &mut ClothMesh, joints: &Joints) -> bool {
    let before = core::mem::take(&mut own.joints.matrices);
    // A joint that is gone is told of in the tick, and stays.
    let _ = joints.look(&skin.skeleton, &mut own.joints);
    before != own.joints.matrices
}

/// Puts all particles in the entity's frame, and tells their bounds; nothing where that frame is
/// flat, or nowhere: the mesh then stays as it was.
fn place(cloth: &ClothSimulation, own: &mut ClothMesh, now: Drawn) -> Option<Aabb> {
    let inverse = now.transform.matrix3.inverse();
    if !inverse.is_finite() {
        return None;
    }
    let solver = &cloth.solver;
    // The cloth's origin is near: far from the world's, the difference is exact where the sum is
    // not.
    let offset = solver.origin() - Vec3::from(now.transform.translation);
    let attachments = &cloth.held.attachments;
    let along = match &cloth.skin {
        // Each particle goes along with its own place on the skin.
        Some(_) => None,
        None => moved_since(attachments, &own.anchors, now, cloth.is_culled()),
    };
    // From the cloth's coordinates to the world's axes, and from there into the entity's frame.
    let (turn, shift) = match along {
        Some(motion) => {
            let lever = motion.rotation * (solver.origin() - motion.pivot);
            let pivot = motion.pivot - Vec3::from(now.transform.translation);
            (Mat3A::from_quat(motion.rotation), lever + (pivot + motion.shift))
        }
        None => (Mat3A::IDENTITY, offset),
    };
    let (turn, shift) = (inverse * turn, inverse * shift);
    if !(turn.is_finite() && shift.is_finite()) {
        return None;
    }
    let placing = Placing { blend: now.blend, turn: turn.into(), shift };
    placing.write(solver, &mut own.points);
    if let Some(skin) = &cloth.skin {
        let origin = Vec3::from(now.transform.translation);
        let to_frame = |vector: Vec3| inverse * vector;
        let ClothMesh { joints, points, anchors, .. } = &mut *own;
        let leader = cloth.held.attachments.reference().and_then(|leader| anchors[leader]);
        let along = leader.filter(|_| cloth.is_culled()).and_then(|now| cloth.carried_to(&now));
        match along {
            Some(along) => skin.draw_culled(solver, &joints.matrices, &along, |i, place| {
                points[i] = to_frame(place - origin);
            }),
            None => skin.draw(&joints.matrices, now.blend, origin, to_frame, points),
        }
    }
    place_pinned(&cloth.held.attachments, own, now, &inverse);
    let bounds = Aabb::enclosing(&own.points)?;
    (bounds.center.is_finite() && bounds.half_extents.is_finite()).then_some(bounds)
}

/// Motion of the anchor that leads the cloth since the instant that is drawn: the whole cloth is
/// drawn as much further, so that it does not lag behind its own pinned edge. `None` where the anchor
/// has not moved, or holds nothing hard while it does not have to (`leads`): the cloth is drawn where it is.
fn moved_since(
    attachments: &Attachments,
    seen: &[Option<Pose>],
    now: Drawn,
    leads: bool,
) -> Option<RigidMotion> {
    let reference = attachments.reference()?;
    let anchor = &attachments.anchors[reference];
    let drawn = if attachments.own_entity == Some(anchor.entity) {
        pose_of(&now.transform.into()).ok()
    } else {
        seen[reference]
    };
    let drawn = drawn?;
    let instant = anchor.pose.start().interpolate(&anchor.pose.end(), now.blend);
    let moved = (leads || anchor.holds > 0) && instant != drawn;
    moved.then(|| RigidMotion::between(&instant, &drawn))
}

/// Pinned vertices go where their anchors are drawn.
fn place_pinned(attachments: &Attachments, own: &mut ClothMesh, now: Drawn, inverse: &Mat3A) {
    for pin in &attachments.attached {
        let anchor = &attachments.anchors[pin.anchor as usize];
        let point = &mut own.points[pin.particle as usize];
        match own.anchors[pin.anchor as usize] {
            Some(pose) => {
                let far = to_world(&pose, pin.local) - Vec3::from(now.transform.translation);
                let place = *inverse * far;
                if place.is_finite() {
                    *point = place;
                }
            }
            None if attachments.own_entity == Some(anchor.entity) => *point = pin.local,
            // The anchor is gone, and the next tick will let go.
            None => {}
        }
    }
}

fn write(own: &mut ClothMesh, meshes: &mut Assets<Mesh>) -> Result<(), MeshProblem> {
    let mut mesh = meshes.get_mut(&own.handle).ok_or(MeshProblem::Changed)?;
    let count = own.rest.vertex_count();
    // Looked at first: the asset counts as modified as soon as it is borrowed mutably.
    for attribute in [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL] {
        let values = mesh.try_attribute_option(attribute)?.ok_or(MeshProblem::Changed)?;
        if values.len() != count || !matches!(values, VertexAttributeValues::Float32x3(_)) {
            return Err(MeshProblem::Changed);
        }
    }
    let mesh = &mut *mesh;
    if own.tangents.is_none() {
        let is_sheet = matches!(own.rest, RestShape::Sheet { .. });
        let tangents = if is_sheet { None } else { take_tangents(mesh).map(Box::new) };
        own.tangents = Some(tangents);
    }
    if let VertexAttributeValues::Float32x3(out) =
        mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION)?
    {
        write_positions(own, out);
    }
    if let VertexAttributeValues::Float32x3(out) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_NORMAL)? {
        write_normals(own, out);
    }
    if let Some(Some(tangents)) = &mut own.tangents {
        write_tangents(tangents, mesh)?;
    }
    own.written.copy_from_slice(&own.points);
    Ok(())
}

/// The tangents of a mesh that has not been written yet; `None` where it has none, or none that can be used.
fn take_tangents(mesh: &Mesh) -> Option<Tangents> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return None;
    }
    let attribute = |which| mesh.try_attribute_option(which).ok().flatten();
    let VertexAttributeValues::Float32x4(tangents) = attribute(Mesh::ATTRIBUTE_TANGENT)? else {
        return None;
    };
    let VertexAttributeValues::Float32x3(places) = attribute(Mesh::ATTRIBUTE_POSITION)? else {
        return None;
    };
    let corners: Vec<u32> = match mesh.try_indices_option().ok()? {
        Some(Indices::U16(indices)) => indices.iter().map(|&index| index.into()).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..places.len() as u32).collect(),
    };
    Some(Tangents::new(places, tangents, &corners))
}

fn write_tangents(tangents: &mut Tangents, mesh: &mut Mesh) -> Result<(), MeshProblem> {
    // Taken out, to be written while positions and normals are read.
    let Ok(VertexAttributeValues::Float32x4(mut out)) =
        mesh.try_remove_attribute(Mesh::ATTRIBUTE_TANGENT)
    else {
        return Err(MeshProblem::Changed);
    };
    let read = |which| match mesh.try_attribute_option(which)? {
        Some(VertexAttributeValues::Float32x3(values)) => Ok(values),
        _ => Err(MeshProblem::Changed),
    };
    let (places, normals) = (read(Mesh::ATTRIBUTE_POSITION)?, read(Mesh::ATTRIBUTE_NORMAL)?);
    if out.len() == places.len() {
        tangents.write(places, normals, &mut out);
    }
    mesh.try_insert_attribute(Mesh::ATTRIBUTE_TANGENT, out)?;
    Ok(())
}

fn write_positions(own: &ClothMesh, out: &mut [[f32; 3]]) {
    match &own.rest {
        RestShape::Sheet { .. } => {
            for (out, point) in out.iter_mut().zip(&own.points) {
                *out = point.to_array();
            }
        }
        RestShape::Mesh(shape) => {
            for (out, &particle) in out.iter_mut().zip(&shape.particle_of_vertex) {
                *out = own.points[particle as usize].to_array();
            }
        }
    }
}

fn write_normals(own: &mut ClothMesh, out: &mut [[f32; 3]]) {
    let ClothMesh { rest, points, cells, sums, .. } = own;
    match rest {
        RestShape::Sheet { .. } => {
            cells.write(points, None, out);
        }
        RestShape::Mesh(shape) => match &shape.normals {
            NormalPlan::Grid { vertex_of_particle, .. } => {
                cells.write(points, vertex_of_particle.as_deref(), out);
            }
            NormalPlan::Groups(groups) => groups.write(points, sums, out),
        },
    }
}
