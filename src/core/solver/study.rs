//! Integrators beside Verlet, to be compared with it: Euler's explicit method, and the explicit midpoint
//! method, a Runge-Kutta method of second order (Runge 1895; Hairer, Nørsett and Wanner 1993, II.1).
//!
//! Both keep the velocity of the instant, not that of half a substep ago. The displacement of a substep is
//! made of the velocity at its start, and at its end the kick of the whole substep is added, so that
//! corrections and contact see displacements as they do with Verlet. Neither is stable without damping:
//! in each substep they multiply an oscillation of frequency omega by `sqrt(1 + (omega h)^2)` and by
//! `sqrt(1 + (omega h)^4 / 4)`.

use bevy_math::Vec3;

use super::ClothSolver;
use super::bands;
use super::carry::Carry;
use super::input::StepInput;
use super::integrate::{Acceleration, Add, Advance, Integrate};
use super::isa::Isa;
use super::lanes::Soa;
use super::lattice::Layout;
use super::parameters::Integrator;

/// What these integrators work in.
#[derive(Clone, Debug)]
pub(crate) struct Study {
    /// Accelerations where the substep begins \[m/s2\].
    first: Soa,
    /// Positions and displacements there, while those at its middle stand in for them \[m\].
    x: Soa,
    d: Soa,
}

impl Study {
    fn new(layout: Layout) -> Self {
        let [first, x, d] = core::array::from_fn(|_| Soa::zeros(layout.len()));
        Self { first, x, d }
    }
}

impl ClothSolver {
    /// Makes the room that the integrator needs, and no more.
    pub(super) fn make_room_for_study(&mut self) {
        if self.settings.integrator == Integrator::Verlet {
            self.scratch.study = None;
        } else if self.scratch.study.is_none() {
            self.scratch.study = Some(Study::new(self.topology.layout()));
        }
    }

    /// What comes after the accelerations where the substep begins: drag, and with the midpoint method the
    /// accelerations at its middle.
    pub(super) fn study_forces(&mut self, input: &StepInput<'_>) {
        self.brake();
        let Some(mut study) = self.scratch.study.take() else { return };
        study.first.copy_from(&self.scratch.a);
        if self.settings.integrator == Integrator::Midpoint {
            let (half, unit) = (0.5 * self.plan.step, self.state.unit);
            let add = self.adding();
            study.x.copy_from(&self.state.x);
            study.d.copy_from(&self.state.d);
            add.run(half / unit, &self.held.inverse_mass, &study.d, &mut self.state.x);
            add.run(half * unit, &self.held.inverse_mass, &study.first, &mut self.state.d);
            self.accelerate(input);
            self.brake();
            core::mem::swap(&mut study.x, &mut self.state.x);
            core::mem::swap(&mut study.d, &mut self.state.d);
        }
        self.scratch.study = Some(study);
    }

    /// Still air, as an acceleration.
    fn brake(&mut self) {
        let drag = self.drag();
        if drag > 0.0 {
            let part = -drag / self.state.unit;
            let (add, a) = (self.adding(), &mut self.scratch.a);
            add.run(part, &self.held.inverse_mass, &self.state.d, a);
        }
    }

    /// Displacements by the velocity at the substep's start, and with the midpoint method by half of the
    /// acceleration there.
    pub(super) fn integrate_study(&mut self) {
        let h = self.plan.step;
        let (add, inverse_mass) = (self.adding(), &self.held.inverse_mass);
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
            carry: Carry::No,
        };
        bands::run(self.isa, integrate);
        if let (Integrator::Midpoint, Some(study)) = (self.settings.integrator, &self.scratch.study)
        {
            add.run(0.5 * h * h, inverse_mass, &study.first, d);
        }
        // Velocities are those of the instant.
        self.state.last_step = 0.0;
        self.state.response = h * h;
    }

    /// The kick of the whole substep, less what the displacement had of it.
    pub(super) fn end_study(&mut self) {
        let square = self.plan.step * self.plan.step;
        let (add, inverse_mass) = (self.adding(), &self.held.inverse_mass);
        let d = &mut self.state.d;
        add.run(square, inverse_mass, &self.scratch.a, d);
        if let (Integrator::Midpoint, Some(study)) = (self.settings.integrator, &self.scratch.study)
        {
            add.run(-0.5 * square, inverse_mass, &study.first, d);
        }
    }

    fn adding(&self) -> Adding {
        Adding { isa: self.isa, layout: self.topology.layout() }
    }
}

/// Adds a part of one vector a particle to another, for every particle that is not held.
#[derive(Clone, Copy)]
struct Adding {
    isa: Isa,
    layout: Layout,
}

impl Adding {
    fn run(self, part: f32, inverse_mass: &[f32], from: &Soa, to: &mut Soa) {
        self.isa.run(Add { layout: self.layout, part, inverse_mass, from, to });
    }
}
