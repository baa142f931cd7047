//! Writes a cloth's mesh, once a frame and in place, and not at all while nothing moved.
//!
//! | file | what it does |
//! | --- | --- |
//! | here | looks which cloths look different |
//! | `place` | where all particles are, with what holds and leads them |
//! | `carried` | where a drawn shape is that another carries |
//! | `write` | positions, normals and tangents into the mesh asset |

mod carried;
mod place;
mod write;

use bevy::camera::primitives::{Aabb, Frustum};
use bevy::math::Affine3A;
use bevy::prelude::*;
use bevy::time::Fixed;
use bevy_drape_core::surface::has_moved;

use crate::cloth::settings::ClothInterpolation;
use crate::drawing::place::place;
use crate::drawing::write::write;
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::mesh::drawn::{ClothMesh, Drawn};
use crate::pose::pose_now;
use crate::pose::skeleton::Joints;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Attachments;
use crate::simulation::skin::Skin;
use crate::solver::Pose;

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
