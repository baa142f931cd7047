//! Momentum that the cloth gives to the colliders that are measured.
//!
//! The pulls of a cloth sum up to none, and so does what is carried on of them (`integrate::houbolt`). Where a collider bears
//! a pull that is not noted, what is carried on of the opposite pulls has no counterpart: half of it moves the cloth in the
//! next substep, a quarter in the one after. The collider gives that momentum, or takes it, for as long as pulls are
//! carried on.

use bevy_math::{Mat3, Vec3};

use crate::solver::contact::collider::Collider;

/// The impulses of a tick.
#[derive(Clone, Debug, Default)]
pub(crate) struct Impulses {
    /// By collider; `None` where it is not measured. Empty where none is.
    colliders: Vec<Option<Impulse>>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    /// Momentum that the cloth has given \[kg m/s\].
    given: Vec3,
    /// Momentum that it gives in the substeps to come, as pulls are carried on.
    owed: Vec3,
}

/// Momentum that a collider is given in a substep, times the substep \[kg m\].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Share {
    pub collider: usize,
    pub given: Vec3,
    pub owed: Vec3,
}

impl Impulses {
    /// Puts what is known of colliders at their new `place`s, of which there are so many; `None` is none.
    pub fn renumber(&mut self, count: usize, place: impl Fn(usize) -> Option<usize>) {
        if self.colliders.is_empty() {
            return;
        }
        let mut colliders = vec![None; count.max(self.colliders.len())];
        for (collider, impulse) in self.colliders.iter().enumerate() {
            if let Some(to) = place(collider).and_then(|place| colliders.get_mut(place)) {
                *to = *impulse;
            }
        }
        self.colliders = colliders;
    }

    /// Begins a tick with these colliders, which are those of the last one as far as they are at the same places.
    pub fn begin_tick(&mut self, colliders: &[Collider<'_>]) {
        let count = if colliders.iter().any(|c| c.measured) { colliders.len() } else { 0 };
        self.colliders.resize(count, None);
        for (impulse, collider) in self.colliders.iter_mut().zip(colliders) {
            let owed = impulse.unwrap_or_default().owed;
            *impulse = collider.measured.then_some(Impulse { given: Vec3::ZERO, owed });
        }
    }

    /// Whether any collider is measured.
    pub fn are_measured(&self) -> bool {
        !self.colliders.is_empty()
    }

    /// Begins a substep that carries on a part of the pulls, or none.
    pub fn carry_on(&mut self, part: Option<f32>) {
        for impulse in self.colliders.iter_mut().flatten() {
            impulse.owed *= part.unwrap_or(0.0);
            impulse.given += impulse.owed;
        }
    }

    /// Gives shares of a substep of length `step`.
    pub fn give(&mut self, shares: impl IntoIterator<Item = Share>, step: f32) {
        if !self.are_measured() {
            return;
        }
        for Share { collider, given, owed } in shares {
            if let Some(Some(impulse)) = self.colliders.get_mut(collider) {
                impulse.given += given / step;
                impulse.owed += owed / step;
            }
        }
    }

    /// Turns what is owed with the cloth.
    pub fn turn(&mut self, turn: Mat3) {
        for impulse in self.colliders.iter_mut().flatten() {
            impulse.owed = turn * impulse.owed;
        }
    }

    /// Momentum that is owed, to be kept with the rest of the state.
    pub fn owed(&self) -> Vec<Option<Vec3>> {
        self.colliders.iter().map(|impulse| impulse.map(|impulse| impulse.owed)).collect()
    }

    /// Puts back what was owed.
    pub fn set_owed(&mut self, owed: &[Option<Vec3>]) {
        let impulse = |owed| Impulse { given: Vec3::ZERO, owed };
        self.colliders = owed.iter().map(|owed| owed.map(impulse)).collect();
    }

    pub fn clear(&mut self) {
        self.colliders.clear();
    }

    /// Momentum that a collider was given in the tick \[kg m/s\]; zero where it is not measured.
    pub fn of(&self, collider: usize) -> Vec3 {
        self.colliders.get(collider).copied().flatten().unwrap_or_default().given
    }
}
