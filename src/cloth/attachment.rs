//! Pins at work: which particle hangs on which anchor, where in its frame, and how it moves in a
//! tick.

use super::{
    ClothPins, ClothSimulation, PinProblem,
    pins::Pin,
    pose::{MovingPose, PoseError, pose_now, to_local, to_world},
};
use crate::{
    error::{Blame, ClothError, Failures},
    solver::{PinMotion, Pose},
};
use bevy::prelude::*;

/// Something that holds particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub entity: Entity,
    pub pose: MovingPose,
    /// Its poses at this tick's start and end.
    tick: (Pose, Pose),
    /// Its pose when the mesh was last written.
    pub drawn: Option<Pose>,
}

impl Anchor {
    fn new(entity: Entity, now: Pose) -> Self {
        Self { entity, pose: MovingPose::new(now), tick: (now, now), drawn: None }
    }
}

/// One particle that is held.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attached {
    pub particle: u32,
    /// Index of its [`Anchor`].
    pub anchor: u32,
    /// Its place in the anchor's frame.
    pub local: Vec3,
    /// Not yet held through a tick: it starts from where the particle is.
    fresh: bool,
}

/// All that is held of a cloth.
#[derive(Default)]
pub(crate) struct Attachments {
    /// The cloth's entity, which holds what has no other anchor.
    pub own_entity: Option<Entity>,
    pub anchors: Vec<Anchor>,
    /// In the order of the solver's pins.
    pub attached: Vec<Attached>,
    /// The motion of each through the tick, in the same order.
    pub motions: Vec<PinMotion>,
}

impl Attachments {
    fn find(&self, particle: u32, anchor: Entity) -> Option<&Attached> {
        let at = self.attached.binary_search_by_key(&particle, |a| a.particle).ok()?;
        Some(&self.attached[at]).filter(|a| self.anchors[a.anchor as usize].entity == anchor)
    }

    fn slot(&mut self, anchor: Anchor) -> u32 {
        let known = self.anchors.iter().position(|a| a.entity == anchor.entity);
        known.unwrap_or_else(|| {
            self.anchors.push(anchor);
            self.anchors.len() - 1
        }) as u32
    }
}

/// Applies changed pins: takes hold of what is newly pinned, releases what no longer is.
pub(crate) fn apply_pins(
    mut cloths: Query<(Entity, Ref<ClothPins>, &mut ClothSimulation)>,
    transforms: TransformHelper,
    mut failures: Failures,
) {
    for (entity, pins, mut cloth) in &mut cloths {
        // Until the first tick, pins take hold anew: where the anchors are by then is what counts.
        let fresh = cloth.tick_count == 0;
        if !fresh && !pins.is_changed() {
            continue;
        }
        if fresh {
            cloth.attachments = Attachments::default();
        } else if cloth.pins == *pins && !failures.blames(entity, Blame::Pins) {
            continue;
        }
        cloth.pins.clone_from(&pins);
        let (attachments, problem) = attach(&cloth, entity, &pins.pins, &transforms);
        hold(&mut cloth, attachments);
        match problem {
            None => failures.clear(entity, Blame::Pins),
            Some((pin, problem)) => {
                failures.report(entity, ClothError::Pin { entity, pin, problem });
            }
        }
    }
}

/// Makes the solver hold exactly what is attached.
fn hold(cloth: &mut ClothSimulation, attachments: Attachments) {
    let particles: Vec<_> = attachments.attached.iter().map(|a| a.particle).collect();
    // The particles come from the cloth's own lattice: the solver has no reason to refuse them.
    if cloth.solver.set_pins(&particles).is_ok() {
        cloth.attachments = attachments;
        cloth.stale = true;
    }
}

