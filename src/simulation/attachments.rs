//! Pins at work: which particle hangs on which anchor, where in its frame, and how it moves in a
//! tick.
//!
//! Hard pins are given to the solver as places, soft ones as the targets of springs.

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::prelude::*;

use crate::cloth::pins::{ClothPins, Pin, PinHold};
use crate::cloth::sleep::ClothFrozen;
use crate::cloth::teleport::{ClothInertia, ClothTeleport};
use crate::error::ClothError;
use crate::error::failures::{Blame, Failures};
use crate::error::problems::PinProblem;
use crate::pose::{MovingPose, PoseError, pose_error, pose_now, to_local, to_world};
use crate::simulation::ClothSimulation;
use crate::solver::{ParameterError, PinMotion, Pose, SoftPin};

/// Something that holds particles, or the cloth's own entity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Anchor {
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity"))]
    pub entity: Entity,
    pub pose: MovingPose,
    /// Its poses at this tick's start and end.
    pub tick: (Pose, Pose),
    /// Pose of the cloth's entity in its frame, when it took hold.
    cloth: Pose,
    /// Particles that it holds hard.
    pub holds: u32,
    /// Particles that it holds softly.
    pub pulls: u32,
    /// Its pose when the mesh was last written.
    pub drawn: Option<Pose>,
}

impl Anchor {
    fn new(entity: Entity, now: Pose, cloth: &Pose) -> Self {
        let cloth = Pose {
            translation: to_local(&now, cloth.translation),
            rotation: (now.rotation.inverse() * cloth.rotation).normalize(),
            scale: 1.0,
        };
        let pose = MovingPose::new(now);
        Self { entity, pose, tick: (now, now), cloth, holds: 0, pulls: 0, drawn: None }
    }

    /// Where the cloth is to be at rest, now that the anchor is where the tick ends.
    fn cloth_at_rest(&self) -> Pose {
        let (_, now) = self.tick;
        Pose {
            translation: to_world(&now, self.cloth.translation),
            rotation: (now.rotation * self.cloth.rotation).normalize(),
            scale: 1.0,
        }
    }
}

/// One particle that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Attached {
    pub particle: u32,
    /// Index of its [`Anchor`].
    pub anchor: u32,
    /// Its place in the anchor's frame.
    pub local: Vec3,
    /// Not yet held through a tick: it starts from where the particle is.
    fresh: bool,
}

/// A particle on a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pulled {
    pub at: Attached,
    spring: SoftPin,
}

/// All that is held of a cloth.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Attachments {
    /// The cloth's entity, which holds what has no other anchor.
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity_option"))]
    pub own_entity: Option<Entity>,
    /// The cloth's entity, if it has a pose, then the others.
    pub anchors: Vec<Anchor>,
    /// In the order of the solver's pins.
    pub attached: Vec<Attached>,
    /// In the order of its soft pins.
    pulled: Vec<Pulled>,
    /// An anchor whose pose cannot be used at present: its pin holds nothing until it can.
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity_option"))]
    awaited: Option<Entity>,
    /// The motion of each through the tick, hard pins first.
    #[cfg_attr(feature = "serialize", serde(skip))]
    pub motions: Vec<PinMotion>,
}

impl MapEntities for Attachments {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.own_entity.map_entities(mapper);
        self.awaited.map_entities(mapper);
        for anchor in &mut self.anchors {
            anchor.entity.map_entities(mapper);
        }
    }
}

impl Attachments {
    fn find(&self, particle: u32, anchor: Entity) -> Option<&Attached> {
        let held = self.attached.binary_search_by_key(&particle, |a| a.particle);
        let pulled = || self.pulled.binary_search_by_key(&particle, |p| p.at.particle);
        let known = match held {
            Ok(at) => &self.attached[at],
            Err(_) => &self.pulled[pulled().ok()?].at,
        };
        Some(known).filter(|a| self.anchors[a.anchor as usize].entity == anchor)
    }

    /// The anchor that leads the cloth: its own entity if that holds any of it or nothing else does,
    /// else the first that holds it, hard before soft.
    pub fn reference(&self) -> Option<usize> {
        let own = self.anchors.iter().position(|a| Some(a.entity) == self.own_entity);
        let leads = |counts: fn(&Anchor) -> u32| {
            let own = own.filter(|&own| counts(&self.anchors[own]) > 0);
            own.or_else(|| self.anchors.iter().position(|anchor| counts(anchor) > 0))
        };
        leads(|anchor| anchor.holds).or_else(|| leads(|anchor| anchor.pulls)).or(own)
    }

