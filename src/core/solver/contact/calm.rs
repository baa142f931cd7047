//! The cloth around particles that are deep inside a collider, while these come out.

use bevy_math::Vec3;

use crate::solver::contact::broad_phase::Awake;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::impulse::Impulse;
use crate::solver::contact::{CALMED, LEAST_SLIDING, ROUNDED_UP, ResolveContacts};
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::lanes::LANES;

impl ResolveContacts<'_> {
    /// Calms the cloth around all colliders that it is left in and that nothing moves: those that move have done so.
    ///
    /// After all have been met, as it changes where ways through the substep begin, by which others are met.
    pub(super) fn calm_all(&mut self) {
        for k in 0..self.broad_phase.awake.len() {
            let Awake { collider, gone, left, .. } = self.broad_phase.awake[k];
            if left > 0.0 {
                let gone = (self.broad_phase.gone + self.broad_phase.pushed + gone) * ROUNDED_UP;
                let motion = self.motion(collider);
                self.calm(k, gone, &motion);
            }
        }
    }

    /// Calms the cloth around particles that are so deep inside a collider that they need more than one substep to come
    /// out. Particles within [`CALMED`] times that depth keep their displacements, but their speed is limited to the
    /// speed of depenetration: the threads that the pushes stretch would accelerate them without bound.
    #[inline(never)]
    pub(super) fn calm(&mut self, k: usize, gone: f32, motion: &Motion<'_>) {
        let Awake { collider, first, ref mut left, .. } = self.broad_phase.awake[k];
        let deepest = core::mem::take(left);
        if deepest <= 0.0 {
            return;
        }
        // Nothing lies on what gives way: its load would drive the rest of the cloth out faster.
        self.set.next.give_way();
        self.broad_phase.struck = true;
        let most = self.settings.most_push;
        let layout = self.bands.rows.layout;
        let near = CALMED * deepest;
        let mut given = Impulse::ZERO;
        // A body goes with the cloth as the cloth goes with it.
        let mobility = self.set.impulses.mobility(collider);
        let mass = mobility.map_or(0.0, |_| self.mass_within(first, gone, motion, near));
        for row in 0..layout.rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                if self.is_beyond(first, slot, gone, motion, near) {
                    continue;
                }
                let w = Block::load(self.inverse_mass, slot);
                let (mut x, mut d) = (Block3::load(self.x, slot), Block3::load(self.d, slot));
                let starts = x;
                for i in 0..LANES {
                    let at = x.at(i) + d.at(i);
                    // Far from the collider's origin, what stands still would seem to move.
                    let moved = at - motion.before.to_world(motion.after.to_local(at));
                    let surface = if motion.moves { moved } else { Vec3::ZERO };
                    let relative = d.at(i) - surface;
                    let way = larger(relative.dot(relative).sqrt(), LEAST_SLIDING);
                    let beyond = if w.0[i] > 0.0 { larger(1.0 - most / way, 0.0) } else { 0.0 };
                    let arm = starts.at(i) - motion.centre[0];
                    let gives = mobility.map_or(0.0, |mobility| mobility.most_at(arm));
                    let beyond = beyond / (1.0 + mass * gives);
                    d.set(i, d.at(i) - relative * beyond);
                    x.set(i, x.at(i) + relative * beyond);
                    let lost = relative * (beyond / larger(w.0[i], f32::MIN_POSITIVE));
                    given += Impulse::at(arm, lost);
                }
                d.store(self.d, slot);
                x.store(self.x, slot);
            }
        }
        if motion.measured {
            self.set.impulses.give_sum(collider, given, Impulse::ZERO, self.settings.step);
        }
    }

    /// Whether a block's particles are all further from a collider than `near`.
    fn is_beyond(
        &self,
        first: usize,
        slot: usize,
        gone: f32,
        motion: &Motion<'_>,
        near: f32,
    ) -> bool {
        // What is known may be less than the distance, and depends on where the world's origin is.
        self.broad_phase.until[first + slot / LANES] > gone + near || self.gap(slot, motion) > near
    }

    /// Mass of the particles in blocks that are that near to a collider \[kg\].
    fn mass_within(&self, first: usize, gone: f32, motion: &Motion<'_>, near: f32) -> f32 {
        let layout = self.bands.rows.layout;
        let mut mass = 0.0;
        for row in 0..layout.rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                if !self.is_beyond(first, slot, gone, motion, near) {
                    let free = self.inverse_mass[slot..slot + LANES].iter().filter(|&&w| w > 0.0);
                    mass += free.map(|w| 1.0 / w).sum::<f32>();
                }
            }
        }
        mass
    }

    /// Least distance beyond epsilon of the particles of a block that are not held \[m\].
    fn gap(&self, slot: usize, motion: &Motion<'_>) -> f32 {
        let w = Block::load(self.inverse_mass, slot);
        let x = Block3::load_sum(self.x, self.d, slot);
        (0..LANES).filter(|&i| w.0[i] > 0.0).fold(f32::INFINITY, |least, i| {
            let distance = motion.shape.distance(motion.after.to_local(x.at(i)));
            least.min(distance * motion.after.scale - self.settings.epsilon)
        })
    }
}
