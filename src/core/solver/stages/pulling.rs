//! Pins that pull at the bodies which carry them.
//!
//! In the corrections such a pin is a particle that weighs as much as its part of the body and moves freely, so that threads of any
//! stiffness carry a body of any mass, as what lies on one does (`contact/answer`). What they have moved it by is what they pull
//! at the body with. Then the body is given that, and the pin goes where the body does.
//!
//! Soft pins (`soft_pins`) pull at a body by their springs' forces.
//!
//! A cloth that is pinned deep within a body passes through it. Contact would push out of it what the pins hold in it, without end, and
//! the body would be driven by what is inside of it.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::constraints::soft_pins::PulledBody;
use crate::solver::contact::Share;
use crate::solver::input::{PinPull, StepInput};
use crate::solver::state::State;

/// Part of its own inverse mass by which a pin yields that is on a body which does not move: what pulls at it is known by that.
const LEAST_YIELDING: f32 = 0.01;
/// How deep within a body pins are inside it, as a part of the cloth's longest edge.
const WITHIN: f32 = 0.4;

/// A pin that pulls at a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pulling {
    slot: usize,
    /// The collider that has the account of the body.
    collider: usize,
    /// Its own inverse mass, were it not held \[1/kg\].
    own: f32,
    /// Its inverse mass in these corrections \[1/kg\].
    inverse_mass: f32,
    /// Where it is planned to be at the substep's end \[m\].
    planned: Vec3,
    /// Its displacement before the corrections, and what threads made of it \[m\].
    before: Vec3,
    threads: Vec3,
}

impl ClothSolver {
    /// Finds the pins that pull in a tick. Allocates where there are more than ever before.
    pub(crate) fn begin_pulling(&mut self, input: &StepInput<'_>) {
        self.pulling.clear();
        for spring in &mut self.soft {
            spring.body = None;
        }
        let hard = self.pins.slots.len();
        let impulses = &mut self.state.contacts.impulses;
        for &PinPull { pin, body } in input.pulls {
            let Some(collider) = impulses.of_body(body) else { continue };
            impulses.pin_to(collider, pin as usize >= hard);
            let deep = WITHIN * self.edges.longest;
            let place = input.pins[pin as usize].start;
            let mut of_body = input.colliders.iter().filter(|it| it.body == body && it.layers != 0);
            if of_body.any(|it| it.distance_at_start(place) < -deep) {
                impulses.pass(collider);
            }
            if let Some(soft) = (pin as usize).checked_sub(hard) {
                self.soft[soft].body = Some(PulledBody::new(collider));
                continue;
            }
            let slot = self.pins.slots[pin as usize];
            let own = 1.0 / (self.topology.area(slot) * self.material.area_density);
            let none = Vec3::ZERO;
            let (inverse_mass, planned, before, threads) = (0.0, none, none, none);
            let pulling = Pulling { slot, collider, own, inverse_mass, planned, before, threads };
            self.pulling.push(pulling);
        }
    }

    /// Notes where pins that pull are planned to be, the last of leading the pins, and leads them to where their bodies are.
    pub(crate) fn lead_pulling(&mut self) {
        for pulling in &mut self.pulling {
            pulling.planned = self.state.x.get(pulling.slot) + self.state.d.get(pulling.slot);
        }
        self.follow_bodies();
    }

    fn follow_bodies(&mut self) {
        let (to, step) = (self.span().to, self.plan.step);
        let State { x, d, contacts, .. } = &mut self.state;
        for &Pulling { slot, collider, planned, .. } in &self.pulling {
            let place = contacts.impulses.led(collider, planned, to, step);
            d.set(slot, place - x.get(slot));
        }
    }

    /// Gives pins that pull the mass that corrections are to see.
    pub(crate) fn weigh_pulling(&mut self) {
        let State { x, d, contacts, .. } = &self.state;
        for pulling in &mut self.pulling {
            let Pulling { slot, collider, own, .. } = *pulling;
            let least = own * LEAST_YIELDING;
            let body = contacts.impulses.yielding(collider, x.get(slot), least);
            pulling.inverse_mass = own * body / (own + body);
            pulling.before = d.get(slot);
            self.pins.set_inverse_mass(&self.topology, slot, pulling.inverse_mass);
        }
    }

    /// Notes what threads have pulled, which lasts as all of their pulls do.
    pub(crate) fn note_pulling(&mut self) {
        if self.pulling.is_empty() {
            return;
        }
        // What corrects a mesh has its displacements elsewhere until then.
        self.end_corrections();
        for pulling in &mut self.pulling {
            pulling.threads = self.state.d.get(pulling.slot) - pulling.before;
        }
        self.begin_corrections();
    }

    /// Gives bodies what was pulled at them. The pins go with them.
    pub(crate) fn give_pulls(&mut self) {
        if self.pulling.is_empty() {
            return;
        }
        let (step, notes) = (self.plan.step, self.workspace.filter.is_some());
        let State { x, d, contacts, .. } = &mut self.state;
        for &Pulling { slot, collider, inverse_mass, before, threads, .. } in &self.pulling {
            let mass = 1.0 / inverse_mass;
            let (at, given) = (x.get(slot), (d.get(slot) - before) * mass);
            let owed = if notes { threads * mass } else { Vec3::ZERO };
            contacts.impulses.give([Share { collider, at, given, owed }], step);
            self.pins.set_inverse_mass(&self.topology, slot, 0.0);
        }
        self.follow_bodies();
    }
}
