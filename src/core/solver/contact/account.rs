//! The account of a collider that is measured, or is a body.

use bevy_math::{Mat3, Vec3};

use crate::solver::contact::coupling::Coupling;
use crate::solver::contact::easy_turns::Tempered;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::{Deviation, Mobility, Twist};
use crate::solver::simd::block::{larger, smaller};

/// What a collider is given in a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Account {
    /// Impulse that the cloth has given.
    pub given: Impulse,
    /// Angular momentum that the engine's body lacks about the end of its way, where it is given the impulse: the cloth gave it
    /// elsewhere.
    pub late: Vec3,
    /// The momentum that this is known of \[kg m/s\].
    pub told: Vec3,
    /// Impulse that it gives in the substeps to come, as pulls are carried on.
    pub owed: Impulse,
    /// The place that angular impulses are about, in the cloth's coordinates \[m\].
    pub about: Vec3,
    /// What it moves by, where it is a body.
    pub mobility: Option<Mobility>,
    /// Part of an angular impulse that its engine is given; `None` where that is all of it.
    pub told_part: Option<Mat3>,
    /// How far that has moved it from where it was planned to be, up to the substep.
    pub deviation: Deviation,
    /// Where that is planned to be when the tick begins and when it ends.
    pub ways: [Vec3; 2],
    /// Whether it is among those that are live.
    pub live: bool,
    /// Whether the cloth may have come to it in this tick, or pulls at it.
    pub met: bool,
    /// How many pins pull at it.
    pub pins: u32,
    /// Whether any of them is a spring.
    pub is_sprung: bool,
    /// Whether the cloth passes through it, as it is pinned within it.
    pub passed: bool,
    /// What goes on from tick to tick.
    pub coupling: Coupling,
    /// What the engine is to be given of the last tick.
    pub answer: Impulse,
}

impl Account {
    pub fn owing(owed: Impulse, coupling: Coupling) -> Self {
        Self {
            given: Impulse::ZERO,
            late: Vec3::ZERO,
            told: Vec3::ZERO,
            owed,
            about: Vec3::ZERO,
            mobility: None,
            told_part: None,
            deviation: Deviation::NONE,
            ways: [Vec3::ZERO; 2],
            live: false,
            met: false,
            pins: 0,
            is_sprung: false,
            passed: false,
            coupling,
            answer: Impulse::ZERO,
        }
    }

    /// Begins to be among those that are live, in a tick of `dt` \[s\].
    pub fn come_alive(&mut self, dt: f32) {
        self.live = true;
        if let Some(mobility) = self.mobility {
            let Tempered { mobility, told_part } = Tempered::new(mobility, dt);
            (self.mobility, self.told_part) = (Some(mobility), told_part);
        }
    }

    /// Goes on to be at a place.
    pub fn go_to(&mut self, place: Vec3) {
        let since = self.given.linear - self.told;
        self.late += (self.about - self.ways[1]).cross(since);
        (self.told, self.about) = (self.given.linear, place);
    }

    /// The angular momentum that it lacks when the tick ends, and it has gone to its place. The impulse that was expected has been
    /// given to the engine's body where its way begins; there its weight acts as well, for the engine. What bears that lacks nothing.
    pub fn lacking(&self, falls: Vec3) -> Vec3 {
        let (way, expected) = (self.ways[1] - self.ways[0], self.coupling.expected.linear);
        let weight = self.mobility.map_or(0.0, |it| falls.length() / it.inverse_mass);
        let up = -falls.normalize_or_zero();
        let borne = larger(smaller(expected.dot(up), weight), 0.0);
        self.late + way.cross(expected - up * (0.5 * borne))
    }

    /// An impulse as its engine is given it.
    pub fn as_told(&self, impulse: Impulse) -> Impulse {
        let Impulse { linear, angular } = impulse;
        Impulse { linear, angular: self.told_part.map_or(angular, |part| part * angular) }
    }

    /// Whether nothing is left of what the cloth has done to it.
    pub fn rests(&self) -> bool {
        !self.met && self.owed == Impulse::ZERO && self.coupling == Coupling::NONE
    }

    /// Drops sums that are no numbers. A particle that is pushed out of a solid as far as the universe is wide has an arm that overflows,
    /// though it comes back within the tick.
    pub fn drop_what_is_no_number(&mut self) {
        for sum in [&mut self.given, &mut self.owed] {
            for vector in [&mut sum.linear, &mut sum.angular] {
                if !vector.is_finite() {
                    *vector = Vec3::ZERO;
                }
            }
        }
        if !self.late.is_finite() {
            self.late = Vec3::ZERO;
        }
        if !self.deviation.is_valid() {
            self.deviation = Deviation::NONE;
        }
    }

    /// Whether the cloth is expected to change the body's speed by more than `least` \[m/s\] in the direction `up` in a tick.
    pub fn is_carried(&self, up: Vec3, least: f32) -> bool {
        let weight = self.mobility.map_or(0.0, |mobility| mobility.inverse_mass);
        self.coupling.expected.linear.dot(up) * weight > least
    }

    /// Whether the cloth has changed the body's speed by more than `least` \[m/s\] in the direction `up` in this tick.
    pub fn is_pushed(&self, up: Vec3, least: f32) -> bool {
        let weight = self.mobility.map_or(0.0, |mobility| mobility.inverse_mass);
        self.given.linear.dot(up) * weight > least
    }

    /// Velocity that the body has beside the planned one, after a part of the tick: of what it was given and not expected to be.
    pub fn velocity(&self, part: f32) -> Twist {
        let unplanned = self.given - self.coupling.expected * part;
        self.mobility.map_or(Twist::default(), |mobility| mobility.motion(unplanned))
    }
}
