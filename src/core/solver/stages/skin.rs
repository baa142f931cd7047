//! Particles are held to the skin: last in the third stage, and once more at the tick's end, as colliders push.

use crate::solver::ClothSolver;
use crate::solver::constraints::skin::HoldToSkin;
use crate::solver::simd::parallel;
use crate::solver::state::State;

/// How often the skin holds in a tick at most. Bodies are much slower than threads, and what holds at the tick's end is within its
/// bounds there. With five, bounds that bear a load leave threads three times as much strain.
const TIMES: u32 = 7;

impl ClothSolver {
    /// Draws particles to the skin and holds them to its bounds, where the cloth has one: in every substep of a few, and in the last.
    pub(crate) fn hold_to_skin(&mut self) {
        let (done, all) = (self.done + 1, self.plan.substeps);
        let every = all.div_ceil(TIMES);
        let since = if done.is_multiple_of(every) { every } else { done % every };
        if since == every || done == all {
            self.hold_within(self.plan.step, since);
        }
    }

    /// Holds particles to the bounds of the skin, at the end of a tick.
    pub(crate) fn end_within_skin(&mut self) {
        self.hold_within(0.0, 0);
    }

    /// Drives draw for so many substeps of a length \[s\], those since they last did.
    fn hold_within(&mut self, step: f32, since: u32) {
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
            since: since as f32 * step,
            inverse_mass: &pins.inverse_mass,
            x,
            d: d.part_mut(),
            pull: workspace.filter.is_some().then(|| pull.part_mut()),
        };
        parallel::run(*isa, hold);
    }
}
