//! Where the particles of a cloth are drawn, in the frame of its entity.

use bevy::camera::primitives::Aabb;
use bevy::math::{Mat3A, ops};
use bevy::prelude::*;
use bevy_drape_core::surface::{Placing, bounds};

use crate::drawing::carried::carry;
use crate::mesh::drawn::{ClothMesh, Drawn};
use crate::pose::{pose_of, to_world};
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::Attachments;
use crate::solver::{Pose, RigidMotion};

/// Puts all particles in the entity's frame, and tells their bounds; nothing where that frame is
/// flat, or nowhere: the mesh then stays as it was.
pub(super) fn place(cloth: &ClothSimulation, own: &mut ClothMesh, now: Drawn) -> Option<Aabb> {
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
    let origin = Vec3::from(now.transform.translation);
    let ClothMesh { carrier, points, joints, anchors, .. } = &mut *own;
    // What is simulated, which may carry what is drawn.
    let points = carrier.as_mut().map_or(points, |carrier| &mut carrier.points);
    placing.write(solver, points);
    if let Some(skin) = &cloth.skin {
        let to_frame = |vector: Vec3| inverse * vector;
        let leader = attachments.reference().and_then(|leader| anchors[leader]);
        let along = leader.filter(|_| cloth.is_culled()).and_then(|now| cloth.carried_to(&now));
        match along {
            Some(along) => skin.draw_culled(solver, &joints.matrices, &along, |i, place| {
                points[i] = to_frame(place - origin);
            }),
            None => skin.draw(&joints.matrices, now.blend, origin, to_frame, points),
        }
    }
    place_pinned(attachments, anchors, points, now, &inverse);
    let scale = ops::cbrt(inverse.determinant().abs());
    carry(cloth, own, scale, |place| inverse * (place - origin));
    let (least, greatest) = bounds(&own.points);
    let bounds = Aabb::from_min_max(least, greatest);
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
fn place_pinned(
    attachments: &Attachments,
    anchors: &[Option<Pose>],
    points: &mut [Vec3],
    now: Drawn,
    inverse: &Mat3A,
) {
    for pin in &attachments.attached {
        let anchor = &attachments.anchors[pin.anchor as usize];
        let point = &mut points[pin.particle as usize];
        match anchors[pin.anchor as usize] {
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
