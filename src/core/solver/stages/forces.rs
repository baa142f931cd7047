//! First stage: accelerations from springs, bending, damping, gravity, loads and air.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::forces::aerodynamics::Push;
use crate::solver::forces::bending::Bend;
use crate::solver::forces::damping::{AddDamping, DampedSprings, DampingTarget};
use crate::solver::forces::springs::AccumulateForces;
use crate::solver::forces::wind::Place;
use crate::solver::input::StepInput;
use crate::solver::integrate::verlet::Kick;
use crate::solver::settings::Integrator;
use crate::solver::simd::parallel;
use crate::solver::state::Workspace;
use crate::solver::topology::Topology;

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
        let Topology::Lattice(lattice) = &self.topology else {
            self.accumulate_graph_forces(input);
            self.add_air();
            return;
        };
        let plan = self.plan;
        let x = &self.state.x;
        let layout = lattice.layout;
        let Workspace { a, moments, rows, .. } = &mut self.workspace;
        let (hinges, rigidity) = (&self.pins.hinges, plan.hinge_rigidity);
        let forces = AccumulateForces {
            band: self.bands.rows.clone(),
            lattice,
            constants: plan.explicit,
            bend: (rigidity > 0.0).then_some(Bend { hinges, rigidity, layout, x }),
            gravity: input.gravity,
            inverse_mass: &self.pins.inverse_mass,
            x,
            a: a.part_mut(),
            rows,
            moments,
        };
        parallel::run(self.isa, forces);
        if let Some(pushes) = &self.pushes {
            pushes.add(self.isa, layout, &self.pins.inverse_mass, &mut self.workspace.a);
        }
        if plan.damping > 0.0 {
            self.add_damping();
        }
        self.add_air();
    }

    /// Damping with the velocity of this instant, not of half a substep ago: a half kick predicts it,
    /// without which the whole scheme would be of first order; and so it would, were drag left out of it.
    pub(crate) fn add_damping(&mut self) {
        let half = self.half_kick();
        let Topology::Lattice(lattice) = &self.topology else { return };
        let Workspace { a, b, rows, .. } = &mut self.workspace;
        let rows = &*rows;
        let state = &self.state;
        let springs = DampedSprings {
            lattice,
            damping: self.plan.damping / state.unit,
            form: self.material.damping_form,
            shear: self.plan.shear_stiffness > 0.0,
            inverse_mass: &self.pins.inverse_mass,
            x: &state.x,
        };
        let gain = half.gain * state.unit;
        let band = &self.bands.rows;
        let predicted = b.part_mut();
        let target = DampingTarget::Predict { keep: half.decay, gain, a, predicted };
        let damping = AddDamping { band: band.clone(), springs, d: &state.d, rows, target };
        parallel::run(self.isa, damping);
        let target = DampingTarget::Accelerations(a.part_mut());
        parallel::run(self.isa, AddDamping { band: band.clone(), springs, d: b, rows, target });
    }

    /// From the middle of the last substep to its end.
    pub(crate) fn half_kick(&self) -> Kick {
        Kick::new(self.drag(), 0.5 * self.state.last_step)
    }

    /// Rate at which still air stops the cloth \[1/s\].
    pub(crate) fn drag(&self) -> f32 {
        if self.air.is_some() { 0.0 } else { self.material.drag }
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
        let Some(surface) = &mut self.air else { return };
        let state = &self.state;
        let push = Push {
            kick: 0.5 * (state.last_step + self.plan.step),
            unit: state.unit,
            area_density: self.material.area_density,
            inverse_mass: &self.pins.inverse_mass,
            x: &state.x,
            d: &state.d,
            a: &mut self.workspace.a,
        };
        surface.push(self.isa, push);
    }

    pub(crate) fn has_forces(&self) -> bool {
        let plan = &self.plan;
        !plan.explicit.is_zero()
            || plan.hinge_rigidity > 0.0
            || plan.damping > 0.0
            || self.air.is_some()
            || self.is_pushed()
            || self.settings.integrator != Integrator::Verlet
    }

    pub(crate) fn accumulate_graph_forces(&mut self, input: &StepInput<'_>) {
        self.gather_particles(false);
        let half = self.half_kick();
        let (Topology::Graph(graph), Some(strengths)) = (&self.topology, &self.pins.strengths)
        else {
            return;
        };
        let Workspace { a, graph: Some(room), .. } = &mut self.workspace else { return };
        let (isa, plan) = (self.isa, &self.plan);
        room.accumulate_forces(isa, graph, strengths, plan, input.gravity, a);
        if let Some(pushes) = &self.pushes {
            pushes.add(isa, graph.layout, &self.pins.inverse_mass, a);
        }
        if plan.damping > 0.0 {
            let form = self.material.damping_form;
            room.add_damping(isa, graph, strengths, form, half, &self.state, a);
        }
    }
}
