//! Friction of bending, applied as often as it has to be.

use crate::solver::ClothSolver;
use crate::solver::forces::bending_friction::{
    Brake, Brakes, EVERY, MOST_OF_SPRINGS, MOST_OF_THREADS, PART, Resist, Thread, WideHinges,
};
use crate::solver::settings::Stretching;
use crate::solver::simd::parallel;
use crate::solver::simd::soa::ValuesMut;
use crate::solver::state::State;
use crate::solver::topology::Topology;
use crate::solver::topology::wide_hinges::widths;

impl ClothSolver {
    /// Brakes what bends, where it is time to.
    pub(crate) fn brake_bending(&mut self) {
        let moment = self.material.bending_friction;
        let every = ((EVERY / self.plan.step).round() as u32).max(1);
        if moment <= 0.0 || !self.done.is_multiple_of(every) {
            return;
        }
        let time = self.plan.step * every.min(self.plan.substeps - self.done) as f32;
        let part = match self.plan.stretching {
            Stretching::ImplicitThreads => MOST_OF_THREADS,
            Stretching::ExplicitSprings => MOST_OF_SPRINGS,
        };
        // Displacement of a mass of one for a force that acts until the next time.
        let most = moment * time * self.state.unit;
        if let Topology::Graph(graph) = &self.topology {
            let State { x, d, .. } = &mut self.state;
            graph.wide_hinges().brake(part, most, &self.pins.inverse_mass, x, d);
            return;
        }
        for thread in [Thread::Weft, Thread::Warp] {
            for width in widths(thread.particles(self.topology.layout())) {
                self.brake_hinges(thread, width, part * PART, most);
            }
        }
    }

    pub(crate) fn brake_hinges(&mut self, thread: Thread, width: usize, part: f32, most: f32) {
        let layout = self.topology.layout();
        let hinges = WideHinges { thread, width, layout };
        let shape = &self.pins.hinges[thread as usize].shape;
        let (band, inverse_mass) = (&self.bands.rows, &self.pins.inverse_mass);
        let State { x, d, .. } = &mut self.state;
        let Brakes { impulses, parts } = &mut self.workspace.brakes;
        let most = 2.0 * most / (width * width) as f32;
        let band = || band.clone();
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
        parallel::run(self.isa, resist);
        let d = d.part_mut();
        parallel::run(self.isa, Brake { band: band(), hinges, inverse_mass, impulses, parts, d });
    }
}
