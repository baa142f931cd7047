//! Pairs that touch are moved apart, with friction.

use bevy_math::Vec3;

use crate::solver::cloth_contact::batches::{Batch, Batches};
use crate::solver::cloth_contact::beads::Beads;
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::friction::{Rubbed, Rubbing};
use crate::solver::cloth_contact::grains::{Grains, Spots};
use crate::solver::cloth_contact::normals::direction;
use crate::solver::cloth_contact::side::{Given, Side};
use crate::solver::cloth_contact::tangles::DEEP;
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::{LANES, is_any};
use crate::solver::simd::transpose::Transpose;

/// Part of the distance at which pairs touch, by which batches wake earlier than they need to: more than rounding is worth.
const EARLY: f32 = 1e-3;
/// Least distance between two particles that has a direction, in distances at which they touch.
const LEAST_DISTANCE: f32 = 1e-6;

/// Looks which batches touch before anything is moved apart in a substep. The others sleep.
pub(super) struct LookAtPairs<'a> {
    pub pairs: &'a [Pair],
    pub batches: &'a mut Batches,
    /// The first particles' cloth, and the second ones'.
    pub beads: [&'a Beads; 2],
    /// From the origin of the second cloth to that of the first \[m\].
    pub shift: Vec3,
    /// How far particles have moved relative to each other since the pairs were found, and in the last step, at most \[m\].
    pub travelled: f32,
    pub step: f32,
}

impl TransposingKernel for LookAtPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self, t: impl Transpose) {
        let Self { pairs, batches, beads, shift, travelled, step } = self;
        let travelled = larger(travelled, f32::MIN_POSITIVE);
        for awake in batches.awake(pairs, travelled, step) {
            let Batch { slots, reach, .. } = &*awake.batch;
            let a = Spots::gather(t, beads[0], &slots[0]);
            let b = Spots::gather(t, beads[1], &slots[1]);
            let mut gaps = Block::ZERO;
            for i in 0..LANES {
                let [one, other] = [a.x.at(i) + a.d.at(i), b.x.at(i) + b.d.at(i)];
                let apart = one - other + shift;
                let gap = apart.dot(apart).sqrt() - reach.0[i] * (1.0 + EARLY);
                gaps.0[i] = if reach.0[i] > 0.0 { gap } else { f32::INFINITY };
            }
            awake.batch.anchors.leave(&gaps);
            let gap = gaps.smallest();
            if gap <= 0.0 { awake.touches() } else { awake.sleeps(gap) }
        }
    }
}

/// Depth of a pair, in distances at which it touches, from which on layers are pressed into each other.
const PRESSED: f32 = 0.25;

/// Moves apart what touches, one batch after the other.
///
/// The approach that a push undoes is taken from the displacements, and with it friction brakes what slides. The rest of the depth
/// is a displacement without velocity, as at colliders: moving out of each other gives no speed.
///
/// Its change of the displacements is a correction like those of the threads: a particle that lies on a collider follows it along the
/// surface and no further, and a part of it is expected again in the next substep (`integrate::houbolt`). The threads then find layers
/// apart that they press together, and do not stretch for it.
pub(super) struct Respond<'a, 'b> {
    pub batches: &'a mut Batches,
    /// The cloth of the first particles, and that of the second ones if it is another.
    pub sides: &'a mut [Side<'b>],
    /// From the origin of the second cloth to that of the first \[m\].
    pub shift: Vec3,
    /// How much further the first cloth's frame moves in the substep than the second one's \[m\].
    pub drift: Vec3,
    pub friction: f32,
    /// How far a pair is moved apart without speed, at most \[m\].
    pub most_push: f32,
    /// Part of the distance at which pairs touch, to which they are moved apart.
    pub part: f32,
}

/// The pairs that touched in a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Touched {
    /// Pairs that touched.
    pub count: u32,
    /// Depth of the deepest of them, in distances at which they touch.
    pub deepest: f32,
}

impl Touched {
    /// Whether faces may pierce each other.
    pub fn is_deep(&self) -> bool {
        self.deepest > DEEP
    }

    /// Whether layers are pressed into each other.
    pub fn is_pressed(&self) -> bool {
        self.deepest > PRESSED
    }
}

impl TransposingKernel for Respond<'_, '_> {
    type Output = Touched;

    #[inline(always)]
    fn run(self, t: impl Transpose) -> Touched {
        let Self { batches, sides, shift, drift, friction, most_push, part } = self;
        let second = sides.len() - 1;
        let mut touched = Touched::default();
        for batch in batches.touching() {
            let [slots, others] = &batch.slots;
            let reach = batch.reach.times(part);
            let here = Spots::gather(t, sides[0].beads, slots);
            let there = Spots::gather(t, sides[second].beads, others);
            let mut met = Met::measure([&here, &there], &reach, shift);
            if !is_any(&met.touches) {
                continue;
            }
            let a = sides[0].grains(t, slots, &met.touches, &here);
            let b = sides[second].grains(t, others, &met.touches, &there);
            met.press([&a, &b], &reach, drift, most_push);
            let rubbing = Rubbing {
                touches: &met.touches,
                apart: &met.apart,
                relative: &met.relative,
                normal: &met.normal,
                pressed: &met.pressed,
                pushed: &met.pushed,
                grains: [&a, &b],
                friction,
            };
            let rubbed = match second {
                0 => rubbing.brake::<false>(&mut batch.anchors),
                _ => rubbing.brake::<true>(&mut batch.anchors),
            };
            met.leave_out([&here, &there]);
            met.count(&reach, &mut touched);
            let [one, other] = met.given(rubbed);
            sides[0].give(t, slots, &met.touches, (&here, &a), &one);
            sides[second].give(t, others, &met.touches, (&there, &b), &other);
        }
        touched
    }
}

