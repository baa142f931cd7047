//! The active set of the next substep, as contact finds it.

use bevy_math::Vec3;

use crate::solver::contact::ContactSettings;
use crate::solver::contact::collider::Motion;
use crate::solver::contact::hold::Hold;
use crate::solver::contact::push_out::{Near, Pushed};
use crate::solver::simd::block::{Block3, larger};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::{ByBlock, CutAt};
use crate::solver::simd::soa::{PartMut, ValuesMut};

/// Where a band puts the active set of the next substep.
pub(super) struct Found<'a> {
    pub blocks: ByBlock<'a, bool>,
    pub normal: PartMut<'a>,
    pub slip: ValuesMut<'a>,
    pub loose: ValuesMut<'a>,
    pub velocity: PartMut<'a>,
    pub holder: ValuesMut<'a>,
    pub pressed: PartMut<'a>,
}

impl CutAt for Found<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (blocks, blocks_below) = self.blocks.cut(slot);
        let (normal, normal_below) = self.normal.cut(slot);
        let (slip, slip_below) = self.slip.cut(slot);
        let (loose, loose_below) = self.loose.cut(slot);
        let (velocity, velocity_below) = self.velocity.cut(slot);
        let (holder, holder_below) = self.holder.cut(slot);
        let (pressed, pressed_below) = self.pressed.cut(slot);
        let below = Self {
            blocks: blocks_below,
            normal: normal_below,
            slip: slip_below,
            loose: loose_below,
            velocity: velocity_below,
            holder: holder_below,
            pressed: pressed_below,
        };
        (Self { blocks, normal, slip, loose, velocity, holder, pressed }, below)
    }
}

impl Found<'_> {
    /// Takes a block's particles that touch into the active set. The approach of fast ones has been `stopped` before \[m\].
    #[inline(always)]
    pub fn take(
        &mut self,
        slot: usize,
        near: &Near,
        pushed: &Pushed,
        stopped: &Block3,
        hold: &Hold,
        motion: &Motion<'_>,
        collider: usize,
        settings: &ContactSettings,
    ) {
        self.blocks.row(slot, 1)[0] = true;
        let mut normals = Block3::load(&self.normal, slot);
        let mut velocity = Block3::load(&self.velocity, slot);
        let mut slips = self.slip.blocks(slot, 1);
        let mut looses = self.loose.blocks(slot, 1);
        let mut loose = looses.at(0);
        let mut holders = self.holder.blocks(slot, 1);
        let mut holder = holders.at(0);
        let mut slip = slips.at(0);
        let (rate, friction) = (1.0 / settings.step, motion.friction);
        for i in 0..LANES {
            let touches = near.depth.0[i] > 0.0;
            let n = near.normals.at(i);
            let (goes, surface) = (n.dot(pushed.surface.at(i)), pushed.surface.at(i) * rate);
            // What is fast may be gone in the next substep.
            let lies = if goes.abs() > settings.epsilon { Vec3::ZERO } else { n };
            normals.set(i, if touches { lies } else { normals.at(i) });
            velocity.set(i, if touches { surface } else { velocity.at(i) });
            holder.0[i] = if touches { collider as f32 } else { holder.0[i] };
            let free = pushed.slip(i, friction, hold, settings);
            let free = if goes.abs() > settings.epsilon { 1.0 } else { free };
            slip.0[i] = if touches { free } else { slip.0[i] };
            loose.0[i] = if touches { pushed.loose(i, friction) } else { loose.0[i] };
        }
        if motion.measured {
            let mut pressed = Block3::load(&self.pressed, slot);
            for i in 0..LANES {
                let n = near.normals.at(i);
                let all = pushed.undone.0[i] + larger(stopped.at(i).dot(n), 0.0);
                let touches = near.depth.0[i] > 0.0;
                pressed.set(i, if touches { n * all } else { pressed.at(i) });
            }
            pressed.store(&mut self.pressed, slot);
        }
        velocity.store(&mut self.velocity, slot);
        slips.set(0, slip);
        looses.set(0, loose);
        holders.set(0, holder);
        normals.store(&mut self.normal, slot);
    }
}
