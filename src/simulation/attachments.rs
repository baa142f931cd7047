//! Pins at work: which particle hangs on which anchor, and where in its frame.
//!
//! Their motions in a tick are worked out in `holding`, which gives hard pins to the solver as places, and soft ones
//! as the targets of springs.

use bevy::ecs::entity::{EntityMapper, MapEntities};
use bevy::prelude::*;

use crate::cloth::pins::PinHold;
use crate::pose::root::Placed;
use crate::pose::track::PoseTrack;
use crate::pose::{to_local, to_world};
use crate::solver::{Pose, SoftPin};

/// Something that holds particles, or the cloth's own entity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Anchor {
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity"))]
    pub entity: Entity,
    pub pose: PoseTrack,
    /// Pose of the cloth's entity in its frame, when it took hold.
    pub(crate) cloth: Pose,
    /// Particles that it holds hard.
    pub holds: u32,
    /// Particles that it holds softly.
    pub pulls: u32,
}

impl Anchor {
    pub(crate) fn new(entity: Entity, now: Pose, cloth: &Pose) -> Self {
        let cloth = Pose {
            translation: to_local(&now, cloth.translation),
            rotation: (now.rotation.inverse() * cloth.rotation).normalize(),
            scale: 1.0,
        };
        Self { entity, pose: PoseTrack::new(Placed::alone(entity, now)), cloth, holds: 0, pulls: 0 }
    }

    /// Where the cloth is to be at rest, now that the anchor is where the tick ends.
    pub(crate) fn cloth_at_rest(&self) -> Pose {
        let now = self.pose.end();
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
    /// The particle's place in the anchor's frame.
    pub local: Vec3,
    /// Not yet held through a tick: it starts from where the particle is.
    pub(crate) fresh: bool,
}

/// A particle on a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Pulled {
    pub at: Attached,
    pub(crate) spring: SoftPin,
}

/// All that is held of a cloth.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Attachments {
    /// The cloth's entity, which holds what has no other anchor.
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity_option"))]
    pub own_entity: Option<Entity>,
    /// The joint that leads a cloth that is worn, whatever it holds.
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity_option"))]
    pub(crate) leader: Option<Entity>,
    /// The cloth's entity, if it has a pose, then the others.
    pub anchors: Vec<Anchor>,
    /// In the order of the solver's pins.
    pub attached: Vec<Attached>,
    /// In the order of its soft pins.
    pub(crate) pulled: Vec<Pulled>,
    /// An anchor whose pose cannot be used at present: its pin holds nothing until it can.
    #[cfg_attr(feature = "serialize", serde(with = "crate::serialize::entity_option"))]
    pub(crate) awaited: Option<Entity>,
}

impl MapEntities for Attachments {
    fn map_entities<M: EntityMapper>(&mut self, mapper: &mut M) {
        self.own_entity.map_entities(mapper);
        self.leader.map_entities(mapper);
        self.awaited.map_entities(mapper);
        for anchor in &mut self.anchors {
            anchor.entity.map_entities(mapper);
        }
    }
}

impl Attachments {
    pub(crate) fn find(&self, particle: u32, anchor: Entity) -> Option<&Attached> {
        let held = self.attached.binary_search_by_key(&particle, |a| a.particle);
        let pulled = || self.pulled.binary_search_by_key(&particle, |p| p.at.particle);
        let known = match held {
            Ok(at) => &self.attached[at],
            Err(_) => &self.pulled[pulled().ok()?].at,
        };
        Some(known).filter(|a| self.anchors[a.anchor as usize].entity == anchor)
    }

    /// Whether nothing is held by an anchor.
    pub fn holds_nothing_at(&self, anchor: Entity) -> bool {
        !self.anchors.iter().any(|a| a.entity == anchor && a.holds + a.pulls > 0)
    }

    /// The anchor that leads the cloth: the joint that a worn one follows; else its own entity if that holds any of it or nothing else
    /// does, else the first that holds it, hard before soft.
    pub fn reference(&self) -> Option<usize> {
        let is_leader = |anchor: &Anchor| Some(anchor.entity) == self.leader;
        if let (Some(_), Some(leader)) = (self.leader, self.anchors.iter().position(is_leader)) {
            return Some(leader);
        }
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
            let &Anchor { entity: _, pose, cloth, holds, pulls } = anchor;
            pose.is_sound() && cloth.is_valid() && counts(i) == (holds, pulls)
        };
        self.held().all(is_sound)
            && self.attached.is_sorted_by(|a, b| a.particle < b.particle)
            && self.pulled.is_sorted_by(|a, b| a.at.particle < b.at.particle)
            && self.anchors.iter().enumerate().all(is_sound_anchor)
    }

    /// Forgets an anchor, and all that it holds.
    pub fn release(&mut self, anchor: Entity) {
        let Some(gone) = self.anchors.iter().position(|a| a.entity == anchor) else { return };
        self.attached.retain(|a| a.anchor as usize != gone);
        self.pulled.retain(|p| p.at.anchor as usize != gone);
        self.anchors.remove(gone);
        let pulled = self.pulled.iter_mut().map(|p| &mut p.at);
        for attached in self.attached.iter_mut().chain(pulled) {
            attached.anchor -= u32::from(attached.anchor as usize > gone);
        }
    }

    /// Gives the attachments to another entity.
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

    /// Lets held particles start from where they are.
    pub fn take_hold_anew(&mut self) {
        self.attached.iter_mut().for_each(|attached| attached.fresh = true);
        self.pulled.iter_mut().for_each(|pulled| pulled.at.fresh = true);
    }

    /// Adds a particle to those that are held, with its part of what its pin has for `share` particles.
    pub(crate) fn add(&mut self, at: Attached, hold: PinHold, share: u32) {
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

    pub(crate) fn slot(&mut self, anchor: Anchor) -> u32 {
        let known = self.anchors.iter().position(|a| a.entity == anchor.entity);
        known.unwrap_or_else(|| {
            self.anchors.push(anchor);
            self.anchors.len() - 1
        }) as u32
    }
}
