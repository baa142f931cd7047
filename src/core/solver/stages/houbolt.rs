//! Which corrections are carried on to the next substep, and what is noted of them.

use crate::solver::ClothSolver;
use crate::solver::contact::NoteUnfollowed;
use crate::solver::integrate::houbolt::{Filter, MOST_STRAIN};
use crate::solver::integrate::verlet::Add;
use crate::solver::settings::{Integrator, Stretching};
use crate::solver::state::State;

impl ClothSolver {
    /// Decides for a tick how its corrections are carried on.
    pub(crate) fn begin_filtering(&mut self) {
        let carries = self.plan.stretching == Stretching::ImplicitThreads
            && self.plan.thread_stiffness > 0.0
            && self.settings.integrator == Integrator::Verlet
            && self.survey.max_strain <= MOST_STRAIN;
        let touches = self.state.contacts.now.any;
        let usual = if carries { self.model.stages().filter(touches) } else { None };
        let is_loaded = self.state.carrying.mass_scale > 1.0;
        self.workspace.filter = usual.map(|it| if is_loaded { Filter::OF_FIRST_ORDER } else { it });
        self.state.carries &= self.workspace.filter.is_some();
    }

    /// How the last substep's pulls go on in this one, if they do. It is forces that last, and they move by the square of the step.
    pub(crate) fn carried(&self) -> Option<Filter> {
        let ratio = self.plan.step / self.state.last_step;
        self.going_on().map(|filter| Filter { keeps: filter.keeps * ratio * ratio, ..filter })
    }

    /// Displacement in the substep that a correction makes for an acceleration of one \[s2\].
    pub(crate) fn correction_response(&self) -> f32 {
        self.state.response * self.going_on().map_or(1.0, |filter| filter.now)
    }

    /// The filter, where the last substep's forces stay in this one's.
    fn going_on(&self) -> Option<Filter> {
        if self.state.carries { self.workspace.filter } else { None }
    }

    /// Says whether this substep's pulls are to be carried on.
    pub(crate) fn end_filtering(&mut self) {
        self.state.carries = self.workspace.filter.is_some() && !self.workspace.broad_phase.struck;
    }

    /// Leaves out what corrects between this and [`Self::go_on_pulling`].
    pub(crate) fn pause_pulls(&mut self) {
        self.note_unfollowed(true);
        self.note_borne(1.0);
        self.note_pulls(1.0);
    }

    /// See [`Self::pause_pulls`].
    pub(crate) fn go_on_pulling(&mut self) {
        self.note_unfollowed(false);
        self.note_borne(-1.0);
        self.note_pulls(-1.0);
    }

    /// Particles that corrections see with another mass are pulled by more than they follow: all of it lasts.
    pub(crate) fn note_unfollowed(&mut self, adds: bool) {
        if self.workspace.filter.is_some() {
            self.note_soft_pins(adds);
        }
    }

    /// Adds what colliders bear to the pulls, or takes it away.
    pub(crate) fn note_borne(&mut self, part: f32) {
        if self.workspace.filter.is_some() && self.state.contacts.now.any {
            let inverse_mass = &self.pins.inverse_mass;
            let State { d, pull, contacts: set, .. } = &mut self.state;
            self.isa.run(NoteUnfollowed { set, inverse_mass, d, part, pull });
        }
    }

    /// Adds displacements to the pulls, or takes them away.
    pub(crate) fn note_pulls(&mut self, part: f32) {
        if self.workspace.filter.is_some() {
            let layout = self.topology.layout();
            let inverse_mass = &self.pins.inverse_mass;
            let State { d, pull, .. } = &mut self.state;
            self.isa.run(Add { layout, part, inverse_mass, from: d, to: pull });
        }
    }

    /// Corrections of this tick are not to be carried on any further: something else moves particles as well.
    pub(crate) fn stop_filtering(&mut self) {
        self.workspace.filter = None;
        self.state.carries = false;
    }
}
