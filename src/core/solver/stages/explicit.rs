//! The stages as explicit integrators have them, which are there to be compared with.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::input::StepInput;
use crate::solver::integrate::explicit::{Adding, ExplicitWorkspace};
use crate::solver::integrate::houbolt::PullFilter;
use crate::solver::integrate::verlet::{Acceleration, Advance, Integrate};
use crate::solver::settings::Integrator;
use crate::solver::simd::parallel;

impl ClothSolver {
    /// Makes the room that the integrator needs, and no more.
    pub(crate) fn make_room_for_study(&mut self) {
        if self.settings.integrator == Integrator::Verlet {
            self.workspace.study = None;
        } else if self.workspace.study.is_none() {
            self.workspace.study = Some(ExplicitWorkspace::new(self.topology.layout()));
        }
    }

    /// Ends the first stage, after the accelerations where the substep begins: applies drag, and works out the
    /// accelerations at its middle for the midpoint method.
    pub(crate) fn accumulate_explicitly(&mut self, input: &StepInput<'_>) {
        self.brake();
        let Some(mut study) = self.workspace.study.take() else { return };
        study.first.copy_from(&self.workspace.a);
        if self.settings.integrator == Integrator::Midpoint {
            let (half, unit) = (0.5 * self.plan.step, self.state.unit);
            let add = self.adding();
            study.x.copy_from(&self.state.x);
            study.d.copy_from(&self.state.d);
            add.run(half / unit, &self.pins.inverse_mass, &study.d, &mut self.state.x);
            add.run(half * unit, &self.pins.inverse_mass, &study.first, &mut self.state.d);
            self.accelerate(input);
            self.brake();
            core::mem::swap(&mut study.x, &mut self.state.x);
            core::mem::swap(&mut study.d, &mut self.state.d);
        }
        self.workspace.study = Some(study);
    }

    /// Still air, as an acceleration.
    pub(crate) fn brake(&mut self) {
        let drag = self.drag();
        if drag > 0.0 {
            let part = -drag / self.state.unit;
            let (add, a) = (self.adding(), &mut self.workspace.a);
            add.run(part, &self.pins.inverse_mass, &self.state.d, a);
        }
    }

    /// Displacements by the velocity at the substep's start, and with the midpoint method by half of the
    /// acceleration there.
    pub(crate) fn integrate_explicitly(&mut self) {
        let h = self.plan.step;
        let (add, inverse_mass) = (self.adding(), &self.pins.inverse_mass);
        let d = &mut self.state.d;
        let integrate = Integrate {
            band: self.bands.rows.clone(),
            acceleration: Acceleration::Uniform(Vec3::ZERO),
            advance: Advance {
                keep: h / self.state.unit,
                gain: 0.0,
                longest: self.settings.max_speed * h,
            },
            inverse_mass,
            d: d.part_mut(),
            carry: PullFilter::No,
        };
        parallel::run(self.isa, integrate);
        if let (Integrator::Midpoint, Some(study)) =
            (self.settings.integrator, &self.workspace.study)
        {
            add.run(0.5 * h * h, inverse_mass, &study.first, d);
        }
        // Velocities are those of the instant.
        self.state.last_step = 0.0;
        self.state.response = h * h;
    }

    /// The kick of the whole substep, less what the displacement had of it.
    pub(crate) fn end_explicitly(&mut self) {
        let square = self.plan.step * self.plan.step;
        let (add, inverse_mass) = (self.adding(), &self.pins.inverse_mass);
        let d = &mut self.state.d;
        add.run(square, inverse_mass, &self.workspace.a, d);
        if let (Integrator::Midpoint, Some(study)) =
            (self.settings.integrator, &self.workspace.study)
        {
            add.run(-0.5 * square, inverse_mass, &study.first, d);
        }
    }

    pub(crate) fn adding(&self) -> Adding {
        Adding { isa: self.isa, layout: self.topology.layout() }
    }
}
