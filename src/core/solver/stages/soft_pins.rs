//! Soft pins of a cloth: which there are, and what they pull in a substep.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::constraints::soft_pins::{SoftPin, Spring, shortened};
use crate::solver::error::SolverError;
use crate::solver::input::StepInput;

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
            .map(|&pin| {
                let slot = topology.slot(pin.particle as usize);
                Spring {
                    pin,
                    slot,
                    most_force: f32::INFINITY,
                    slack: false,
                    inverse_mass: 0.0,
                    noted: Vec3::ZERO,
                }
            })
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
            let target = if span.to < 1.0 { start + way * span.to } else { end };
            let moved = way * (span.to - span.from);
            let (alpha, beta) = spring.gains(w * state.response, h);
            let d = state.d.get(spring.slot);
            let pulled = d + (target - state.x.get(spring.slot)) * alpha + moved * beta;
            let pull = pulled / (1.0 + alpha + beta) - d;
            let most = spring.most_force * w * state.response;
            spring.slack = pull.dot(pull) > most * most;
            let pulled = shortened(d + shortened(pull, most), longest);
            state.d.set(spring.slot, pulled);
            state.leave_out(spring.slot, pulled - d);
        }
    }

    /// Gives soft pins the mass that corrections are to see.
    pub(crate) fn weigh_soft_pins(&mut self) {
        let h = self.plan.step;
        let held = &mut self.pins;
        for spring in &mut self.soft {
            let w = held.inverse_mass[spring.slot];
            let (alpha, beta) = spring.gains(w * self.state.response, h);
            let heavier = if spring.slack { w } else { w / (1.0 + alpha + beta) };
            spring.inverse_mass = held.set_inverse_mass(&self.topology, spring.slot, heavier);
            spring.noted = self.state.d.get(spring.slot);
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

    /// Gives them their own again.
    pub(crate) fn unweigh_soft_pins(&mut self) {
        for spring in &self.soft {
            self.pins.set_inverse_mass(&self.topology, spring.slot, spring.inverse_mass);
        }
    }
}
