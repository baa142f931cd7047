//! A body answers to what touches it: it and the particles that lie on it go on together.
//!
//! Particles meet a collider as if nothing could move it, and all at once: each takes the velocity of its surface. A body
//! that weighs little beside them would be given the momentum of all of them, and would leave faster than they came. So what it is
//! given is shared with the particles that press on it, as of an inelastic collision: they are one body for the moment,
//! along the normal, and along the surface as far as friction holds them.
//!
//! In the corrections of the next substep threads pull at these particles. A particle that lies on a collider has the mobility
//! `w (1 - n n^T)` there (`active_set`). One that lies on a body moves along the normal as well, as heavy as it and its part of the body
//! are together: the normal that corrections see is shorter. Each of `N` particles is taken to carry a part of the body's
//! mass (mass splitting: Tonge, Benevolenski and Voroshilov 2012, *Mass Splitting for Jitter-Free Parallel Rigid Body
//! Simulation*), so that threads of any stiffness carry a body of any mass.

use bevy_math::Vec3;

use crate::solver::contact::active_set::ActiveSet;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::mobility::{Mobility, Twist};
use crate::solver::contact::together::together;
use crate::solver::contact::touching::Touching;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// A body, after particles have met it in a substep.
pub(super) struct Answer<'a> {
    pub collider: usize,
    pub mobility: Mobility,
    pub motion: &'a Motion<'a>,
    /// What it was given in this contact.
    pub given: Impulse,
    /// Length of the substep \[s\].
    pub step: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub d: &'a mut Soa,
    /// Pulls noted from before the corrections on (`integrate::houbolt`), of which contact is none.
    pub pull: Option<&'a mut Soa>,
    pub set: &'a mut ActiveSet,
    /// By block, the way at which its particles may touch the body, and the way that has been gone (`broad_phase`) \[m\].
    pub until: &'a [f32],
    pub gone: f32,
}

impl Kernel for Answer<'_> {
    /// What the body takes back of what it was given.
    type Output = Impulse;

    /// Shares with the particles what the body was given.
    #[inline(always)]
    fn run(mut self) -> Impulse {
        let mut all = core::mem::take(&mut self.set.answering);
        let count = self.find(&mut all);
        let mut taken = Impulse::ZERO;
        if count > 0.0 {
            let together = together(&self.mobility, &all, self.given);
            let mut sums = [Block3::ZERO; 2];
            for touching in &all {
                self.take_along(touching, &together, &mut sums);
            }
            taken = Impulse { linear: sums[0].sum(), angular: sums[1].sum() };
            let moves = self.mobility.motion(self.given + taken);
            for touching in &all {
                self.lighten(touching, &moves, count);
            }
        }
        self.set.answering = all;
        taken
    }
}

