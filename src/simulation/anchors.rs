//! Anchors through a tick: they lead what they hold, and a cloth may ride along or be reset with them.

use bevy::mesh::skinning::SkinnedMesh;
use bevy::prelude::*;

use crate::cloth::pins::ClothPins;
use crate::cloth::sleep::ClothPaused;
use crate::cloth::teleport::{ClothInertia, ClothTeleport};
use crate::error::failures::{Blame, Failures};
use crate::error::problems::PinProblem;
use crate::error::{ClothComponent, ClothErrorKind};
use crate::pose::frames::FrameTicks;
use crate::pose::root::Placed;
use crate::pose::skeleton::Joints;
use crate::pose::{PoseError, pose_now};
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::{Anchor, Attachments};
use crate::simulation::holding::hold;
use crate::simulation::reference_frame::ReferenceFrame;
use crate::solver::RigidMotion;

/// Notes where all anchors are before a frame's ticks. Tells how what leads the cloth has jumped, if it has.
pub(crate) fn note_anchors(
    attachments: &mut Attachments,
    frame: &ReferenceFrame,
    (transforms, joints): (&TransformHelper, &Joints),
    ticks: FrameTicks,
) -> Option<RigidMotion> {
    let reference = attachments.reference();
    let mut jump = None;
    for (i, anchor) in attachments.anchors.iter_mut().enumerate() {
        let Ok(now) = pose_now(transforms, anchor.entity) else { continue };
        let before = anchor.pose.seen();
        let root = joints.root(anchor.entity);
        anchor.pose.begin_frame(Placed { pose: now, root }, ticks);
        let jumps = frame.is_put_elsewhere() || frame.is_jump_of_frame(&before, &now, ticks.count);
        if jumps {
            anchor.pose.at_once();
            if reference == Some(i) {
                jump = Some(RigidMotion::between(&before, &now));
            }
        }
    }
    jump
}

/// Moves all anchors on by a tick, lets go of what lost its anchor, and lets cloths follow what leads
/// them.
pub(crate) fn gather_pins(
    mut cloths: Query<(
        Entity,
        &mut ClothSimulation,
        Option<&ClothTeleport>,
        Option<&ClothInertia>,
        Option<&ClothPaused>,
        Has<SkinnedMesh>,
    )>,
    transforms: TransformHelper,
    joints: Joints,
    mut failures: Failures,
) {
    for (entity, mut cloth, teleport, inertia, frozen, is_skinned) in &mut cloths {
        let cloth = &mut *cloth;
        if cloth.is_culled() {
            continue;
        }
        let outcome = cloth.frame.set_teleport(teleport);
        failures.tell_numbers(entity, ClothComponent::ClothTeleport, outcome);
        let outcome = cloth.frame.set_inertia(inertia);
        failures.tell_numbers(entity, ClothComponent::ClothInertia, outcome);
        let at_once = cloth.frame.is_put_elsewhere();
        if let Some(skin) = &mut cloth.skin {
            let (moves, outcome) = skin.advance(&joints, at_once);
            if moves {
                cloth.sleep.disturb();
            }
            let outcome = outcome.and_then(|()| skin.check_scale());
            // One that is to be taken over is looked at elsewhere, and may be what is told of.
            if !is_skinned || outcome.is_err() && !failures.blames(entity, Blame::Joints) {
                failures.tell(entity, Blame::Joints, outcome.map_err(ClothErrorKind::Skin));
            }
        }
        match advance_anchors(&mut cloth.held.attachments, (&transforms, &joints), at_once) {
            None if cloth.held.attachments.awaited.is_some() => {}
            None => failures.clear(entity, Blame::Pose),
            // It is told of as a joint.
            Some((anchor, _)) if is_only_leader(&cloth.held.attachments, anchor) => {}
            Some((anchor, PoseError::Scale(scale))) if anchor == entity => {
                failures.report(entity, ClothErrorKind::Scale(scale));
            }
            Some((anchor, error))
                if anchor == entity && cloth.held.attachments.holds_nothing_at(anchor) =>
            {
                failures.report(entity, error.into());
            }
            Some((anchor, error)) => {
                let pin = pin_held_by(&cloth.in_force.pins, entity, anchor);
                let problem = match error {
                    PoseError::Scale(problem) => PinProblem::AnchorScale { anchor, problem },
                    PoseError::Missing => PinProblem::NoAnchor(anchor),
                };
                failures.report(entity, ClothErrorKind::Pin { pin, problem });
                if error == PoseError::Missing {
                    release(cloth, anchor);
                }
            }
        }
        let stands = cloth.is_hanging() || frozen.is_some_and(|frozen| frozen.steps == 0);
        follow(entity, cloth, stands, &mut failures);
        cloth.settle_in();
    }
}

