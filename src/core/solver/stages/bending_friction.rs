//! Friction of bending, applied as often as it has to be.

use crate::solver::ClothSolver;
use crate::solver::forces::bending_friction::{EVERY, MOST_OF_SPRINGS, MOST_OF_THREADS};
use crate::solver::settings::Stretching;

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
        let (model, on) = self.model_and_particles();
        model.brake_bending(on, part, most);
    }
}
