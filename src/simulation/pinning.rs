//! Particles become pinned: what holds each, and where.

use bevy::prelude::*;

use crate::cloth::pins::{ClothPins, Pin, PinHold};
use crate::error::ClothErrorKind;
use crate::error::failures::{Blame, Failures};
use crate::error::problems::PinProblem;
use crate::pose::root::Placed;
use crate::pose::track::PoseTrack;
use crate::pose::{PoseError, pose_now, to_local};
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::{Anchor, Attached, Attachments};
use crate::simulation::holding::hold;
use crate::solver::Pose;

/// Applies changed pins, in a tick or at a frame's end: takes hold of what is newly pinned, releases what no longer is.
pub(crate) fn apply_pins<const IN_TICK: bool>(
    mut cloths: Query<(Entity, Option<Ref<ClothPins>>, &mut ClothSimulation)>,
    transforms: TransformHelper,
    mut failures: Failures,
) {
    let none = ClothPins::none();
    for (entity, pins, mut cloth) in &mut cloths {
        let anew = core::mem::take(&mut cloth.start.takes_hold);
        let changed =
            anew || pins.as_ref().map_or(cloth.in_force.pins != none, DetectChanges::is_changed);
        let pins = pins.as_deref().unwrap_or(&none);
        let fresh = cloth.progress.tick_count == 0 && takes_hold_anew(&cloth, &transforms, IN_TICK);
        let found = is_anchor_found(&cloth, entity, &transforms);
        if !(fresh || found || changed) {
            continue;
        }
        let are_same = !fresh && !anew && cloth.in_force.pins == *pins;
        if fresh {
            cloth.held.attachments = Attachments::default();
        } else if are_same && !found && !failures.blames(entity, Blame::Pins) {
            continue;
        }
        cloth.in_force.pins.clone_from(pins);
        let (attachments, on_skin, problem) = attach(&cloth, entity, &pins.pins, &transforms);
        // What failed is tried again, and wakes the cloth once it holds.
        let pinned = cloth.skin.as_ref().map_or(&[][..], |skin| &skin.state.pinned);
        let are_held_so = attachments == cloth.held.attachments && *pinned == *on_skin;
        if !(are_same && are_held_so) {
            if let Some(skin) = &mut cloth.skin {
                skin.state.pinned = on_skin;
            }
            hold(&mut cloth, attachments);
        }
        cloth.start.is_held = problem.is_none();
        match problem {
            None => {
                failures.clear(entity, Blame::Pins);
                if found {
                    failures.clear(entity, Blame::Pose);
                }
            }
            Some((pin, problem)) => {
                failures.report(entity, ClothErrorKind::Pin { pin, problem });
            }
        }
    }
}

/// Whether an anchor that was awaited, and holds nothing, can be used by now; there may be several of them.
fn is_anchor_found(cloth: &ClothSimulation, entity: Entity, transforms: &TransformHelper) -> bool {
    let attachments = &cloth.held.attachments;
    if attachments.awaited.is_none() {
        return false;
    }
    let anchors = cloth.in_force.pins.pins.iter().map(|pin| pin.anchor.unwrap_or(entity));
    let mut awaited = anchors.filter(|&anchor| attachments.holds_nothing_at(anchor));
    awaited.any(|anchor| pose_now(transforms, anchor).is_ok())
}

/// Whether the pins of a cloth before its first tick are to take hold as if there had been none.
fn takes_hold_anew(cloth: &ClothSimulation, transforms: &TransformHelper, in_tick: bool) -> bool {
    // One that is being hung, or has been culled, is carried along from then on.
    if cloth.start.has_begun() || cloth.culling.has_culled() {
        return false;
    }
    // What a tick has moved before it is taken where it is by then: whether a frame has shown the cloth before changes no bit.
    let is_moved = |anchor: &Anchor| {
        pose_now(transforms, anchor.entity).is_ok_and(|now| now != anchor.pose.seen())
    };
    !cloth.start.is_held
        || cloth.start.hanging.is_some()
        || in_tick && cloth.held.attachments.anchors.iter().any(is_moved)
}

