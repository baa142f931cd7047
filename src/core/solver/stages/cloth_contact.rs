//! Contact of a cloth with itself and with others, in the third stage: after the threads, before the strain limit.

use bevy_math::Mat3;

use crate::solver::ClothSolver;
use crate::solver::cloth_contact::{Lying, Parts, SelfContact, Substep};
use crate::solver::contact::{ActiveSet, Normals};
use crate::solver::state::State;

impl ClothSolver {
    /// Forgets which particles may touch: some have been put elsewhere.
    pub(crate) fn forget_pairs(&mut self) {
        if let Some(own) = &mut self.self_contact {
            own.forget();
        }
        if let Some(others) = &mut self.others_contact {
            others.forget();
        }
    }

    /// Forgets which particles may touch, as the whole cloth has been moved rigidly, and turned if at all. Pairs that touch keep what holds
    /// them: the cloth that it lies on may have been moved as well.
    pub(crate) fn ride_pairs(&mut self, turn: Option<Mat3>) {
        if let Some(own) = &mut self.self_contact {
            own.forget();
        }
        if let Some(others) = &mut self.others_contact {
            others.ride(turn);
        }
    }

    /// Moves apart particles that touch, where the cloth collides with itself. Tells whether any did.
    pub(crate) fn meet_itself(&mut self) -> bool {
        if self.self_contact.is_none() {
            return false;
        }
        self.end_corrections();
        self.touching_itself = self.with_itself(SelfContact::meet).unwrap_or(0);
        self.begin_corrections();
        self.touching_itself > 0
    }

    /// Keeps layers apart that the strain limit has pulled together, where they are pressed into each other.
    pub(crate) fn keep_layers_apart(&mut self) {
        if self.self_contact.as_ref().is_some_and(|own| own.is_pressed()) {
            self.with_itself(SelfContact::keep_apart);
        }
    }

    /// What contact with itself does in a substep, if it has any.
    fn with_itself<T>(
        &mut self,
        act: impl FnOnce(&mut SelfContact, Substep<'_>) -> T,
    ) -> Option<T> {
        let Self { self_contact, isa, pins, state, plan, settings, .. } = self;
        let State { x, d, contacts, .. } = state;
        let on = Substep {
            isa: *isa,
            inverse_mass: &pins.inverse_mass,
            x,
            d,
            lying: lying(contacts, plan.step),
            most_push: settings.max_depenetration_speed * plan.step,
        };
        self_contact.as_mut().map(|own| act(own, on))
    }

    /// What contact with other cloths takes of it in a substep, where it collides with others.
    pub(in crate::solver) fn parts(&mut self, moves: bool) -> Option<Parts<'_>> {
        let part = self.span();
        let Self { others_contact, isa, pins, state, plan, settings, drift, .. } = self;
        let State { x, d, contacts, origin, .. } = state;
        Some(Parts {
            isa: *isa,
            moves,
            origin: *origin + *drift * part.to,
            drift: *drift * (part.to - part.from),
            inverse_mass: &pins.inverse_mass,
            x,
            d,
            lying: lying(contacts, plan.step),
            most_push: settings.max_depenetration_speed * plan.step,
            others: others_contact.as_mut()?,
        })
    }
}

/// Where particles lie on colliders, if any do.
fn lying(contacts: &mut ActiveSet, step: f32) -> Option<Lying<'_>> {
    let ActiveSet { now, velocity, load, .. } = contacts;
    let Normals { normal, slip, loose, .. } = &*now;
    now.any.then_some(Lying { normal, slip, loose, velocity, step, load })
}
