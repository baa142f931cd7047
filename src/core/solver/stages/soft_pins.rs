//! Soft pins of a cloth: which there are, and what they pull in a substep.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::constraints::soft_pins::{PulledBody, SoftPin, Spring, shortened};
use crate::solver::contact::Share;
use crate::solver::error::SolverError;
use crate::solver::input::StepInput;
use crate::solver::state::State;

impl ClothSolver {
    /// Holds these particles by springs, and no others. Their targets' motions follow those of the
    /// pins in [`StepInput::pins`], in ascending order of the particles. A particle that is pinned as
    /// well stays where its pin is.
    ///
    /// # Errors
    /// [`SolverError::NoSuchParticle`] or [`SolverError::Parameter`]; the old ones then stay.
    pub fn set_soft_pins(&mut self, pins: &[SoftPin]) -> Result<(), SolverError> {
        let count = self.topology.particle_count();
        for pin in pins {
            if pin.particle as usize >= count {
                return Err(SolverError::NoSuchParticle { particle: pin.particle as usize, count });
            }
            pin.validate()?;
        }
        let topology = &self.topology;
        self.soft = pins
            .iter()
            .map(|&pin| Spring::new(pin, topology.slot(pin.particle as usize)))
            .collect();
        self.soft.sort_by_key(|spring| spring.pin.particle);
        self.soft.dedup_by_key(|spring| spring.pin.particle);
        Ok(())
    }

    /// Lets a soft pin pull with no more than so much force \[N\], spring and damper together, until soft
    /// pins are set anew. Of no effect on what is no soft pin, or where it is NaN.
    pub fn limit_soft_pin(&mut self, particle: u32, most_force: f32) {
        if let Ok(at) = self.soft.binary_search_by_key(&particle, |spring| spring.pin.particle) {
            self.soft[at].most_force = most_force.max(0.0);
        }
    }

    /// Limits soft pins as those of another solver, which has the same.
    pub(crate) fn limit_soft_pins_as(&mut self, other: &Self) {
        for (spring, other) in self.soft.iter_mut().zip(&other.soft) {
            spring.most_force = other.most_force;
        }
    }

    /// The particles held by springs, ascending.
    pub fn soft_pins(&self) -> impl ExactSizeIterator<Item = &SoftPin> + '_ {
        self.soft.iter().map(|spring| &spring.pin)
    }

    /// Pulls soft pins towards their targets, the last of integration.
    pub(crate) fn pull_soft_pins(&mut self, input: &StepInput<'_>) {
        let span = self.span();
        let h = self.plan.step;
        let longest = self.settings.max_speed * h;
        let (state, held) = (&mut self.state, &self.pins);
        let motions = &input.pins[held.slots.len().min(input.pins.len())..];
        for (spring, motion) in self.soft.iter_mut().zip(motions) {
            let w = held.inverse_mass[spring.slot];
            if w == 0.0 {
                continue;
            }
            let (start, end) = (motion.start - state.origin, motion.end - state.origin);
            let way = end - start;
            let mut target = if span.to < 1.0 { start + way * span.to } else { end };
            let mut moved = way * (span.to - span.from);
            if let Some(body) = &mut spring.body {
                let (impulses, collider) = (&state.contacts.impulses, body.collider);
                let from = start + way * span.from;
                let before = impulses.led(collider, from, span.from, 0.0);
                let span = [span.from, span.to];
                target = impulses.expected_to_carry(collider, target, span, h);
                moved = target - before;
                body.yields = impulses.yielding(collider, target, 0.0) / w;
                body.at = target;
            }
            let (alpha, beta) = spring.gains(w * state.response, h);
            let d = state.d.get(spring.slot);
            let away = target - state.x.get(spring.slot);
            // A body comes towards the particle as the particle does towards the body.
            let closing = 1.0 + alpha * (1.0 + spring.yields()) + beta;
            let pull = (away * alpha + moved * beta - d * (alpha + beta)) / closing;
            let most = spring.most_force * w * state.response;
            spring.slack = pull.dot(pull) > most * most;
            let pulled = shortened(d + shortened(pull, most), longest);
            state.d.set(spring.slot, pulled);
            state.leave_out(spring.slot, pulled - d);
            if let Some(body) = &mut spring.body {
                body.given = (d - pulled) * (1.0 / w);
            }
        }
    }

    /// Gives soft pins the mass that corrections are to see.
    pub(crate) fn weigh_soft_pins(&mut self) {
        let h = self.plan.step;
        let held = &mut self.pins;
        for spring in &mut self.soft {
            let w = held.inverse_mass[spring.slot];
            let (alpha, beta) = spring.gains(w * self.state.response, h);
            let borne = (alpha + beta) / (1.0 + alpha * spring.yields());
            let heavier = if spring.slack { w } else { w / (1.0 + borne) };
            spring.inverse_mass = held.set_inverse_mass(&self.topology, spring.slot, heavier);
            spring.noted = self.state.d.get(spring.slot);
            if let Some(body) = &mut spring.body {
                body.before = spring.noted;
            }
            // What it lies on would bear pulls that its spring bears.
            self.state.contacts.forget(spring.slot);
        }
    }

    /// Adds to the pulls of soft pins what they did not follow of the corrections since it was noted last, or only
    /// goes on from here.
    pub(crate) fn note_soft_pins(&mut self, adds: bool) {
        for spring in &mut self.soft {
            let d = self.state.d.get(spring.slot);
            let unfollowed = spring.inverse_mass / self.pins.inverse_mass[spring.slot] - 1.0;
            if adds && unfollowed.is_finite() {
                self.state.leave_out(spring.slot, (d - spring.noted) * -unfollowed);
            }
            spring.noted = d;
        }
    }

    /// Gives bodies what springs pulled at them with, before corrections and in them.
    pub(crate) fn give_soft_pulls(&mut self) {
        let step = self.plan.step;
        let State { d, contacts, .. } = &mut self.state;
        for spring in &self.soft {
            let Some(PulledBody { collider, at, before, given, .. }) = spring.body else {
                continue;
            };
            let heavier = self.pins.inverse_mass[spring.slot];
            // One that is pinned as well is held by its pin.
            if heavier == 0.0 {
                continue;
            }
            let followed = d.get(spring.slot) - before;
            let borne = followed * (1.0 / heavier - 1.0 / spring.inverse_mass);
            let given = given + borne;
            contacts.impulses.give([Share { collider, at, given, owed: Vec3::ZERO }], step);
        }
    }

    /// Gives them their own again.
    pub(crate) fn unweigh_soft_pins(&mut self) {
        for spring in &self.soft {
            self.pins.set_inverse_mass(&self.topology, spring.slot, spring.inverse_mass);
        }
    }
}
