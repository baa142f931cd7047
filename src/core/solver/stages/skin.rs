//! Particles are held to the skin: last in the third stage, and once more at the tick's end, as colliders push.

use crate::solver::ClothSolver;
use crate::solver::constraints::skin::HoldToSkin;
use crate::solver::simd::parallel;
use crate::solver::state::State;

impl ClothSolver {
    /// Draws particles to the skin and holds them to its bounds, where the cloth has one.
    pub(crate) fn hold_to_skin(&mut self) {
        self.hold_within(self.plan.step);
    }

    /// Holds particles to the bounds of the skin at the end of the tick's last substep.
    pub(crate) fn end_within_skin(&mut self) {
        if self.done + 1 == self.plan.substeps {
            self.hold_within(0.0);
        }
    }

    fn hold_within(&mut self, step: f32) {
        let span = self.span();
        let Self { skin: Some(skin), state, workspace, pins, bands, isa, .. } = self else {
            return;
        };
        let State { x, d, pull, .. } = state;
        let hold = HoldToSkin {
            band: bands.rows.clone(),
            skin,
            passed: span.to,
            part: span.to - span.from,
            step,
            inverse_mass: &pins.inverse_mass,
            x,
            d: d.part_mut(),
            pull: workspace.carries.then(|| pull.part_mut()),
        };
        parallel::run(*isa, hold);
    }
}