/// The outcome of a batch.
struct Met {
    /// From the second particle to the first \[m\], and its square.
    apart: Block3,
    square: Block,
    /// How much further the first one moves in the substep \[m\].
    relative: Block3,
    /// One where a pair touches.
    touches: [u32; LANES],
    /// How much nearer they are than they touch \[m\].
    depth: Block,
    /// The direction in which they are moved apart, the momentum along it that undoes their approach, and what moves them without
    /// speed \[kg m\].
    normal: Block3,
    pressed: Block,
    pushed: Block,
}

impl Met {
    const NOTHING: Self = Self {
        apart: Block3::ZERO,
        square: Block::ZERO,
        relative: Block3::ZERO,
        touches: [0; LANES],
        depth: Block::ZERO,
        normal: Block3::ZERO,
        pressed: Block::ZERO,
        pushed: Block::ZERO,
    };

    /// Finds out which pairs touch. What is no number touches nothing.
    #[inline(always)]
    fn measure([a, b]: [&Spots; 2], reach: &Block, shift: Vec3) -> Self {
        let mut met = Self { relative: a.further_than(b), ..Self::NOTHING };
        for i in 0..LANES {
            let apart = a.x.at(i) - b.x.at(i) + shift + met.relative.at(i);
            let square = apart.dot(apart);
            met.apart.set(i, apart);
            met.square.0[i] = square;
            met.touches[i] = u32::from(square < reach.0[i] * reach.0[i]);
        }
        met
    }

    /// Leaves out pairs of which neither particle moves, and those of which both stand down.
    #[inline(always)]
    fn leave_out(&mut self, [a, b]: [&Spots; 2]) {
        for i in 0..LANES {
            let are_held = a.inverse_mass.0[i] + b.inverse_mass.0[i] == 0.0;
            let are_down = a.down.0[i] * b.down.0[i] != 0.0;
            self.touches[i] = if are_held | are_down { 0 } else { self.touches[i] };
        }
    }

    /// Counts pairs, and notes how deep they are.
    #[inline(always)]
    fn count(&self, reach: &Block, touched: &mut Touched) {
        let mut deep = Block::ZERO;
        for i in 0..LANES {
            let depth = self.depth.0[i] / reach.0[i];
            deep.0[i] = if self.touches[i] != 0 { depth } else { 0.0 };
            touched.count += self.touches[i];
        }
        touched.deepest = larger(touched.deepest, deep.largest());
    }

    /// The momentum and the pushes that the particles of both sides are given.
    #[inline(always)]
    fn given(&self, rubbed: Rubbed) -> [Given; 2] {
        let [mut momentum, mut pushed, mut back_momentum, mut back_pushed] = [Block3::ZERO; 4];
        for i in 0..LANES {
            let normal = self.normal.at(i);
            let (to, push) =
                (normal * self.pressed.0[i] - rubbed.braked.at(i), normal * self.pushed.0[i]);
            momentum.set(i, to);
            pushed.set(i, push);
            back_momentum.set(i, -to);
            back_pushed.set(i, -push);
        }
        let [one, other] = rubbed.back;
        [
            Given { momentum, pushed, back: one },
            Given { momentum: back_momentum, pushed: back_pushed, back: other },
        ]
    }

    /// Moves pairs apart.
    #[inline(always)]
    fn press(&mut self, [a, b]: [&Grains; 2], reach: &Block, drift: Vec3, most_push: f32) {
        for i in 0..LANES {
            let (apart, square, reach) = (self.apart.at(i), self.square.0[i], reach.0[i]);
            let distance = square.sqrt();
            let normal = direction([a.normal.at(i), b.normal.at(i)], apart, distance);
            let normal = if distance > LEAST_DISTANCE * reach { normal } else { Vec3::Y };
            // As far along the normal as they are to be apart.
            let above = apart.dot(normal);
            let depth = (above * above + (reach * reach - square)).sqrt() - above;
            let relative = self.relative.at(i) + drift;
            let undone = smaller(larger(-relative.dot(normal), 0.0), depth);
            let least = a.least_mobility_with(b, i);
            let slips =
                a.mobility(&a.slipping, i, normal, 1.0) + b.mobility(&b.slipping, i, normal, 1.0);
            let yields =
                a.mobility(&a.pushed, i, normal, 1.0) + b.mobility(&b.pushed, i, normal, 1.0);
            let [slips, yields] = [slips, yields].map(|all| 1.0 / larger(all, least));
            self.depth.0[i] = reach - distance;
            self.relative.set(i, relative);
            self.normal.set(i, normal);
            self.pressed.0[i] = undone * slips;
            self.pushed.0[i] = smaller(depth - undone, most_push) * yields;
        }
    }
}
