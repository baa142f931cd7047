//! First stage: accelerations from springs, bending, damping, gravity, loads and air.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::forces::aerodynamics::Push;
use crate::solver::forces::families::Constants;
use crate::solver::forces::wind::Place;
use crate::solver::input::StepInput;
use crate::solver::integrate::verlet::Kick;
use crate::solver::model::{Acting, Particles};
use crate::solver::settings::Integrator;

impl ClothSolver {
    /// First stage: accelerations from springs, bending, damping, gravity and air. Nothing to do where
    /// gravity acts alone.
    pub fn accumulate_forces(&mut self, input: &StepInput<'_>) {
        self.brake_bending();
        if !self.has_forces() {
            return;
        }
        self.accelerate(input);
        if self.settings.integrator != Integrator::Verlet {
            self.accumulate_explicitly(input);
        }
    }

    /// Accelerations where the particles are.
    pub(crate) fn accelerate(&mut self, input: &StepInput<'_>) {
        let (half_kick, gravity) = (self.half_kick(), self.gravity(input));
        let Self { model, isa, bands, pins, state, workspace, .. } = self;
        let acting = Acting {
            plan: &self.plan,
            damping_form: self.material.damping_form,
            half_kick,
            gravity,
            pushes: self.pushes.as_deref(),
        };
        let on = Particles { isa: *isa, bands, pins, state };
        model.stages_mut().accelerate(on, &acting, &mut workspace.a);
        self.add_air();
    }

    /// From the middle of the last substep to its end.
    pub(crate) fn half_kick(&self) -> Kick {
        Kick::new(self.drag(), 0.5 * self.state.last_step)
    }

    /// Rate at which still air stops the cloth, and what brakes it in this tick \[1/s\].
    pub(crate) fn drag(&self) -> f32 {
        let of_air = if self.air.is_some() { 0.0 } else { self.material.drag };
        of_air + self.braking
    }

    /// Takes the wind of a tick, if the cloth feels any. Gives what it adds to the load on the tethers,
    /// in the direction of gravity \[m/s2\].
    pub(crate) fn take_wind(&mut self, input: &StepInput<'_>, (min, max): (Vec3, Vec3)) -> Vec3 {
        let Some(surface) = &mut self.air else {
            return Vec3::ZERO;
        };
        let origin = self.state.origin;
        let place = Place { origin, min: min - origin, max: max - origin };
        surface.begin_tick(self.isa, &input.wind, place, &self.state.x);
        let load = surface.load(&input.wind, &place, self.material.area_density);
        input.gravity.normalize_or(Vec3::NEG_Y) * load
    }

    /// Drag and lift, on top of all other accelerations.
    pub(crate) fn add_air(&mut self) {
        let area_density = self.inertia();
        let Some(surface) = &mut self.air else { return };
        let state = &self.state;
        let push = Push {
            kick: 0.5 * (state.last_step + self.plan.step),
            unit: state.unit,
            area_density,
            inverse_mass: &self.pins.inverse_mass,
            x: &state.x,
            d: &state.d,
            a: &mut self.workspace.a,
        };
        surface.push(self.isa, push);
    }

    pub(crate) fn has_forces(&self) -> bool {
        let plan = &self.plan;
        plan.explicit != Constants::default()
            || plan.damping > 0.0
            || self.air.is_some()
            || self.is_pushed()
            || self.settings.integrator != Integrator::Verlet
    }
}
