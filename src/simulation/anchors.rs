//! Anchors through a tick: they lead what they hold, and a cloth may ride along or be reset with them.

use bevy::prelude::*;

use crate::cloth::sleep::ClothPaused;
use crate::cloth::teleport::{ClothInertia, ClothTeleport};
use crate::error::ClothError;
use crate::error::failures::{Blame, Failures};
use crate::error::problems::PinProblem;
use crate::pose::{PoseError, pose_error, pose_now, to_world};
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::{Anchor, Attachments, Pulled};
use crate::simulation::pinning::hold;
use crate::solver::{ParameterError, PinMotion};

/// Notes where all anchors are before a frame's ticks.
pub(crate) fn note_pins(cloth: &mut ClothSimulation, transforms: &TransformHelper, ticks: u32) {
    for anchor in &mut cloth.attachments.anchors {
        if let Ok(now) = pose_now(transforms, anchor.entity) {
            let before = anchor.pose.end();
            anchor.pose.begin_frame(now, ticks);
            let asked = cloth.following.teleport_asked;
            if asked || cloth.following.is_jump_of_frame(&before, &now, ticks) {
                anchor.pose.at_once();
            }
        }
    }
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
    )>,
    transforms: TransformHelper,
    mut failures: Failures,
) {
    for (entity, mut cloth, teleport, inertia, frozen) in &mut cloths {
        let cloth = &mut *cloth;
        let outcome = cloth.following.set_teleport(teleport);
        tell(entity, "ClothTeleport", Blame::Teleport, outcome, &mut failures);
        let outcome = cloth.following.set_inertia(inertia);
        tell(entity, "ClothInertia", Blame::Inertia, outcome, &mut failures);
        let at_once = cloth.following.teleport_asked;
        match advance_anchors(&mut cloth.attachments, &transforms, at_once) {
            None if cloth.attachments.awaited.is_some() => {}
            None => failures.clear(entity, Blame::Pose),
            Some((anchor, PoseError::Scale(scale))) if anchor == entity => {
                failures.report(entity, ClothError::Scale { entity, scale });
            }
            Some((anchor, error)) if anchor == entity && holds_nothing(cloth, anchor) => {
                failures.report(entity, pose_error(entity, error));
            }
            Some((anchor, error)) => {
                let pin = pin_held_by(cloth, entity, anchor);
                let problem = match error {
                    PoseError::Scale(_) => PinProblem::AnchorScale(anchor),
                    PoseError::Missing => PinProblem::NoAnchor(anchor),
                };
                failures.report(entity, ClothError::Pin { entity, pin, problem });
                if error == PoseError::Missing {
                    release(cloth, anchor);
                }
            }
        }
        let stands = cloth.is_hanging() || frozen.is_some_and(|frozen| frozen.steps == 0);
        follow(entity, cloth, stands, &mut failures);
    }
}

fn tell(
    entity: Entity,
    component: &'static str,
    blame: Blame,
    outcome: Result<(), ParameterError>,
    failures: &mut Failures,
) {
    match outcome {
        Ok(()) => failures.clear(entity, blame),
        Err(problem) => {
            failures.report(entity, ClothError::Parameter { entity, component, problem });
        }
    }
}

/// Carries the cloth where its reference has jumped, or resets it. One that `stands` is carried by
/// every motion.
fn follow(entity: Entity, cloth: &mut ClothSimulation, stands: bool, failures: &mut Failures) {
    let ClothSimulation { attachments, following, solver, rest, .. } = cloth;
    let Some(reference) = attachments.reference() else { return };
    let anchors = &mut attachments.anchors;
    let leads = |(i, anchor): (usize, &Anchor)| {
        (i == reference || anchor.holds + anchor.pulls > 0) && anchor.tick.0 != anchor.tick.1
    };
    if anchors.iter().enumerate().any(leads) {
        rest.disturb();
    }
    if let Some(motion) = following.follow(anchors, reference, stands) {
        let (from, to) = anchors[reference].tick;
        for anchor in anchors.iter_mut() {
            anchor.tick.0 = motion.apply_to_pose(&anchor.tick.0);
        }
        anchors[reference].tick.0 = to;
        // What pulls and stays behind has not come back from where the cloth was carried.
        let stays = |anchor: &&mut Anchor| anchor.holds == 0 && anchor.pulls > 0;
        for anchor in anchors.iter_mut().filter(stays) {
            if following.is_jump(&anchor.tick.0, &anchor.tick.1) {
                anchor.tick.0 = anchor.tick.1;
            }
        }
        if let Err(problem) = solver.carry(&from, &to) {
            failures.report(entity, ClothError::Solver { entity, problem });
        }
        cloth.shape_version += 1;
    }
    if stands {
        cloth.attachments.take_hold_anew();
    }
    if core::mem::take(&mut cloth.following.reset_asked) {
        reset(entity, cloth, reference, failures);
    }
}

