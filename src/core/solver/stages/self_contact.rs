//! Contact of a cloth with itself, in the third stage: after the threads, before the strain limit.

use crate::solver::ClothSolver;
use crate::solver::self_contact::Substep;
use crate::solver::state::State;

impl ClothSolver {
    /// Moves apart particles that touch, where the cloth collides with itself. Tells whether any did.
    pub(crate) fn meet_itself(&mut self) -> bool {
        if self.self_contact.is_none() {
            return false;
        }
        self.end_corrections();
        let Self { self_contact, isa, bands, pins, state, workspace, plan, settings, .. } = self;
        let State { x, d, pull, contacts, .. } = state;
        let lies = contacts.now.any;
        let touching = self_contact.as_mut().map_or(0, |own| {
            own.meet(Substep {
                isa: *isa,
                band: bands.rows.clone(),
                inverse_mass: &pins.inverse_mass,
                x,
                d,
                pull: workspace.carries.then_some(pull),
                unpulled: lies.then_some(&mut contacts.unpulled),
                most_push: settings.max_depenetration_speed * plan.step,
            })
        });
        self.touching_itself = touching;
        self.begin_corrections();
        touching > 0
    }
}
