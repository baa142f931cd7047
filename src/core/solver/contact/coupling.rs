//! The exchange of a body between the engine that moves it and the cloth that does.
//!
//! The engine moves a body over a tick, and then the cloth does (`mobility`). What the cloth has given it the engine learns at the tick's
//! end: half a tick late. A swing that is answered half a tick late grows, by `(w dt)^2 / 4` in each tick for a frequency `w`: a ball
//! of one kilogram is thrown off a hammock. So the engine is given beforehand what the cloth is expected to give in the next tick, which
//! is what it gave in the last one, and later the difference to what it did. A swing then decays by as much. A body that the
//! cloth carries comes to rest, and the engine finds it at rest: its weight is balanced when it looks.
//!
//! A body is given at a tick's end what the cloth gave it elsewhere on its way. The angular impulse makes up for that
//! (`Account::lacking`), so that cloth and body keep their angular momentum as well.

use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::Deviation;

/// Speed by which the expected impulse changes in a tick at most \[m/s\]. What is struck is not expected to be struck again as hard.
const MOST_CHANGE: f32 = 1.0;
/// Part by which the expected impulse follows, where springs of soft pins pull at the body. They are fast beside a tick: what they did in one
/// is no more than a hint of what they do in the next. Where pins hold to it without springs, an expectation that followed by half would swing it
/// up: a crate of 5 kg in a sling, pushed by 2.5 m/s, came to four times its energy.
const SPRUNG: f32 = 0.5;
/// Part of a deviation that is left after a tick. The engine's body is elsewhere than the cloth's, as it learned of impulses late.
/// The cloth's comes to it with a little speed, and does not jump into what lies on it.
const LEFT: f32 = 0.75;

/// What a cloth remembers of a body from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Coupling {
    /// Impulse that the engine was given in expectation of the tick.
    pub expected: Impulse,
    /// How far the cloth's body was from the engine's when the tick began.
    pub ahead: Deviation,
}

impl Coupling {
    pub const NONE: Self = Self { expected: Impulse::ZERO, ahead: Deviation::NONE };

    /// How far the cloth's body is from the engine's after a part of the tick, before the cloth moves it.
    pub fn ahead_at(&self, part: f32) -> Deviation {
        self.ahead.part(1.0 - (1.0 - LEFT) * part)
    }

    /// Ends a tick in which the cloth has given the body so much and moved it so far from its planned way. Returns what the engine is to be
    /// given.
    pub fn end_tick(
        &mut self,
        given: Impulse,
        moved: &Deviation,
        inverse_mass: f32,
        is_sprung: bool,
    ) -> Impulse {
        let change = given - self.expected;
        let speed = change.linear.length() * inverse_mass;
        let part = if speed > MOST_CHANGE { MOST_CHANGE / speed } else { 1.0 };
        let part = if is_sprung { part * SPRUNG } else { part };
        let next = self.expected + change * part;
        let ahead = self.ahead_at(1.0).and(moved);
        *self = Self { expected: next, ahead };
        change + next
    }
}
