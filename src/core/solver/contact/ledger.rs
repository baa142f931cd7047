//! Momentum that colliders are given of pulls that moved nothing, at the beginning of corrections and at the end of contact.

use bevy_math::Vec3;

use crate::solver::contact::active_set::{ActiveSet, slipped};
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::impulses::Impulses;
use crate::solver::contact::let_go::followed;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::flags::raised;
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Colliders whose shares are summed up at once. A row of particles may lie on a few, and on the same ones as the row before.
const AT_ONCE: usize = 8;
/// The place of no collider.
const NONE: f32 = -1.0;

/// Momentum that a block's particles give to what they lie on, times the substep \[kg m\].
#[derive(Clone, Copy)]
struct Shares {
    /// Momentum that is given once.
    once: Block3,
    /// Momentum that is given, and owed as well.
    lasting: Block3,
}

impl ActiveSet {
    /// Gives colliders what they took of pulls that [`HoldOnto`] left out, in a substep of length `step`.
    pub fn give_left_out(&mut self, isa: Isa, inverse_mass: &[f32], x: &Soa, step: f32) {
        self.give(isa, inverse_mass, x, step, LeftOut);
    }

    /// Gives colliders what they took of pulls at what gives way, after the corrections of a substep of length `step`: it is
    /// moved by a part of its inverse mass, and no normal tells that it is held.
    pub fn give_yielding(
        &mut self,
        isa: Isa,
        inverse_mass: &[f32],
        [x, d]: [&Soa; 2],
        notes: bool,
        step: f32,
    ) {
        self.give(isa, inverse_mass, x, step, Yielding { d, notes });
    }

    /// Gives colliders what they took of what they have let go, in a substep of length `step`. Where pulls are noted, those
    /// that did not move it are not.
    pub fn give_taken(
        &mut self,
        isa: Isa,
        inverse_mass: &[f32],
        [x, d]: [&Soa; 2],
        notes: bool,
        step: f32,
    ) {
        self.give(isa, inverse_mass, x, step, Taken { d, notes });
    }

    fn give(&mut self, isa: Isa, inverse_mass: &[f32], x: &Soa, step: f32, rule: impl Rule) {
        if self.impulses.are_measured() {
            isa.run(Give { set: self, inverse_mass, x, step, rule });
        }
    }
}

impl Shares {
    /// 1 in the lanes that have any.
    #[inline(always)]
    fn any(&self) -> Block {
        let mut any = Block::ZERO;
        for i in 0..LANES {
            let (once, lasting) = (self.once.at(i), self.lasting.at(i));
            any.0[i] = if once != Vec3::ZERO || lasting != Vec3::ZERO { 1.0 } else { 0.0 };
        }
        any
    }
}

/// Which pulls are given.
trait Rule {
    /// Whether all that is given is owed as well.
    const ALL_LAST: bool;

    /// The shares of a block of these inverse masses, at a slot; `None` where it has none.
    fn shares(&self, set: &ActiveSet, w: &Block, slot: usize) -> Option<Shares>;
}

/// Gives the shares of all particles of the active set, in the order of their slots.
struct Give<'a, R> {
    set: &'a mut ActiveSet,
    inverse_mass: &'a [f32],
    x: &'a Soa,
    step: f32,
    rule: R,
}

impl<R: Rule> Kernel for Give<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { set, inverse_mass, x, step, rule } = self;
        let mut sums: [Sums; AT_ONCE] = core::array::from_fn(|_| Sums::of(NONE, Vec3::ZERO));
        let blocks = core::mem::take(&mut set.now.blocks);
        for block in raised(&blocks) {
            let slot = block * LANES;
            let Some(shares) = rule.shares(set, &Block::load(inverse_mass, slot), slot) else {
                continue;
            };
            let holder = Block::load(&set.holder, slot);
            let mut left = shares.any();
            while left.is_any() {
                let first = left.0.iter().position(|&left| left > 0.0).unwrap_or(0);
                let collider = holder.0[first];
                let sums = &mut sums[collider as usize % AT_ONCE];
                if sums.collider != collider {
                    sums.give(&mut set.impulses, step);
                    *sums = Sums::of(collider, set.impulses.about(collider as usize));
                }
                let mut own = left;
                for i in 0..LANES {
                    let is_own = holder.0[i] == collider;
                    own.0[i] = if is_own { own.0[i] } else { 0.0 };
                    left.0[i] = if is_own { 0.0 } else { left.0[i] };
                }
                // Also where it is no number.
                left.0[first] = 0.0;
                sums.add::<R>(&own, &Block3::load(x, slot), &shares);
            }
        }
        set.now.blocks = blocks;
        for sums in &sums {
            sums.give(&mut set.impulses, step);
        }
    }
}

/// Shares of particles in a collider, summed up by lanes.
struct Sums {
    collider: f32,
    /// The place that they are about.
    about: Vec3,
    /// Linear and angular ones.
    once: [Block3; 2],
    lasting: [Block3; 2],
}

impl Sums {
    /// Nothing, for a collider.
    #[inline(always)]
    fn of(collider: f32, about: Vec3) -> Self {
        let none = [Block3::ZERO; 2];
        Self { collider, about, once: none, lasting: none }
    }