/// Puts the cloth back to its rest shape.
fn reset(entity: Entity, cloth: &mut ClothSimulation, reference: usize, failures: &mut Failures) {
    let pose = cloth.attachments.anchors[reference].cloth_at_rest();
    match cloth.solver.reset(&pose) {
        Ok(()) => {
            cloth.attachments.take_hold_anew();
            cloth.following.ride = None;
            cloth.rest.disturb();
            cloth.quarantined = false;
            cloth.shape_version += 1;
            failures.clear(entity, Blame::Motion);
        }
        Err(problem) => failures.report(entity, ClothError::Solver { entity, problem }),
    }
}

fn holds_nothing(cloth: &ClothSimulation, anchor: Entity) -> bool {
    let mut anchors = cloth.attachments.anchors.iter();
    !anchors.any(|a| a.entity == anchor && a.holds + a.pulls > 0)
}

/// Moves every anchor on by a tick. One that has no usable pose stays; it is told, a missing one
/// first.
fn advance_anchors(
    attachments: &mut Attachments,
    transforms: &TransformHelper,
    at_once: bool,
) -> Option<(Entity, PoseError)> {
    let mut problem = None;
    for anchor in &mut attachments.anchors {
        let now = pose_now(transforms, anchor.entity);
        if at_once {
            anchor.pose.at_once();
        }
        anchor.tick = anchor.pose.advance(now.unwrap_or(anchor.pose.end()));
        if let Err(error) = now
            && (problem.is_none() || error == PoseError::Missing)
        {
            problem = Some((anchor.entity, error));
        }
    }
    problem
}

/// The first pin with this anchor.
fn pin_held_by(cloth: &ClothSimulation, entity: Entity, anchor: Entity) -> usize {
    let mut pins = cloth.pins.pins.iter();
    pins.position(|pin| pin.anchor.unwrap_or(entity) == anchor).unwrap_or(0)
}

/// Lets go of everything that this anchor holds.
fn release(cloth: &mut ClothSimulation, anchor: Entity) {
    let mut attachments = core::mem::take(&mut cloth.attachments);
    if let Some(gone) = attachments.anchors.iter().position(|a| a.entity == anchor) {
        attachments.attached.retain(|a| a.anchor as usize != gone);
        attachments.pulled.retain(|p| p.at.anchor as usize != gone);
        attachments.anchors.remove(gone);
        let pulled = attachments.pulled.iter_mut().map(|p| &mut p.at);
        for attached in attachments.attached.iter_mut().chain(pulled) {
            attached.anchor -= u32::from(attached.anchor as usize > gone);
        }
    }
    hold(cloth, attachments);
}

/// Works out the motion of every pin through the tick.
pub(crate) fn gather_motions(cloth: &mut ClothSimulation) {
    let Attachments { anchors, attached, pulled, motions, .. } = &mut cloth.attachments;
    let back = cloth.following.ride.map(|ride| ride.inverse());
    let seen = |end: Vec3| back.map_or(end, |back| back.apply(end));
    motions.clear();
    for pin in attached {
        let (start, end) = anchors[pin.anchor as usize].tick;
        let start = if pin.fresh {
            cloth.solver.position(pin.particle as usize)
        } else {
            to_world(&start, pin.local)
        };
        pin.fresh = false;
        motions.push(PinMotion { start, end: seen(to_world(&end, pin.local)) });
    }
    let mut grabbed = cloth.grab.iter().flat_map(|grab| grab.ways()).peekable();
    let grabbed_motion = |(_, start, end): (u32, Vec3, Vec3)| PinMotion { start, end: seen(end) };
    for Pulled { at, .. } in pulled {
        while let Some(way) = grabbed.next_if(|(particle, ..)| *particle < at.particle) {
            motions.push(grabbed_motion(way));
        }
        let (start, end) = anchors[at.anchor as usize].tick;
        let end = seen(to_world(&end, at.local));
        // What pulls for the first time has not come from anywhere.
        let start = if at.fresh { end } else { to_world(&start, at.local) };
        at.fresh = false;
        motions.push(PinMotion { start, end });
    }
    motions.extend(grabbed.map(grabbed_motion));
    if let Some(grab) = &mut cloth.grab {
        grab.advance();
    }
}
