//! Second stage: velocities and positions of the free particles; pins move to where they are to be.

use crate::solver::ClothSolver;
use crate::solver::contact::ActiveSet;
use crate::solver::input::StepInput;
use crate::solver::integrate::houbolt::PullFilter;
use crate::solver::integrate::verlet::{Acceleration, Advance, Integrate, Kick};
use crate::solver::settings::Integrator;
use crate::solver::simd::parallel;
use crate::solver::state::State;

impl ClothSolver {
    /// Second stage: velocities and positions of the free particles; pins go their way.
    pub fn integrate(&mut self, input: &StepInput<'_>) {
        match self.settings.integrator {
            Integrator::Verlet => self.integrate_verlet(input),
            Integrator::Euler | Integrator::Midpoint => {
                self.state.contacts.edges.warm.clear();
                self.integrate_explicitly();
            }
        }
        self.state.unit = self.plan.step;
        self.move_pins(input);
        self.pull_soft_pins(input);
    }

    pub(crate) fn integrate_verlet(&mut self, input: &StepInput<'_>) {
        let plan = self.plan;
        let acceleration = if self.has_forces() {
            Acceleration::Each(&self.workspace.a)
        } else {
            Acceleration::Uniform(self.gravity(input))
        };
        // From the middle of the last substep to the middle of this one.
        let kick = Kick::new(self.drag(), 0.5 * (self.state.last_step + plan.step));
        self.state.response = kick.gain * plan.step;
        let carried = self.carried();
        let State { d, pull, unit, response, .. } = &mut self.state;
        let integrate = Integrate {
            band: self.bands.rows.clone(),
            acceleration,
            advance: Advance {
                keep: kick.decay * (plan.step / *unit),
                gain: *response,
                longest: self.settings.max_speed * plan.step,
            },
            inverse_mass: &self.pins.inverse_mass,
            d: d.part_mut(),
            carry: PullFilter::new(self.workspace.filter.is_some(), carried, pull),
        };
        parallel::run(self.isa, integrate);
        let ratio = plan.step / self.state.last_step;
        let State { x, d, pull, contacts, .. } = &mut self.state;
        let ActiveSet { edges, impulses, .. } = contacts;
        let pull = self.workspace.filter.is_some().then_some(pull);
        let inverse_mass = &self.pins.inverse_mass;
        edges.start_warm(ratio * ratio, plan.step, inverse_mass, x, d, pull, impulses);
        self.state.last_step = plan.step;
    }

    pub(crate) fn move_pins(&mut self, input: &StepInput<'_>) {
        let to = self.span().to;
        let state = &mut self.state;
        for (&slot, pin) in self.pins.slots.iter().zip(input.pins) {
            let (start, end) = (pin.start - state.origin, pin.end - state.origin);
            let target = if to < 1.0 { start + (end - start) * to } else { end };
            state.d.set(slot, target - state.x.get(slot));
        }
        self.lead_pulling();
    }
}