/// Carries the cloth where its reference has jumped, or resets it. One that `stands` is carried by
/// every motion.
fn follow(entity: Entity, cloth: &mut ClothSimulation, stands: bool, failures: &mut Failures) {
    let ClothSimulation { held, skin, frame, solver, sleep, .. } = cloth;
    let attachments = &mut held.attachments;
    let Some(reference) = attachments.reference() else { return };
    let anchors = &mut attachments.anchors;
    let leads = |(i, anchor): (usize, &Anchor)| {
        (i == reference || anchor.holds + anchor.pulls > 0) && anchor.pose.moves()
    };
    if anchors.iter().enumerate().any(leads) {
        sleep.disturb();
    }
    if let Some(motion) = frame.follow(anchors, reference, stands) {
        let (from, to) = (anchors[reference].pose.start(), anchors[reference].pose.end());
        for anchor in anchors.iter_mut() {
            anchor.pose.come_from(motion.apply_to_pose(&anchor.pose.start()));
        }
        if let Some(skin) = skin {
            skin.carry(&motion);
        }
        anchors[reference].pose.come_from(to);
        // What pulls and stays behind has not come back from where the cloth was carried.
        let stays = |anchor: &&mut Anchor| anchor.holds == 0 && anchor.pulls > 0;
        for anchor in anchors.iter_mut().filter(stays) {
            if frame.is_jump(&anchor.pose.start(), &anchor.pose.end()) {
                anchor.pose.come_from(anchor.pose.end());
            }
        }
        if let Err(problem) = solver.carry(&from, &to) {
            failures.report(entity, ClothErrorKind::Solver(problem));
        }
        cloth.shape_version += 1;
    }
    if stands {
        cloth.take_hold_anew();
    }
    if core::mem::take(&mut cloth.frame.reset_asked) {
        reset(entity, cloth, reference, failures);
    }
}

/// Puts the cloth back to its rest shape, or to its skin.
fn reset(entity: Entity, cloth: &mut ClothSimulation, reference: usize, failures: &mut Failures) {
    let outcome = match &cloth.skin {
        Some(skin) => cloth.solver.place(skin.places()),
        None => {
            let pose = cloth.held.attachments.anchors[reference].cloth_at_rest();
            cloth.solver.reset(&pose)
        }
    };
    match outcome {
        Ok(()) => {
            cloth.take_hold_anew();
            cloth.frame.ride = None;
            cloth.sleep.disturb();
            cloth.progress.quarantined = false;
            cloth.shape_version += 1;
            failures.clear(entity, Blame::Motion);
        }
        Err(problem) => failures.report(entity, ClothErrorKind::Solver(problem)),
    }
}

fn is_only_leader(attachments: &Attachments, anchor: Entity) -> bool {
    attachments.leader == Some(anchor) && attachments.holds_nothing_at(anchor)
}

/// Moves every anchor on by a tick. One that has no usable pose stays; it is told, a missing one
/// first.
fn advance_anchors(
    attachments: &mut Attachments,
    (transforms, joints): (&TransformHelper, &Joints),
    at_once: bool,
) -> Option<(Entity, PoseError)> {
    let mut problem = None;
    for anchor in &mut attachments.anchors {
        let now = pose_now(transforms, anchor.entity);
        if at_once {
            anchor.pose.at_once();
        }
        let pose = now.unwrap_or(anchor.pose.end());
        anchor.pose.advance(Placed { pose, root: joints.root(anchor.entity) });
        if let Err(error) = now
            && (problem.is_none() || error == PoseError::Missing)
        {
            problem = Some((anchor.entity, error));
        }
    }
    problem
}

/// The first pin with this anchor.
fn pin_held_by(pins: &ClothPins, entity: Entity, anchor: Entity) -> usize {
    pins.pins.iter().position(|pin| pin.anchor.unwrap_or(entity) == anchor).unwrap_or(0)
}

/// Lets go of everything that this anchor holds, until it is there again.
fn release(cloth: &mut ClothSimulation, anchor: Entity) {
    let mut attachments = core::mem::take(&mut cloth.held.attachments);
    attachments.release(anchor);
    attachments.awaited = Some(anchor);
    hold(cloth, attachments);
}
