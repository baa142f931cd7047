//! A sheet's forces: springs and hinges in one pass over the rows, damping in two.

use crate::solver::forces::bending::Bend;
use crate::solver::forces::bending_friction::{Brake, Brakes, PART, Resist, Thread, WideHinges};
use crate::solver::forces::damping::{AddDamping, DampedSprings, DampingTarget};
use crate::solver::forces::springs::AccumulateForces;
use crate::solver::model::sheet::{Sheet, SheetWorkspace};
use crate::solver::model::{Acting, Particles};
use crate::solver::simd::parallel;
use crate::solver::simd::soa::{Soa, ValuesMut};
use crate::solver::state::State;
use crate::solver::topology::wide_hinges::widths;

impl Sheet {
    /// Accelerations by springs, hinges and gravity.
    pub(super) fn accumulate_forces(
        &mut self,
        on: &mut Particles<'_>,
        acting: &Acting<'_>,
        a: &mut Soa,
    ) {
        let Self { lattice, hinges, workspace, .. } = self;
        let Acting { plan, gravity, .. } = *acting;
        let (layout, rigidity, x) = (lattice.layout, plan.explicit.bend, &on.state.x);
        let SheetWorkspace { rows, moments, .. } = workspace;
        let forces = AccumulateForces {
            band: on.bands.rows.clone(),
            lattice,
            constants: plan.explicit,
            bend: (rigidity > 0.0).then_some(Bend { hinges, rigidity, layout, x }),
            gravity,
            inverse_mass: &on.pins.inverse_mass,
            x,
            a: a.part_mut(),
            rows,
            moments,
        };
        parallel::run(on.isa, forces);
    }

    /// Damping with the velocity of this instant, not of half a substep ago: a half kick predicts it,
    /// without which the whole scheme would be of first order; and so it would, were drag left out of it.
    pub(super) fn add_damping(&mut self, on: &mut Particles<'_>, acting: &Acting<'_>, a: &mut Soa) {
        let SheetWorkspace { predicted, rows, .. } = &mut self.workspace;
        let (rows, state, half) = (&*rows, &*on.state, acting.half_kick);
        let springs = DampedSprings {
            lattice: &self.lattice,
            damping: acting.plan.damping / state.unit,
            form: acting.damping_form,
            shear: acting.plan.shear_stiffness > 0.0,
            inverse_mass: &on.pins.inverse_mass,
            x: &state.x,
        };
        let gain = half.gain * state.unit;
        let band = &on.bands.rows;
        let target =
            DampingTarget::Predict { keep: half.decay, gain, a, predicted: predicted.part_mut() };
        let damping = AddDamping { band: band.clone(), springs, d: &state.d, rows, target };
        parallel::run(on.isa, damping);
        let target = DampingTarget::Accelerations(a.part_mut());
        let damping = AddDamping { band: band.clone(), springs, d: predicted, rows, target };
        parallel::run(on.isa, damping);
    }

    /// Slows the bending of both threads, hinges of each width after the other.
    pub(super) fn brake_threads(&mut self, mut on: Particles<'_>, part: f32, most: f32) {
        for thread in [Thread::Weft, Thread::Warp] {
            for width in widths(thread.particles(self.lattice.layout)) {
                self.brake_hinges(&mut on, thread, width, part * PART, most);
            }
        }
    }

    fn brake_hinges(
        &mut self,
        on: &mut Particles<'_>,
        thread: Thread,
        width: usize,
        part: f32,
        most: f32,
    ) {
        let hinges = WideHinges { thread, width, layout: self.lattice.layout };
        let shape = &self.hinges[thread as usize].shape;
        let (band, inverse_mass) = (|| on.bands.rows.clone(), &on.pins.inverse_mass);
        let State { x, d, .. } = &mut *on.state;
        let Brakes { impulses, parts } = &mut self.workspace.brakes;
        let most = 2.0 * most / (width * width) as f32;
        let resist = Resist {
            band: band(),
            hinges,
            shape,
            part,
            most,
            inverse_mass,
            x,
            d,
            to: impulses.part_mut(),
            parts: ValuesMut::all(parts),
        };
        parallel::run(on.isa, resist);
        let d = d.part_mut();
        parallel::run(on.isa, Brake { band: band(), hinges, inverse_mass, impulses, parts, d });
    }
}
