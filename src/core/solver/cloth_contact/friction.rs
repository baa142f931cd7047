//! Coulomb's friction of pairs that touch.
//!
//! A pair is met once in a substep, and others drag at its particles after friction has stopped them. What is left of that
//! sums up: without more, a pile creeps down a slope on which it should stay, by a centimetre a second. So a pair of two cloths has an
//! *anchor*, where it began to touch, and friction brakes what leads away from there, as far as Coulomb's bound lets it. Beyond that
//! the pair slides, and its anchor with it. A pair that parts has none (`history`).
//!
//! Layers that press on each other are moved apart without speed, by what the approach of others has left (`respond`). In the same
//! way, and bounded by that push, pairs are moved back to their anchors.
//!
//! Pairs of one cloth have none: a heap creeps little, and its threads and anchors would shake it.

use bevy_math::Vec3;

use crate::solver::cloth_contact::grains::Grains;
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::lanes::LANES;

/// Where the pairs of a batch that touch began to, but for what they have slid since.
#[derive(Clone, Debug)]
pub(super) struct Anchors {
    /// 1 where a pair has one, else 0.
    set: Block,
    /// From the second particle to the first \[m\].
    apart: Block3,
}

impl Anchors {
    pub const NONE: Self = Self { set: Block::ZERO, apart: Block3::ZERO };

    pub fn set(&mut self, i: usize, anchor: Vec3) {
        self.set.0[i] = 1.0;
        self.apart.set(i, anchor);
    }

    pub fn get(&self, i: usize) -> Option<Vec3> {
        (self.set.0[i] > 0.0).then(|| self.apart.at(i))
    }

    /// Takes them from pairs that are apart.
    #[inline(always)]
    pub fn leave(&mut self, gaps: &Block) {
        for i in 0..LANES {
            self.set.0[i] = if gaps.0[i] > 0.0 { 0.0 } else { self.set.0[i] };
        }
    }
}

/// Pairs of a batch that touch, and rub on each other.
pub(super) struct Rubbing<'a> {
    /// One where a pair touches.
    pub touches: &'a [u32; LANES],
    /// From the second particle to the first where the substep ends, and how far that changes in it \[m\].
    pub apart: &'a Block3,
    pub relative: &'a Block3,
    /// The direction in which they are moved apart, the momentum along it that undoes their approach, and what moves them without
    /// speed \[kg m\].
    pub normal: &'a Block3,
    pub pressed: &'a Block,
    pub pushed: &'a Block,
    pub grains: [&'a Grains; 2],
    /// Coulomb's coefficient.
    pub friction: f32,
}

/// The outcome of friction.
pub(super) struct Rubbed {
    /// Momentum that is taken from the first particle, and given to the second one \[kg m\].
    pub braked: Block3,
    /// How far both are moved back, without speed \[m\].
    pub back: [Block3; 2],
}

impl Rubbing<'_> {
    /// Brakes pairs that slide, and holds them at their anchors if they have any.
    #[inline(always)]
    pub fn brake<const ANCHORED: bool>(&self, anchors: &mut Anchors) -> Rubbed {
        let [a, b] = self.grains;
        let mut rubbed = Rubbed { braked: Block3::ZERO, back: [Block3::ZERO; 2] };
        let (mut set, mut anchor) = (anchors.set, anchors.apart);
        for i in 0..LANES {
            let (normal, relative) = (self.normal.at(i), self.relative.at(i));
            let across = |way: Vec3| way - normal * way.dot(normal);
            let before = self.apart.at(i) - relative;
            let off = across(before - anchor.at(i)) * set.0[i];
            let off = if ANCHORED { off } else { Vec3::ZERO };
            // What lies on a collider that holds it goes as that does, whatever has dragged it in this substep.
            let slides = relative - (a.undone.at(i) - b.undone.at(i));
            let sliding = across(slides) + off;
            let way = larger(sliding.dot(sliding), f32::MIN_POSITIVE);
            let yields =
                a.mobility(&a.loose, i, sliding, way) + b.mobility(&b.loose, i, sliding, way);
            let yields = larger(yields, a.least_mobility_with(b, i));
            let most = self.friction * self.pressed.0[i] * yields;
            let held = smaller(most / way.sqrt(), 1.0);
            rubbed.braked.set(i, sliding * (held / yields));
            if !ANCHORED {
                continue;
            }
            let left = off * (1.0 - held);
            let square = larger(left.dot(left), f32::MIN_POSITIVE);
            let [one, other] = [a, b].map(|it| it.mobility(&it.loose, i, left, square));
            let yields = larger(one + other, f32::MIN_POSITIVE);
            let most = self.friction * self.pushed.0[i] * yields;
            let back = left * smaller(most / square.sqrt(), 1.0);
            rubbed.back[0].set(i, back * (-one / yields));
            rubbed.back[1].set(i, back * (other / yields));
            let touches = self.touches[i] != 0;
            let held_at = before - off * held - back;
            anchor.set(i, if touches { held_at } else { anchor.at(i) });
            set.0[i] = if touches { 1.0 } else { set.0[i] };
        }
        if ANCHORED {
            *anchors = Anchors { set, apart: anchor };
        }
        rubbed
    }
}