    /// The particles that are held softly, ascending.
    pub fn pulled(&self) -> impl Iterator<Item = u32> + '_ {
        self.pulled.iter().map(|pulled| pulled.at.particle)
    }

    /// Whether it could be that of a cloth of so many particles.
    pub fn is_sound(&self, particles: usize) -> bool {
        let is_sound = |at: &Attached| {
            (at.particle as usize) < particles
                && (at.anchor as usize) < self.anchors.len()
                && at.local.is_finite()
        };
        let counts = |anchor: usize| {
            let theirs = |at: &Attached| at.anchor as usize == anchor;
            let holds = self.attached.iter().filter(|&at| theirs(at)).count();
            let pulls = self.pulled.iter().filter(|pulled| theirs(&pulled.at)).count();
            (holds as u32, pulls as u32)
        };
        let is_sound_anchor = |(i, anchor): (usize, &Anchor)| {
            let &Anchor { entity: _, pose, tick: (start, end), cloth, holds, pulls, drawn } =
                anchor;
            pose.is_sound()
                && [start, end, cloth].iter().all(Pose::is_valid)
                && drawn.is_none_or(|drawn| drawn.is_valid())
                && counts(i) == (holds, pulls)
        };
        self.held().all(is_sound)
            && self.attached.is_sorted_by(|a, b| a.particle < b.particle)
            && self.pulled.is_sorted_by(|a, b| a.at.particle < b.at.particle)
            && self.anchors.iter().enumerate().all(is_sound_anchor)
    }

    /// The same, without what is worked out anew for each tick or frame.
    pub fn kept(&self) -> Self {
        let mut kept = Self { motions: Vec::new(), ..self.clone() };
        kept.anchors.iter_mut().for_each(|anchor| anchor.drawn = None);
        kept
    }

    /// They are those of another entity now.
    pub fn move_to(&mut self, entity: Entity) {
        for anchor in self.anchors.iter_mut().filter(|it| Some(it.entity) == self.own_entity) {
            anchor.entity = entity;
        }
        self.own_entity = Some(entity);
    }

    /// All that is held, hard pins first: as the motions of a tick.
    pub fn held(&self) -> impl Iterator<Item = &Attached> {
        self.attached.iter().chain(self.pulled.iter().map(|pulled| &pulled.at))
    }

    /// Takes hold of what is held at other places in the anchors' frames.
    pub fn hold_at(&mut self, local: impl Fn(&Anchor, &Attached) -> Vec3) {
        let Self { anchors, attached, pulled, .. } = self;
        for at in attached.iter_mut().chain(pulled.iter_mut().map(|pulled| &mut pulled.at)) {
            at.local = local(&anchors[at.anchor as usize], at);
        }
    }

    /// What is held starts from where it is.
    pub fn take_hold_anew(&mut self) {
        self.attached.iter_mut().for_each(|attached| attached.fresh = true);
        self.pulled.iter_mut().for_each(|pulled| pulled.at.fresh = true);
    }

    /// Adds a particle to those that are held, with its part of what its pin has for `share` particles.
    fn add(&mut self, at: Attached, hold: PinHold, share: u32) {
        let anchor = &mut self.anchors[at.anchor as usize];
        match hold {
            PinHold::Hard => {
                anchor.holds += 1;
                self.attached.push(at);
            }
            PinHold::Soft { stiffness, damping } => {
                anchor.pulls += 1;
                let part = 1.0 / share as f32;
                // A part of the smallest number is none at all.
                let stiffness = (stiffness * part).max(f32::MIN_POSITIVE);
                let damping = damping * part;
                let spring = SoftPin { particle: at.particle, stiffness, damping };
                self.pulled.push(Pulled { at, spring });
            }
        }
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
    mut cloths: Query<(Entity, Option<Ref<ClothPins>>, &mut ClothSimulation)>,
    transforms: TransformHelper,
    mut failures: Failures,
) {
    let none = ClothPins::none();
    for (entity, pins, mut cloth) in &mut cloths {
        let changed = pins.as_ref().map_or(cloth.pins != none, DetectChanges::is_changed);
        let pins = pins.as_deref().unwrap_or(&none);
        // Until the first tick, pins take hold anew: where the anchors are by then is what counts.
        // One that is being hung is carried along from then on.
        let begun = cloth.hanging.as_ref().is_some_and(|hanging| hanging.has_begun());
        let fresh = cloth.tick_count == 0 && !begun;
        let awaited = cloth.attachments.awaited;
        let found = awaited.is_some_and(|anchor| pose_now(&transforms, anchor).is_ok());
        if !(fresh || found || changed) {
            continue;
        }
        if fresh {
            cloth.attachments = Attachments::default();
        } else if cloth.pins == *pins && !found && !failures.blames(entity, Blame::Pins) {
            continue;
        }
        cloth.pins.clone_from(pins);
        let (attachments, problem) = attach(&cloth, entity, &pins.pins, &transforms);
        hold(&mut cloth, attachments);
        match problem {
            None => {
                failures.clear(entity, Blame::Pins);
                if found {
                    failures.clear(entity, Blame::Pose);
                }
            }
            Some((pin, problem)) => {
                failures.report(entity, ClothError::Pin { entity, pin, problem });
            }
        }
    }
}

