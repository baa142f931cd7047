//! The memory of contact of edges from one substep to the next.

use bevy_math::{Mat3, Vec3};

use crate::solver::contact::impulses::{Impulses, Share};
use crate::solver::simd::soa::Soa;

/// Pressed edges that there is room for from the start.
const FEW: usize = 512;

/// The memory of contact of edges from one substep to the next.
#[derive(Clone, Debug)]
pub(crate) struct EdgeMemory {
    /// Impulses that are expected again, by collider and corners, ascending. Those of this substep have been given to its
    /// displacements.
    pub warm: Vec<WarmStart>,
    /// Impulses to be expected in the next substep.
    pub next_warm: Vec<WarmStart>,
    /// Particles that pass through a collider in this substep, as a thread of theirs is hooked in it; by slot and collider,
    /// ascending.
    pub freed: Vec<Freed>,
    /// Particles that do so in the next substep.
    pub next_freed: Vec<Freed>,
}

/// A particle that passes through a collider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Freed {
    pub slot: u32,
    /// Index of the collider.
    pub collider: u32,
    /// Time left in which it passes through \[s\]; restarted while its threads pull it.
    pub left: f32,
}

impl Freed {
    /// The order of such entries.
    pub fn key(&self) -> (u32, u32) {
        (self.slot, self.collider)
    }
}

/// The impulse with which a collider is expected to press on an edge or a face (warm starting: Catto 2005, *Iterative Dynamics with
/// Temporal Coherence*).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WarmStart {
    /// Index of the collider.
    pub collider: u32,
    /// Slots of the corners that it acts on, and their parts; of an edge, the last is the first again and has no part.
    pub corners: [u32; 3],
    pub parts: [f32; 3],
    /// The impulse, times the substep \[kg m\].
    pub impulse: Vec3,
}

impl WarmStart {
    /// The order of such entries.
    pub fn key(&self) -> (u32, [u32; 3]) {
        (self.collider, self.corners)
    }
}

impl EdgeMemory {
    pub fn new() -> Self {
        Self {
            warm: Vec::with_capacity(FEW),
            next_warm: Vec::with_capacity(FEW),
            freed: Vec::new(),
            next_freed: Vec::new(),
        }
    }

    /// Puts what is known of colliders at their new `place`s; `None` is none.
    pub fn renumber(&mut self, place: impl Fn(usize) -> Option<usize>) {
        self.warm.retain_mut(|warm| match place(warm.collider as usize) {
            Some(place) => {
                warm.collider = place as u32;
                true
            }
            None => false,
        });
        self.warm.sort_unstable_by_key(WarmStart::key);
        self.freed.retain_mut(|freed| match place(freed.collider as usize) {
            Some(place) => {
                freed.collider = place as u32;
                true
            }
            None => false,
        });
        self.freed.sort_unstable_by_key(Freed::key);
    }

    /// Gives displacements the impulses that are expected, in a substep of length `step` that is the square root of `ratio`
    /// times as long as the last one.
    pub fn start_warm(
        &mut self,
        ratio: f32,
        step: f32,
        inverse_mass: &[f32],
        x: &Soa,
        d: &mut Soa,
        mut pull: Option<&mut Soa>,
        impulses: &mut Impulses,
    ) {
        for warm in &mut self.warm {
            warm.impulse *= ratio;
            let mut at = Vec3::ZERO;
            for (slot, part) in warm.corners.into_iter().zip(warm.parts) {
                let slot = slot as usize;
                at += x.get(slot) * part;
                let by = warm.impulse * (part * inverse_mass[slot]);
                d.set(slot, d.get(slot) + by);
                // It is no pull of the cloth.
                if let Some(pull) = &mut pull {
                    pull.set(slot, pull.get(slot) - by);
                }
            }
            let (collider, given) = (warm.collider as usize, -warm.impulse);
            impulses.give([Share { collider, at, given, owed: Vec3::ZERO }], step);
        }
    }

    /// Whether a particle passes through a collider.
    pub fn is_freed(&self, slot: u32, collider: usize) -> bool {
        let key = (slot, collider as u32);
        self.freed.binary_search_by_key(&key, Freed::key).is_ok()
    }

    /// Expects nothing of the particle of a slot.
    pub fn forget(&mut self, slot: usize) {
        self.warm.retain(|warm| !warm.corners.contains(&(slot as u32)));
    }

    /// Turns with the cloth.
    pub fn turn(&mut self, turn: Mat3) {
        for warm in &mut self.warm {
            warm.impulse = turn * warm.impulse;
        }
    }

    /// Goes on to the next substep.
    pub fn end_substep(&mut self) {
        // Of one that is freed for several reasons, the longest time counts.
        let longest_first =
            |a: &Freed, b: &Freed| a.key().cmp(&b.key()).then(b.left.total_cmp(&a.left));
        self.next_freed.sort_unstable_by(longest_first);
        self.next_freed.dedup_by_key(|freed| freed.key());
        core::mem::swap(&mut self.freed, &mut self.next_freed);
        self.next_freed.clear();
        core::mem::swap(&mut self.warm, &mut self.next_warm);
        self.next_warm.clear();
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.warm.clear();
        self.freed.clear();
    }
}
