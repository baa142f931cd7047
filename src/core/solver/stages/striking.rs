//! How fast bodies come to a cloth in a tick, and what follows for its plan (`state::striking`).

use crate::solver::ClothSolver;
use crate::solver::contact::{self, Collider};
use crate::solver::input::StepInput;
use crate::solver::state::striking::Striking;

impl ClothSolver {
    /// Finds how many substeps the bodies ask for that may strike the cloth in a tick. Only cloth that is held can be struck through: other cloth is
    /// taken along.
    pub(crate) fn look_out(&mut self, input: &StepInput<'_>) {
        let before = self.state.striking;
        let holds = !self.pins.slots.is_empty() || !self.soft.is_empty();
        let is_body =
            |collider: &Collider<'_>| collider.mobility.is_some_and(|it| it.inverse_mass > 0.0);
        if before == Striking::NONE && !(holds && input.colliders.iter().any(is_body)) {
            return;
        }
        let (layers, epsilon) = (self.settings.layers, self.material.thickness);
        let (low, high) = self.bounds();
        let rest = self.mean_way_of_pins(input);
        let mut way = 0.0_f32;
        for body in
            input.colliders.iter().filter(|it| holds && is_body(it) && it.layers & layers != 0)
        {
            let goes = (body.way() - rest).length();
            // It may be there in the next tick.
            let reach = epsilon + 2.0 * goes;
            if body
                .motion
                .bounds()
                .is_none_or(|bounds| contact::box_gap(low, high, &bounds) < reach)
            {
                way = way.max(goes);
            }
        }
        let spacing = (self.topology.total_area() / self.topology.particle_count() as f32).sqrt();
        self.state.striking.follow(way / input.dt, spacing, input.dt);
    }
}
