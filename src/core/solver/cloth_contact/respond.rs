//! Pairs that touch are moved apart, with friction.

use bevy_math::Vec3;

use crate::solver::cloth_contact::batches::{Batch, Batches};
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::friction::Rubbing;
use crate::solver::cloth_contact::grains::Grains;
use crate::solver::cloth_contact::normals::direction;
use crate::solver::cloth_contact::side::Side;
use crate::solver::cloth_contact::tangles::DEEP;
use crate::solver::simd::block::{Block, Block3, larger, smaller};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Part of the distance at which pairs touch, by which batches wake earlier than they need to: more than rounding is worth.
const EARLY: f32 = 1e-3;
/// Least distance between two particles that has a direction, in distances at which they touch.
const LEAST_DISTANCE: f32 = 1e-6;

/// Looks which batches touch before anything is moved apart in a substep. The others sleep.
pub(super) struct LookAtPairs<'a> {
    pub pairs: &'a [Pair],
    pub batches: &'a mut Batches,
    /// Where particles are at the substep's end \[m\].
    pub at: &'a Soa,
    /// Where the first cloth's first slot is there, and the second one's.
    pub first: [usize; 2],
    /// How far particles have moved relative to each other since the pairs were found, and in the last step, at most \[m\].
    pub travelled: f32,
    pub step: f32,
}

impl Kernel for LookAtPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { pairs, batches, at, first, travelled, step } = self;
        let travelled = larger(travelled, f32::MIN_POSITIVE);
        for awake in batches.awake(pairs, travelled, step) {
            let Batch { slots, reach, .. } = &*awake.batch;
            let mut apart = Block3::ZERO;
            for (i, (&a, &b)) in slots[0].iter().zip(&slots[1]).enumerate() {
                let [a, b] = [first[0] + a as usize, first[1] + b as usize];
                apart.set(i, at.get(a) - at.get(b));
            }
            let mut gaps = Block::ZERO;
            for i in 0..LANES {
                let apart = apart.at(i);
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
/// surface and no further, and half of it is expected again in the next substep (`integrate::houbolt`). The threads then find layers
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

impl Kernel for Respond<'_, '_> {
    type Output = Touched;

    #[inline(always)]
    fn run(self) -> Touched {
        let Self { batches, sides, shift, drift, friction, most_push, part } = self;
        let second = sides.len() - 1;
        let mut touched = Touched::default();
        for batch in batches.touching() {
            let mut met = Met::NOTHING;
            let reach = batch.reach.times(part);
            let of = [&sides[0], &sides[second]].map(|side| (&*side.x, &*side.d));
            met.measure(batch, &reach, of, shift);
            if !met.touches.contains(&1) {
                continue;
            }
            let a = Grains::load(&mut sides[0], &batch.slots[0], &met.touches);
            let b = Grains::load(&mut sides[second], &batch.slots[1], &met.touches);
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
            for i in (0..LANES).filter(|&i| met.touches[i] != 0) {
                let are_held = a.inverse_mass.0[i] + b.inverse_mass.0[i] == 0.0;
                let [a, b] = batch.slots.map(|slots| slots[i] as usize);
                if are_held || sides[0].is_down(a) && sides[second].is_down(b) {
                    continue;
                }
                touched.count += 1;
                touched.deepest = larger(touched.deepest, met.depth.0[i] / reach.0[i]);
                let normal = met.normal.at(i);
                let momentum = normal * met.pressed.0[i] - rubbed.braked.at(i);
                let pushed = normal * met.pushed.0[i];
                let [one, other] = rubbed.back.each_ref().map(|back| back.at(i));
                sides[0].give(a, momentum, pushed, one);
                sides[second].give(b, -momentum, -pushed, other);
            }
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
    fn measure(
        &mut self,
        batch: &Batch,
        reach: &Block,
        [first, second]: [(&Soa, &Soa); 2],
        shift: Vec3,
    ) {
        for i in 0..LANES {
            let [a, b] = batch.slots.map(|slots| slots[i] as usize);
            let relative = first.1.get(a) - second.1.get(b);
            self.relative.set(i, relative);
            self.apart.set(i, first.0.get(a) - second.0.get(b) + shift + relative);
        }
        for i in 0..LANES {
            let apart = self.apart.at(i);
            let square = apart.dot(apart);
            self.square.0[i] = square;
            self.touches[i] = u32::from(square < reach.0[i] * reach.0[i]);
        }
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
