//! Impulses that the cloth gave the colliders that are measured, and the bodies that it moves.

use crate::solver::ClothSolver;
use crate::solver::contact::Impulse;
#[cfg(doc)]
use crate::solver::{Collider, Mobility};

impl ClothSolver {
    /// The impulse that the cloth gave a collider in the last tick, by the collider's place in the input: momentum, and angular momentum
    /// about its [`centre`](Collider::centre). Of colliders of one [`body`](Collider::body) the first has it all. Zero where it was
    /// not asked to be [`measured`](Collider::measured), and after a tick that was undone.
    pub fn impulse(&self, collider: usize) -> Impulse {
        self.state.contacts.impulses.of_whole(collider)
    }

    /// [`impulse`](Self::impulse) as a body that the cloth moves took it. A light rod that turns very easily about its length is taken to turn
    /// less easily: less of the angular momentum about that is its own.
    pub fn impulse_taken(&self, collider: usize) -> Impulse {
        self.state.contacts.impulses.of_whole_as_told(collider)
    }

    /// The impulse that whatever moves a body is to give it after the last tick, by its place in the input, for the cloth to carry it
    /// (see [`Mobility`]). Over time it sums up to [`impulse_taken`](Self::impulse_taken); it is a tick ahead, as far as the cloth is expected
    /// to go on as it does. The angular part makes up for how far the body has gone since.
    pub fn body_impulse(&self, collider: usize) -> Impulse {
        self.state.contacts.impulses.answer(collider)
    }

    /// The part of [`body_impulse`](Self::body_impulse) that the cloth is expected to give in the next tick, by the body's
    /// [`key`](Collider::key). In a tick that the cloth does not take, as it sleeps, it gives the body this.
    pub fn expected_impulse(&self, key: u64) -> Impulse {
        let contacts = &self.state.contacts;
        let at = contacts.keys.position(key);
        at.map_or(Impulse::ZERO, |collider| contacts.impulses.expected(collider))
    }
}
