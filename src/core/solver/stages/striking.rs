//! How fast bodies come to a cloth in a tick, and what follows for its plan (`state::striking`).

use bevy_math::Vec3;
use bevy_math::bounding::Aabb3d;

use crate::solver::ClothSolver;
use crate::solver::contact::{self, Collider};
use crate::solver::input::StepInput;
use crate::solver::state::striking::Striking;

impl ClothSolver {
    /// Finds how many substeps the bodies ask for that may strike the cloth in a tick. Only cloth that is held by what does not move can be struck
    /// through: other cloth is taken along.
    pub(crate) fn look_out(&mut self, input: &StepInput<'_>) {
        let particle = self.topology.total_area() * self.material.area_density
            / self.topology.particle_count() as f32;
        // Through what is lighter than a particle the cloth may pass.
        let is_body = |it: &Collider<'_>| {
            let weight = it.mobility.map_or(0.0, |mobility| mobility.inverse_mass * particle);
            weight > 0.0 && weight < 1.0 && it.layers & self.settings.layers != 0
        };
        let holds = !input.pins.is_empty() && input.pulls.is_empty();
        let has_any = holds && input.colliders.iter().any(is_body);
        if !has_any && self.state.striking == Striking::NONE {
            return;
        }
        let mut way = 0.0_f32;
        if has_any {
            let (bounds, rest) = (self.bounds(), self.mean_way_of_pins(input));
            for body in input.colliders.iter().filter(|it| is_body(it)) {
                let goes = body.way() - rest;
                if self.may_strike(bounds, body, goes) {
                    way = way.max(goes.length());
                }
            }
        }
        let spacing = (self.topology.total_area() / self.topology.particle_count() as f32).sqrt();
        self.state.striking.follow(way / input.dt, spacing, input.dt);
    }

    /// Whether a body that `goes` so far in the tick may be at a cloth between `low` and `high` in this one or the next.
    fn may_strike(&self, (low, high): (Vec3, Vec3), body: &Collider<'_>, goes: Vec3) -> bool {
        let Some(Aabb3d { min, max }) = body.motion.bounds() else { return true };
        let gap = contact::box_gap(low, high, &Aabb3d { min, max }) - self.material.thickness;
        let comes = (low + high - Vec3::from(min + max)).dot(goes) > 0.0;
        gap < 0.0 || comes && gap < 2.0 * goes.length()
    }
}
