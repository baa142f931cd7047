//! Fourth stage: contact and friction. It ends the substep.

use crate::solver::ClothSolver;
use crate::solver::contact::{self, ContactSettings, ResolveContacts};
use crate::solver::input::StepInput;
use crate::solver::integrate::verlet::Displace;
use crate::solver::settings::Integrator;
use crate::solver::simd::parallel;
use crate::solver::state::State;

/// Without gravity, what only touches is pressed by its weight in this \[m/s2\].
const LEAST_GRAVITY: f32 = 9.81;

impl ClothSolver {
    /// Fourth stage: contact and friction. Ends the substep.
    pub fn collide(&mut self, input: &StepInput<'_>) {
        let meets = !input.colliders.is_empty() || self.state.contacts.now.any;
        if meets {
            let isa = self.isa;
            self.contact_count = self.contacts(input).run(isa);
        } else {
            self.contact_count = 0;
            self.state.contacts.edges.clear();
        }
        self.end_worn(input, meets);
        self.end_filtering();
        let State { x, d, pull, carries, .. } = &mut self.state;
        let pull = carries.then(|| pull.part_mut());
        let band = self.bands.rows.clone();
        parallel::run(self.isa, Displace { band, x: x.part_mut(), d, pull });
        if self.settings.integrator != Integrator::Verlet {
            self.end_explicitly();
        }
        if meets {
            self.go_on_carrying(input);
        }
        self.done += 1;
    }

    /// Contact in this substep.
    pub(in crate::solver) fn contacts<'a>(
        &'a mut self,
        input: &StepInput<'a>,
    ) -> ResolveContacts<'a> {
        let weight = input.gravity.length().max(LEAST_GRAVITY) * self.state.response;
        ResolveContacts {
            bands: &self.bands,
            colliders: input.colliders,
            origin: self.state.origin,
            span: self.span(),
            settings: ContactSettings {
                epsilon: self.material.thickness,
                friction: self.material.friction,
                layers: self.settings.layers,
                most_push: self.settings.max_depenetration_speed * self.plan.step,
                per_weight: 1.0 / weight,
                following: (self.plan.step / contact::FOLLOWING).min(1.0),
                step: self.plan.step,
                notes: self.workspace.filter.is_some(),
            },
            inverse_mass: &mut self.pins.inverse_mass,
            x: &mut self.state.x,
            d: &mut self.state.d,
            pull: self.workspace.filter.is_some().then_some(&mut self.state.pull),
            broad_phase: &mut self.workspace.broad_phase,
            edges: self.settings.edges.then_some(&self.edges),
            max_strain: self.material.max_strain,
            strain: self.survey.max_strain,
            limits: self.settings.provot_passes > 0,
            set: &mut self.state.contacts,
        }
    }
}