/// Makes the solver hold exactly what is attached.
fn hold(cloth: &mut ClothSimulation, mut attachments: Attachments) {
    let particles: Vec<_> = attachments.attached.iter().map(|a| a.particle).collect();
    let mut springs: Vec<_> = attachments.pulled.iter().map(|p| p.spring).collect();
    if let Some(grab) = &mut cloth.grab {
        grab.take_hold(|particle| {
            let held = attachments.attached.binary_search_by_key(&particle, |a| a.particle);
            let pulled = attachments.pulled.binary_search_by_key(&particle, |p| p.at.particle);
            held.is_ok() || pulled.is_ok()
        });
        springs.extend(grab.springs());
    }
    // Room for every motion now, so that no tick needs any.
    attachments.motions.clear();
    attachments.motions.reserve_exact(particles.len() + springs.len());
    // The particles come from the cloth's own lattice, and the numbers have been looked at: the solver
    // has no reason to refuse them.
    if cloth.solver.set_pins(&particles).is_ok() && cloth.solver.set_soft_pins(&springs).is_ok() {
        if let Some(grab) = &cloth.grab {
            for spring in grab.springs() {
                cloth.solver.limit_soft_pin(spring.particle, grab.most_force());
            }
        }
        cloth.rest.disturb();
        cloth.attachments = attachments;
        cloth.stale = true;
    }
}

/// Holds what is attached, and what is grabbed now.
pub(crate) fn hold_anew(cloth: &mut ClothSimulation) {
    let attachments = core::mem::take(&mut cloth.attachments);
    hold(cloth, attachments);
}

/// What the pins hold now, and the first pin that holds nothing.
fn attach(
    cloth: &ClothSimulation,
    entity: Entity,
    pins: &[Pin],
    transforms: &TransformHelper,
) -> (Attachments, Option<(usize, PinProblem)>) {
    let mut holder_of = vec![None; cloth.particle_count()];
    let mut problem = None;
    for (index, pin) in pins.iter().enumerate() {
        let anchor = pin.anchor.unwrap_or(entity);
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
        Some((_, PinProblem::AnchorScale(anchor))) => Some(anchor),
        _ => None,
    };
    let mut out = Attachments { own_entity: Some(entity), awaited, ..default() };
    if let Some(own) = anchor(cloth, entity, entity, transforms) {
        out.slot(own);
    }
    for (particle, holder) in holder_of.iter().enumerate() {
        if let Some((anchor, pin)) = *holder
            && let Some(at) = attach_one(cloth, entity, particle, anchor, transforms, &mut out)
        {
            out.add(at, pins[pin].hold, shares[pin]);
        }
    }
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
    let known = self::anchor(cloth, entity, anchor, transforms)?;
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

/// An anchor as it is known, or as it is now; it holds nothing yet.
fn anchor(
    cloth: &ClothSimulation,
    entity: Entity,
    anchor: Entity,
    transforms: &TransformHelper,
) -> Option<Anchor> {
    if let Some(known) = cloth.attachments.anchors.iter().find(|a| a.entity == anchor) {
        return Some(Anchor { holds: 0, pulls: 0, ..*known });
    }
    let own = pose_now(transforms, entity).unwrap_or(cloth.placed);
    Some(Anchor::new(anchor, anchor_now(anchor, transforms).ok()?, &own))
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
        Option<&ClothFrozen>,
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
        cloth.stale = true;
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
            cloth.stale = true;
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