/// What the pins hold now, and the first pin that holds nothing.
fn attach(
    cloth: &ClothSimulation,
    entity: Entity,
    pins: &[Pin],
    transforms: &TransformHelper,
) -> (Attachments, Option<(usize, PinProblem)>) {
    let mut anchor_of = vec![None; cloth.particle_count()];
    let mut problem = None;
    for (index, pin) in pins.iter().enumerate() {
        let anchor = pin.anchor.unwrap_or(entity);
        let held = anchor_now(anchor, transforms).and_then(|_| {
            let hold = |particle: u32| anchor_of[particle as usize] = Some(anchor);
            pin.selection.for_each(&cloth.choices(), hold)
        });
        if let Err(error) = held {
            problem.get_or_insert((index, error));
        }
    }
    let mut out = Attachments { own_entity: Some(entity), ..default() };
    for (particle, anchor) in anchor_of.iter().enumerate() {
        if let Some(anchor) = *anchor
            && let Some(attached) =
                attach_one(cloth, entity, particle, anchor, transforms, &mut out)
        {
            out.attached.push(attached);
        }
    }
    // Room for every motion now, so that no tick needs any.
    out.motions.reserve_exact(out.attached.len());
    (out, problem)
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
    let known = cloth.attachments.anchors.iter().find(|a| a.entity == anchor);
    let known = match known {
        Some(known) => *known,
        None => Anchor::new(anchor, anchor_now(anchor, transforms).ok()?),
    };
    let before = cloth.attachments.find(particle as u32, anchor);
    let local = match before {
        Some(before) => before.local,
        None if anchor == entity => {
            cloth.solver.topology().rest_positions()[particle] / cloth.placed.scale
        }
        None => to_local(&known.pose.end(), cloth.solver.position(particle)),
    };
    let fresh = before.is_none_or(|before| before.fresh);
    Some(Attached { particle: particle as u32, anchor: out.slot(known), local, fresh })
}

fn anchor_now(anchor: Entity, transforms: &TransformHelper) -> Result<Pose, PinProblem> {
    pose_now(transforms, anchor).map_err(|error| match error {
        PoseError::Missing => PinProblem::NoAnchor(anchor),
        PoseError::Scale(_) => PinProblem::AnchorScale(anchor),
    })
}

/// Notes where all anchors are before a frame's ticks.
pub(crate) fn note_pins(cloth: &mut ClothSimulation, transforms: &TransformHelper, ticks: u32) {
    for anchor in &mut cloth.attachments.anchors {
        if let Ok(now) = pose_now(transforms, anchor.entity) {
            anchor.pose.begin_frame(now, ticks);
        }
    }
}

/// Works out the motion of every pin through the tick, and lets go of what lost its anchor.
pub(crate) fn gather_pins(
    mut cloths: Query<(Entity, &mut ClothSimulation)>,
    transforms: TransformHelper,
    mut failures: Failures,
) {
    for (entity, mut cloth) in &mut cloths {
        let cloth = &mut *cloth;
        match advance_anchors(&mut cloth.attachments, &transforms) {
            None => failures.clear(entity, Blame::Pose),
            Some((anchor, PoseError::Scale(scale))) if anchor == entity => {
                failures.report(entity, ClothError::Scale { entity, scale });
            }
            Some((anchor, error)) => {
                let pin = pin_held_by(cloth, anchor);
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
        gather_motions(cloth);
    }
}

/// Moves every anchor on by a tick. One that has no usable pose stays; it is told, a missing one
/// first.
fn advance_anchors(
    attachments: &mut Attachments,
    transforms: &TransformHelper,
) -> Option<(Entity, PoseError)> {
    let mut problem = None;
    for anchor in &mut attachments.anchors {
        let now = pose_now(transforms, anchor.entity);
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
fn pin_held_by(cloth: &ClothSimulation, anchor: Entity) -> usize {
    cloth.pins.pins.iter().position(|pin| pin.anchor == Some(anchor)).unwrap_or(0)
}

/// Lets go of everything that this anchor holds.
fn release(cloth: &mut ClothSimulation, anchor: Entity) {
    let mut attachments = core::mem::take(&mut cloth.attachments);
    if let Some(gone) = attachments.anchors.iter().position(|a| a.entity == anchor) {
        attachments.attached.retain(|a| a.anchor as usize != gone);
        attachments.anchors.remove(gone);
        for attached in &mut attachments.attached {
            attached.anchor -= u32::from(attached.anchor as usize > gone);
        }
    }
    hold(cloth, attachments);
}

fn gather_motions(cloth: &mut ClothSimulation) {
    let Attachments { anchors, attached, motions, .. } = &mut cloth.attachments;
    motions.clear();
    for pin in attached {
        let (start, end) = anchors[pin.anchor as usize].tick;
        let start = if pin.fresh {
            cloth.solver.position(pin.particle as usize)
        } else {
            to_world(&start, pin.local)
        };
        pin.fresh = false;
        motions.push(PinMotion { start, end: to_world(&end, pin.local) });
    }
}
