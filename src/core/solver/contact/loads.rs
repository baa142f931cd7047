//! Particles that bear a load: pressed onto a collider by more than their own weight.
//!
//! A collider that stops a particle ends its threads as a pin does, but corrections do not know: they
//! would move it as one that is free, and half of each correction would be undone by contact. Where a
//! cloth hangs from a point (the tip of an ear, a horn) what is left over adds up, and threads are
//! stretched far beyond what they carry. So corrections see a particle that bore a load in the substep
//! before as one that weighs more (mass scaling at contacts: Macklin, Müller, Chentanez and Kim 2014,
//! section 5.2), and threads and contact are solved together, nearly.

use bevy_math::Vec3;

use super::super::ClothSolver;

/// The load from which a particle counts as loaded, in weights of a particle. Cloth that lies in a few
/// layers, or is laid over an edge, is below it.
const LEAST_LOAD: f32 = 32.0;
/// Without gravity, its weight is that in this \[m/s2\]: what only touches bears nothing.
const LEAST_GRAVITY: f32 = 9.81;
/// What corrections see of a loaded particle's inverse mass. At a tenth the threads end there as well as
/// they do at a pin; at less, what slides off slowly is held.
const SEEN: f32 = 0.1;
/// What it does not follow of a correction, to what it does.
const UNFOLLOWED: f32 = 1.0 / SEEN - 1.0;

/// Substeps in a row in which a particle is pressed so before it bears a load: what only falls onto a
/// collider is pressed once.
const SUBSTEPS: u8 = 2;

/// Particles that were pressed onto colliders in a substep.
#[derive(Clone, Debug)]
pub(in crate::solver) struct Loads {
    /// Those that bear a load, in the order in which they were found.
    list: Vec<Load>,
    /// All slots that were pressed.
    pressed: Vec<usize>,
    /// For how many substeps in a row a slot's particle has been.
    since: Vec<u8>,
}

#[derive(Clone, Copy, Debug)]
struct Load {
    slot: usize,
    /// The collider that bears it, where it wants to know.
    given_to: Option<usize>,
    /// The particle's own inverse mass, while corrections see another \[1/kg\].
    inverse_mass: f32,
    /// Its displacement before the corrections \[m\].
    before: Vec3,
    /// That from which on it has not been noted what it does not follow \[m\].
    noted: Vec3,
}

/// Acceleration towards a collider from which a particle counts as loaded \[m/s2\].
pub(in crate::solver) fn least_load(gravity: Vec3) -> f32 {
    LEAST_LOAD * gravity.length().max(LEAST_GRAVITY)
}

impl Loads {
    /// Room for all particles.
    pub fn new(slots: usize) -> Self {
        let (list, pressed) = (Vec::with_capacity(slots), Vec::with_capacity(slots));
        Self { list, pressed, since: vec![0; slots] }
    }

    pub fn clear(&mut self) {
        self.list.clear();
        for slot in self.pressed.drain(..) {
            self.since[slot] = 0;
        }
    }

    /// What contact undoes at least where a particle is loaded, if it is `least` where it was seen with
    /// its own mass \[m\].
    #[inline(always)]
    pub fn least(&self, slot: usize, least: f32) -> f32 {
        if self.since[slot] >= SUBSTEPS { least * SEEN } else { least }
    }

    /// The least of that anywhere.
    #[inline(always)]
    pub fn least_of_all(least: f32) -> f32 {
        least * SEEN
    }

    /// Notes that a particle is pressed onto a collider; `before` is what is known of the substep before.
    pub fn add(&mut self, slot: usize, given_to: Option<usize>, before: &Self) {
        if self.since[slot] > 0 {
            return;
        }
        self.pressed.push(slot);
        self.since[slot] = before.since[slot].saturating_add(1);
        if self.since[slot] >= SUBSTEPS {
            self.list.push(Load {
                slot,
                given_to,
                inverse_mass: 0.0,
                before: Vec3::ZERO,
                noted: Vec3::ZERO,
            });
        }
    }
}

impl ClothSolver {
    /// Gives loaded particles the mass that corrections are to see.
    pub(in crate::solver) fn weigh_loads(&mut self) {
        let loads = &mut self.scratch.contact.loads;
        for load in &mut loads.list {
            let seen = self.held.inverse_mass[load.slot] * SEEN;
            load.inverse_mass = self.held.set_inverse_mass(&self.topology, load.slot, seen);
            load.before = self.state.d.get(load.slot);
            load.noted = load.before;
        }
    }

    /// Adds to the pulls of loaded particles what they did not follow of the corrections since it was noted last,
    /// or only goes on from here.
    pub(in crate::solver) fn note_loads(&mut self, adds: bool) {
        for load in &mut self.scratch.contact.loads.list {
            let d = self.state.d.get(load.slot);
            if adds {
                self.state.leave_out(load.slot, (d - load.noted) * -UNFOLLOWED);
            }
            load.noted = d;
        }
    }

    /// Gives them their own again. What they did not follow of the corrections, their colliders bore.
    pub(in crate::solver) fn unweigh_loads(&mut self) {
        let room = &mut self.scratch.contact;
        for load in &room.loads.list {
            self.held.set_inverse_mass(&self.topology, load.slot, load.inverse_mass);
            let unfollowed = (self.state.d.get(load.slot) - load.before) * UNFOLLOWED;
            if let Some(collider) = load.given_to {
                room.impulses[collider] += unfollowed / (load.inverse_mass * self.plan.step);
            }
        }
    }
}
