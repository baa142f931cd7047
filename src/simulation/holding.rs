//! Pins and grabs together, as the solver takes them: held particles, springs, and their motions in a tick.

use bevy::prelude::*;

use crate::pose::to_world;
use crate::simulation::ClothSimulation;
use crate::simulation::attachments::{Anchor, Attachments, Pulled};
use crate::simulation::grabbed::Grabbed;
use crate::simulation::skin::Skin;
use crate::simulation::tick_state::Motions;
use crate::solver::{ClothSolver, PinMotion, PinPull, RigidMotion};

/// The particles of a cloth that are held, and by what.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Holding {
    /// The particles that pins hold.
    pub(crate) attachments: Attachments,
    /// The particles that a [`ClothGrab`](crate::ClothGrab) holds.
    pub(crate) grab: Option<Box<Grabbed>>,
}

impl Holding {
    /// Works out the motion of every pin through the tick.
    pub fn gather_motions(
        &mut self,
        solver: &ClothSolver,
        skin: Option<&Skin>,
        ride: Option<RigidMotion>,
        body: impl Fn(Entity) -> Option<Entity>,
        Motions { pins: motions, pulls, .. }: &mut Motions,
    ) {
        let Attachments { anchors, attached, pulled, .. } = &mut self.attachments;
        let back = ride.map(|ride| ride.inverse());
        let seen = |end: Vec3| back.map_or(end, |back| back.apply(end));
        motions.clear();
        pulls.clear();
        let pull = |at: usize, anchor: Entity| {
            body(anchor).map(|body| PinPull { pin: at as u32, body: body.to_bits() })
        };
        let motion = |(_, start, end): (u32, Vec3, Vec3)| PinMotion { start, end: seen(end) };
        let mut on_skin = skin.into_iter().flat_map(|skin| skin.ways(solver)).peekable();
        for pin in attached {
            while let Some(way) = on_skin.next_if(|(particle, ..)| *particle < pin.particle) {
                motions.push(motion(way));
            }
            let Anchor { entity, pose: anchor, .. } = &anchors[pin.anchor as usize];
            pulls.extend(pull(motions.len(), *entity));
            let start = if pin.fresh {
                solver.position(pin.particle as usize)
            } else {
                to_world(&anchor.start(), pin.local)
            };
            pin.fresh = false;
            motions.push(PinMotion { start, end: seen(to_world(&anchor.end(), pin.local)) });
        }
        motions.extend(on_skin.map(motion));
        let mut grabbed = self.grab.iter().flat_map(|grab| grab.ways()).peekable();
        for Pulled { at, .. } in pulled {
            while let Some(way) = grabbed.next_if(|(particle, ..)| *particle < at.particle) {
                motions.push(motion(way));
            }
            let Anchor { entity, pose: anchor, .. } = &anchors[at.anchor as usize];
            pulls.extend(pull(motions.len(), *entity));
            let end = seen(to_world(&anchor.end(), at.local));
            // What pulls for the first time has not come from anywhere.
            let start = if at.fresh { end } else { to_world(&anchor.start(), at.local) };
            at.fresh = false;
            motions.push(PinMotion { start, end });
        }
        motions.extend(grabbed.map(motion));
        if let Some(grab) = &mut self.grab {
            grab.advance();
        }
    }
}

/// Makes the solver hold exactly what is attached.
pub(crate) fn hold(cloth: &mut ClothSimulation, attachments: Attachments) {
    let mut particles: Vec<_> = attachments.attached.iter().map(|a| a.particle).collect();
    if let Some(skin) = &mut cloth.skin {
        skin.hold(|particle| particles.binary_search(&particle).is_ok());
        particles.extend(&skin.state.held);
        particles.sort_unstable();
    }
    let mut springs: Vec<_> = attachments.pulled.iter().map(|p| p.spring).collect();
    if let Some(grab) = &mut cloth.held.grab {
        grab.take_hold(|particle| {
            let held = particles.binary_search(&particle);
            let pulled = attachments.pulled.binary_search_by_key(&particle, |p| p.at.particle);
            held.is_ok() || pulled.is_ok()
        });
        springs.extend(grab.springs());
    }
    // Room for every motion now, so that no tick needs any.
    cloth.tick.motions.pins.clear();
    cloth.tick.motions.pins.reserve_exact(particles.len() + springs.len());
    cloth.tick.motions.pulls.clear();
    cloth.tick.motions.pulls.reserve_exact(particles.len() + attachments.pulled.len());
    // The particles come from the cloth's own lattice, and the numbers have been looked at: the solver
    // has no reason to refuse them.
    if cloth.solver.set_pins(&particles).is_ok() && cloth.solver.set_soft_pins(&springs).is_ok() {
        if let Some(grab) = &cloth.held.grab {
            for spring in grab.springs() {
                cloth.solver.limit_soft_pin(spring.particle, grab.most_force());
            }
        }
        cloth.sleep.disturb();
        cloth.held.attachments = attachments;
        cloth.shape_version += 1;
    }
}

/// Holds what is attached, and what is grabbed now.
pub(crate) fn hold_anew(cloth: &mut ClothSimulation) {
    let attachments = core::mem::take(&mut cloth.held.attachments);
    hold(cloth, attachments);
}
