//! Corrections carried on: what threads, shear and tethers did in the last substep is expected again, by
//! half, and the corrections do what is lacking.
//!
//! A correction stands for the force at the substep's end, and where that alone moves the cloth, what swings
//! is damped at the rate `omega^2 h / 2`: the method is Euler's implicit one, of first order. With the
//! forces filtered, `p' = p / 2 + f' h^2 / 2` and `x'' - 2 x' + x = p'`, it is Houbolt's (1950), the
//! generalized-alpha method whose highest frequencies die in a substep (Chung and Hulbert 1993, for a
//! spectral radius of zero): `2 x3 - 5 x2 + 4 x1 - x0 = h^2 f3`, of second order, stable for every step, and
//! what swings is damped at `omega^4 h^3 / 2`.
//!
//! The filter holds the pulls of a particle's springs, not its velocity: gravity, air, bending and contact
//! are no part of it, and an impulse of a collider is neither repeated nor foreseen. The pulls of a cloth
//! sum up to none but at its pins, so that carrying a part of all of them keeps its momentum.
//!
//! What lies on a collider does not follow all of what pulls it, and the collider bears the rest. That is a pull all
//! the same, and is noted as one (`contact`). What holds springs to their strain limit is not carried on, nor is
//! anything where the cloth is far out of shape or struck: there it mends, and is no force that lasts. Threads are of
//! first order there, and on a mesh, whose chains of edges pull one after the other.

use bevy_math::Vec3;

use super::ClothSolver;
use super::bands::CutAt;
use super::contact::NoteUnfollowed;
use super::integrate::Add;
use super::lanes::{PartMut, Soa};
use super::parameters::Integrator;
use super::plan::Form;
use super::state::State;
use super::topology::Topology;

/// Part of the pulls that goes on. A half makes the method one of second order, and is the most that is
/// stable.
const CARRIED: f32 = 0.5;
/// Strain beyond which nothing is carried: what is so far out of shape is to be mended, and a correction
/// that mends is no force that lasts.
const MOST_STRAIN: f32 = 0.5;

/// What a substep notes of its corrections.
pub(super) enum Carry<'a> {
    /// Nothing.
    No,
    /// From where the particles are to be before them \[m\].
    Begin(PartMut<'a>),
    /// The same, with a part of the last substep's.
    GoOn(PartMut<'a>, f32),
}

impl<'a> Carry<'a> {
    /// Notes pulls where any are noted in this tick, and carries on this part of the last ones.
    pub fn new(notes: bool, part: Option<f32>, pull: &'a mut Soa) -> Self {
        match part {
            _ if !notes => Self::No,
            Some(part) => Self::GoOn(pull.part_mut(), part),
            None => Self::Begin(pull.part_mut()),
        }
    }
}

impl CutAt for Carry<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        match self {
            Self::No => (Self::No, Self::No),
            Self::Begin(pull) => {
                let (above, below) = pull.cut(slot);
                (Self::Begin(above), Self::Begin(below))
            }
            Self::GoOn(pull, part) => {
                let (above, below) = pull.cut(slot);
                (Self::GoOn(above, part), Self::GoOn(below, part))
            }
        }
    }
}

impl ClothSolver {
    /// Decides for a tick whether corrections are carried on in it.
    pub(super) fn begin_carrying(&mut self) {
        self.scratch.carries = matches!(self.topology, Topology::Lattice(_))
            && self.plan.form == Form::Threads
            && self.plan.thread_stiffness > 0.0
            && self.settings.integrator == Integrator::Verlet
            && self.survey.max_strain <= MOST_STRAIN;
        self.state.carries &= self.scratch.carries;
    }

    /// Part of the last substep's pulls that goes on in this one, if any does. It is forces that last, and
    /// they move by the square of the step.
    pub(super) fn carried(&self) -> Option<f32> {
        let ratio = self.plan.step / self.state.last_step;
        self.state.carries.then_some(CARRIED * ratio * ratio)
    }

    /// Displacement in the substep that a correction makes for an acceleration of one \[s2\].
    pub(super) fn correction_response(&self) -> f32 {
        if self.state.carries { self.state.response * (1.0 - CARRIED) } else { self.state.response }
    }

    /// Says whether this substep's pulls are to be carried on.
    pub(super) fn end_carrying(&mut self) {
        self.state.carries = self.scratch.carries && !self.scratch.contact.struck;
    }

    /// Leaves out what corrects between this and [`Self::go_on_pulling`].
    pub(super) fn pause_pulls(&mut self) {
        self.note_unfollowed(true);
        self.note_borne(1.0);
        self.note_pulls(1.0);
    }

    /// See [`Self::pause_pulls`].
    pub(super) fn go_on_pulling(&mut self) {
        self.note_unfollowed(false);
        self.note_borne(-1.0);
        self.note_pulls(-1.0);
    }

    /// Particles that corrections see with another mass are pulled by more than they follow: all of it lasts.
    pub(super) fn note_unfollowed(&mut self, adds: bool) {
        if self.scratch.carries {
            self.note_soft_pins(adds);
        }
    }

    /// Adds what colliders bear to the pulls, or takes it away.
    fn note_borne(&mut self, part: f32) {
        if self.scratch.carries && self.state.contacts.now.any {
            let inverse_mass = &self.held.inverse_mass;
            let State { d, pull, contacts: set, .. } = &mut self.state;
            self.isa.run(NoteUnfollowed { set, inverse_mass, d, part, pull });
        }
    }

    /// Adds displacements to the pulls, or takes them away.
    fn note_pulls(&mut self, part: f32) {
        if self.scratch.carries {
            let layout = self.topology.layout();
            let inverse_mass = &self.held.inverse_mass;
            let State { d, pull, .. } = &mut self.state;
            self.isa.run(Add { layout, part, inverse_mass, from: d, to: pull });
        }
    }

    /// Corrections of this tick are not to be carried on any further: something else moves particles as well.
    pub(super) fn stop_carrying(&mut self) {
        self.scratch.carries = false;
        self.state.carries = false;
    }
}

impl State {
    /// Something moves a particle while pulls are noted that is none of them.
    pub(super) fn leave_out(&mut self, slot: usize, moved: Vec3) {
        self.pull.set(slot, self.pull.get(slot) - moved);
    }
}