/// Finds the particles that the pins hold now, those that they hold to the skin, and the first pin that holds nothing.
fn attach(
    cloth: &ClothSimulation,
    entity: Entity,
    pins: &[Pin],
    transforms: &TransformHelper,
) -> (Attachments, Vec<u32>, Option<(usize, PinProblem)>) {
    let mut holder_of = vec![None; cloth.particle_count()];
    let leader = cloth.skin.as_ref().map(|skin| skin.leader());
    // What is pinned to a skinned entity itself follows its skeleton.
    let own = leader.unwrap_or(entity);
    let on_skin = |pin: &Pin| leader.is_some() && pin.anchor.is_none() && pin.hold == PinHold::Hard;
    let mut problem = None;
    for (index, pin) in pins.iter().enumerate() {
        let anchor = pin.anchor.unwrap_or(own);
        let usable = pin.hold.validate().and_then(|()| anchor_now(anchor, transforms));
        let held = usable.and_then(|_| {
            let hold = |particle: u32| holder_of[particle as usize] = Some((anchor, index));
            pin.selection.for_each(&cloth.choices(), hold)
        });
        if let Err(error) = held {
            problem.get_or_insert((index, error));
        }
    }
    let mut shares = vec![0_u32; pins.len()];
    for (_, pin) in holder_of.iter().flatten() {
        shares[*pin] += 1;
    }
    let awaited = match problem {
        Some((_, PinProblem::AnchorScale { anchor, .. } | PinProblem::NoAnchor(anchor))) => {
            Some(anchor)
        }
        _ => None,
    };
    let mut out = Attachments { own_entity: Some(entity), leader, awaited, ..default() };
    if let Some(own) = anchor(cloth, entity, own, transforms) {
        out.slot(own);
    }
    let mut held_by_skin = Vec::new();
    for (particle, holder) in holder_of.iter().enumerate() {
        let Some((anchor, pin)) = *holder else { continue };
        if on_skin(&pins[pin]) {
            held_by_skin.push(particle as u32);
        } else if let Some(at) = attach_one(cloth, entity, particle, anchor, transforms, &mut out) {
            out.add(at, pins[pin].hold, shares[pin]);
        }
    }
    (out, held_by_skin, problem)
}

/// Where a newly held particle goes in its anchor's frame. What the same anchor held before stays.
fn attach_one(
    cloth: &ClothSimulation,
    entity: Entity,
    particle: usize,
    anchor: Entity,
    transforms: &TransformHelper,
    out: &mut Attachments,
) -> Option<Attached> {
    let known = self::anchor(cloth, entity, anchor, transforms)?;
    let before = cloth.held.attachments.find(particle as u32, anchor);
    let local = match before {
        Some(before) => before.local,
        None if anchor == entity && cloth.skin.is_none() => {
            cloth.solver.topology().rest_positions()[particle] / cloth.in_force.placed.scale
        }
        None => to_local(&known.pose.end(), cloth.solver.position(particle)),
    };
    let fresh = before.is_none_or(|before| before.fresh);
    Some(Attached { particle: particle as u32, anchor: out.slot(known), local, fresh })
}

/// An anchor as it is known, or as it is now; it holds nothing yet.
fn anchor(
    cloth: &ClothSimulation,
    entity: Entity,
    anchor: Entity,
    transforms: &TransformHelper,
) -> Option<Anchor> {
    if let Some(known) = cloth.held.attachments.anchors.iter().find(|a| a.entity == anchor) {
        return Some(Anchor { holds: 0, pulls: 0, ..*known });
    }
    let own = pose_now(transforms, entity).unwrap_or(cloth.in_force.placed);
    let now = anchor_now(anchor, transforms).ok()?;
    let before = cloth.before_it_was_culled(now, transforms);
    let pose = PoseTrack::new(Placed::alone(anchor, before));
    Some(Anchor { pose, ..Anchor::new(anchor, now, &own) })
}

fn anchor_now(anchor: Entity, transforms: &TransformHelper) -> Result<Pose, PinProblem> {
    pose_now(transforms, anchor).map_err(|error| match error {
        PoseError::Missing => PinProblem::NoAnchor(anchor),
        PoseError::Scale(problem) => PinProblem::AnchorScale { anchor, problem },
    })
}