impl Answer<'_> {
    /// Finds the particles that touch the body, and how many they are.
    #[inline(always)]
    fn find(&self, all: &mut Vec<Touching>) -> f32 {
        all.clear();
        let mut count = Block::ZERO;
        let blocks = &*self.set.next.blocks;
        let (touch, touch_left) = blocks.as_chunks::<LANES>();
        let (until, until_left) = self.until[..blocks.len()].as_chunks::<LANES>();
        for (many, (touch, until)) in touch.iter().zip(until).enumerate() {
            // A bit for each: most blocks are elsewhere. One that touches has no way left to go.
            let mut near = 0_u32;
            for i in 0..LANES {
                near |= u32::from(touch[i] & (until[i] <= self.gone)) << i;
            }
            while near != 0 {
                let block = many * LANES + near.trailing_zeros() as usize;
                near &= near - 1;
                self.look(block * LANES, all, &mut count);
            }
        }
        let left = blocks.len() - touch_left.len();
        for (block, (&touches, &until)) in (left..).zip(touch_left.iter().zip(until_left)) {
            if touches && until <= self.gone {
                self.look(block * LANES, all, &mut count);
            }
        }
        count.0.iter().sum()
    }

    /// Looks which particles of a block touch the body.
    #[inline(always)]
    fn look(&self, slot: usize, all: &mut Vec<Touching>, count: &mut Block) {
        let (set, collider) = (&*self.set, self.collider as f32);
        let (w, holder) = (Block::load(self.inverse_mass, slot), Block::load(&set.holder, slot));
        let press = Block3::load(&set.pressed, slot);
        let (mut pressed, mut masses) = (Block::ZERO, Block::ZERO);
        for i in 0..LANES {
            let press = press.at(i);
            pressed.0[i] = press.dot(press).sqrt();
            let touches = (w.0[i] > 0.0) & (holder.0[i] == collider) & (pressed.0[i] > 0.0);
            let mass = 1.0 / larger(w.0[i], f32::MIN_POSITIVE);
            masses.0[i] = if touches { mass } else { 0.0 };
        }
        if !masses.is_any() {
            return;
        }
        let (x, loose) = (Block3::load(self.x, slot), Block::load(&set.next.loose, slot));
        let (mut n, mut arms, mut sticks) = (Block3::ZERO, Block3::ZERO, Block::ZERO);
        for i in 0..LANES {
            n.set(i, press.at(i) * (1.0 / larger(pressed.0[i], f32::MIN_POSITIVE)));
            arms.set(i, x.at(i) - self.motion.centre[0]);
            sticks.0[i] = 1.0 - loose.0[i];
            count.0[i] += if masses.0[i] > 0.0 { 1.0 } else { 0.0 };
        }
        // Put there one by one: what is put as a whole is made elsewhere, and copied.
        all.push(Touching::NONE);
        if let Some(touching) = all.last_mut() {
            touching.slot = slot;
            touching.masses = masses;
            touching.arms = arms;
            touching.n = n;
            touching.pressed = pressed;
            touching.sticks = sticks;
        }
    }

    /// Takes particles along with the body, no further than they were pressed, and adds up what the body takes back for that.
    #[inline(always)]
    fn take_along(&mut self, touching: &Touching, together: &Twist, sums: &mut [Block3; 2]) {
        let Touching { slot, masses, arms, n, pressed, sticks } = touching;
        let slot = *slot;
        let mut by = Block3::ZERO;
        for i in 0..LANES {
            let (n, way) = (n.at(i), together.at(arms.at(i)) * self.step);
            let along = n.dot(way);
            let all = (way - n * along) * sticks.0[i] + n * larger(along, -pressed.0[i]);
            by.set(i, if masses.0[i] > 0.0 { all } else { Vec3::ZERO });
        }
        Block3::load(&*self.d, slot).plus(&by).store(self.d, slot);
        Block3::load(&self.set.unpulled, slot).plus(&by).store(&mut self.set.unpulled, slot);
        if let Some(pull) = &mut self.pull {
            let mut left = Block3::load(&**pull, slot);
            for i in 0..LANES {
                left.set(i, left.at(i) - by.at(i));
            }
            left.store(&mut **pull, slot);
        }
        let rate = -1.0 / self.step;
        for i in 0..LANES {
            let given = by.at(i) * (masses.0[i] * rate);
            sums[0].set(i, sums[0].at(i) + given);
            sums[1].set(i, sums[1].at(i) + arms.at(i).cross(given));
        }
    }

    /// Tells the next corrections how fast the surface is now, and how heavy the particles are there, each with its part of the body.
    /// By now it has answered to them.
    #[inline(always)]
    fn lighten(&mut self, touching: &Touching, moves: &Twist, count: f32) {
        let Touching { slot, masses, arms, .. } = touching;
        let (slot, set) = (*slot, &mut *self.set);
        let mut normal = Block3::load(&set.next.normal, slot);
        let mut velocity = Block3::load(&set.velocity, slot);
        let mut pressed = Block3::load(&set.pressed, slot);
        let mobility = self.mobility;
        for i in 0..LANES {
            let (n, arm, touches) = (normal.at(i), arms.at(i), masses.0[i] > 0.0);
            let gives = mobility.along(arm, n);
            let part = (1.0 / (1.0 + count * gives * masses.0[i])).sqrt();
            normal.set(i, if touches { n * part } else { n });
            let faster = velocity.at(i) + moves.at(arm);
            velocity.set(i, if touches { faster } else { velocity.at(i) });
            pressed.set(i, if touches { Vec3::ZERO } else { pressed.at(i) });
        }
        normal.store(&mut set.next.normal, slot);
        velocity.store(&mut set.velocity, slot);
        pressed.store(&mut set.pressed, slot);
    }
}