    /// Adds the shares of particles at `x` whose lanes are 1.
    #[inline(always)]
    fn add<R: Rule>(&mut self, own: &Block, x: &Block3, shares: &Shares) {
        let mut arms = Block3::ZERO;
        for i in 0..LANES {
            arms.set(i, x.at(i) - self.about);
        }
        add_own(&mut self.lasting, own, &arms, &shares.lasting);
        if !R::ALL_LAST {
            add_own(&mut self.once, own, &arms, &shares.once);
        }
    }

    /// Gives it to the collider, after a substep of length `step`.
    #[inline(always)]
    fn give(&self, impulses: &mut Impulses, step: f32) {
        if self.collider >= 0.0 {
            let of = |[linear, angular]: &[Block3; 2]| Impulse {
                linear: linear.sum(),
                angular: angular.sum(),
            };
            let owed = of(&self.lasting);
            impulses.give_sum(self.collider as usize, of(&self.once) + owed, owed, step);
        }
    }
}

/// Adds shares of particles at `arms` whose lanes are 1.
#[inline(always)]
fn add_own(sums: &mut [Block3; 2], own: &Block, arms: &Block3, shares: &Block3) {
    // A product, not a choice: that would be made lane by lane.
    let mut owns = Block3::ZERO;
    for i in 0..LANES {
        owns.set(i, shares.at(i) * own.0[i]);
    }
    sums[0] = sums[0].plus(&owns);
    sums[1] = sums[1].plus(&arms.cross(&owns));
}

/// Whether a particle is held by what it lies on.
#[inline(always)]
fn is_held(n: Vec3, w: f32) -> bool {
    (n.x != 0.0) | (n.y != 0.0) | (n.z != 0.0) && w > 0.0
}

struct LeftOut;

impl Rule for LeftOut {
    const ALL_LAST: bool = true;

    #[inline(always)]
    fn shares(&self, set: &ActiveSet, w: &Block, slot: usize) -> Option<Shares> {
        let (n, dropped) = (Block3::load(&set.now.normal, slot), Block3::load(&set.dropped, slot));
        let mut given = Block3::ZERO;
        for i in 0..LANES {
            let all = dropped.at(i) / larger(w.0[i], f32::MIN_POSITIVE);
            given.set(i, if is_held(n.at(i), w.0[i]) { all } else { Vec3::ZERO });
        }
        Some(Shares { once: Block3::ZERO, lasting: given })
    }
}

struct Yielding<'a> {
    d: &'a Soa,
    notes: bool,
}

impl Rule for Yielding<'_> {
    const ALL_LAST: bool = false;

    #[inline(always)]
    fn shares(&self, set: &ActiveSet, w: &Block, slot: usize) -> Option<Shares> {
        let (n, slip) = (Block3::load(&set.now.normal, slot), Block::load(&set.now.slip, slot));
        let mut unslipped = Block::ZERO;
        for i in 0..LANES {
            let w = w.0[i];
            let yields = w > 0.0 && !is_held(n.at(i), w);
            let part = (1.0 / slip.0[i] - 1.0) / larger(w, f32::MIN_POSITIVE);
            unslipped.0[i] = if yields { part } else { 0.0 };
        }
        // Hardly any block has what gives way.
        if !unslipped.is_any() {
            return None;
        }
        let (d, unpulled) = (Block3::load(self.d, slot), Block3::load(&set.unpulled, slot));
        let mended = Block3::load(&set.mended, slot);
        let (mut once, mut lasting) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            let all = (d.at(i) - unpulled.at(i)) * unslipped.0[i];
            // What mends has no counterpart that goes on.
            let ends = if self.notes { mended.at(i) * unslipped.0[i] } else { all };
            once.set(i, ends);
            lasting.set(i, all - ends);
        }
        Some(Shares { once, lasting })
    }
}

struct Taken<'a> {
    d: &'a Soa,
    notes: bool,
}

impl Rule for Taken<'_> {
    const ALL_LAST: bool = false;

    #[inline(always)]
    fn shares(&self, set: &ActiveSet, w: &Block, slot: usize) -> Option<Shares> {
        let (load, lost) = (Block::load(&set.load, slot), Block::load(&set.lost, slot));
        // What goes on touching has been let go by what met it.
        if !lost.is_any() && !load.is_any() {
            return None;
        }
        let (n, slip) = (Block3::load(&set.now.normal, slot), Block::load(&set.now.slip, slot));
        let (d, unpulled) = (Block3::load(self.d, slot), Block3::load(&set.unpulled, slot));
        let (mut once, mut lasting) = (Block3::ZERO, Block3::ZERO);
        for i in 0..LANES {
            let (load, lost, n) = (load.0[i], lost.0[i], n.at(i));
            let is_let_go = is_held(n, w.0[i]) && (load != 0.0 || lost != 0.0);
            let w = larger(w.0[i], f32::MIN_POSITIVE);
            let fallen = if lost < 0.0 { lost } else { 0.0 };
            let follows = followed(lost, load * w);
            let released = n * (larger(lost, 0.0) + follows);
            let pulled = d.at(i) - released - unpulled.at(i);
            let unslipped = slipped(pulled, n) * (1.0 / slip.0[i] - 1.0);
            let unfollowed = n * (load - follows / w) + unslipped / w;
            let fallen = n * (fallen / w);
            let notes = is_let_go && self.notes;
            let all = if self.notes { fallen } else { unfollowed + fallen };
            once.set(i, if is_let_go { all } else { Vec3::ZERO });
            lasting.set(i, if notes { unfollowed } else { Vec3::ZERO });
        }
        Some(Shares { once, lasting })
    }
}
