//! Pairs that touch are moved apart, with friction.

use bevy_math::Vec3;

use crate::solver::cloth_contact::batches::{Anchors, Batch, Batches};
use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::normals::direction;
use crate::solver::cloth_contact::side::Side;
use crate::solver::cloth_contact::tangles::DEEP;
use crate::solver::contact::LEAST_MOBILITY;
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
/// A pair is met once or twice in a substep, and other pairs drag at its particles after friction has stopped them. What is left of that
/// sums up: a pile creeps down a slope on which it should stay. So friction brakes what a pair has slid since it began to touch in the
/// tick, as far as Coulomb's bound lets it: what is beyond, it has slid for good.
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
            met.respond(&a, &b, &reach, drift, friction, most_push, &mut batch.anchors);
            for i in (0..LANES).filter(|&i| met.touches[i] != 0) {
                let are_held = a.inverse_mass.0[i] + b.inverse_mass.0[i] == 0.0;
                let [a, b] = batch.slots.map(|slots| slots[i] as usize);
                if are_held || sides[0].is_down(a) && sides[second].is_down(b) {
                    continue;
                }
                touched.count += 1;
                touched.deepest = larger(touched.deepest, met.depth.0[i] / reach.0[i]);
                let (momentum, pushed) = (met.momentum.at(i), met.pushed.at(i));
                sides[0].give(a, momentum, pushed);
                sides[second].give(b, -momentum, -pushed);
            }
        }
        touched
    }
}

/// What the response depends on of the particles of one side of a batch, where they touch.
struct Grains {
    normal: Block3,
    onto: Block3,
    /// What the collider's friction is to undo of its displacement \[m\].
    undone: Block3,
    /// Inverse mass, all of it, and what is left of it along a collider \[1/kg\].
    inverse_mass: Block,
    slipping: Block,
    /// The same when the collider's friction has held it.
    loose: Block,
}

impl Grains {
    #[inline(always)]
    fn load(side: &mut Side<'_>, slots: &[u32; LANES], touches: &[u32; LANES]) -> Self {
        let mut grains = Self {
            normal: Block3::ZERO,
            onto: Block3::ZERO,
            undone: Block3::ZERO,
            inverse_mass: Block::ZERO,
            slipping: Block::ZERO,
            loose: Block::ZERO,
        };
        for i in (0..LANES).filter(|&i| touches[i] != 0) {
            let slot = slots[i] as usize;
            let (lies, w) = (side.lies(slot), side.inverse_mass[slot]);
            grains.normal.set(i, side.normal(slot));
            grains.onto.set(i, lies.onto);
            grains.undone.set(i, lies.undone);
            grains.inverse_mass.0[i] = w;
            grains.slipping.0[i] = w * lies.slip;
            grains.loose.0[i] = w * lies.slip * lies.loose;
        }
        grains
    }

    /// How far momentum of one along a direction of some length moves a particle that moves by `w` where it is free \[1/kg\].
    #[inline(always)]
    fn mobility(&self, w: &Block, lane: usize, direction: Vec3, square: f32) -> f32 {
        let onto = self.onto.at(lane).dot(direction);
        w.0[lane] * (1.0 - onto * onto / square)
    }
}

/// The outcome of a batch.
struct Met {
    /// From the second particle to the first \[m\], and its square.
    apart: Block3,
    square: Block,
    /// How much further the first one moves in its own cloth's frame \[m\].
    relative: Block3,
    /// One where a pair touches.
    touches: [u32; LANES],
    /// How much nearer they are than they touch \[m\].
    depth: Block,
    /// What the first particle is given, and the second one is given back, and what moves them without speed \[kg m\].
    momentum: Block3,
    pushed: Block3,
}

impl Met {
    const NOTHING: Self = Self {
        apart: Block3::ZERO,
        square: Block::ZERO,
        relative: Block3::ZERO,
        touches: [0; LANES],
        depth: Block::ZERO,
        momentum: Block3::ZERO,
        pushed: Block3::ZERO,
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

    #[inline(always)]
    fn respond(
        &mut self,
        a: &Grains,
        b: &Grains,
        reach: &Block,
        drift: Vec3,
        friction: f32,
        most_push: f32,
        anchors: &mut Anchors,
    ) {
        let (mut set, mut anchor) = (anchors.set, anchors.apart);
        for i in 0..LANES {
            let (apart, square, reach) = (self.apart.at(i), self.square.0[i], reach.0[i]);
            let distance = square.sqrt();
            let normal = direction([a.normal.at(i), b.normal.at(i)], apart, distance);
            let normal = if distance > LEAST_DISTANCE * reach { normal } else { Vec3::Y };
            // As far along the normal as they are to be apart.
            let above = apart.dot(normal);
            let depth = (above * above + (reach * reach - square)).sqrt() - above;
            let relative = self.relative.at(i) + drift;
            let along = relative.dot(normal);
            let undone = smaller(larger(-along, 0.0), depth);
            let least = (a.inverse_mass.0[i] + b.inverse_mass.0[i]) * LEAST_MOBILITY;
            let least = larger(least, f32::MIN_POSITIVE);
            let share =
                a.mobility(&a.slipping, i, normal, 1.0) + b.mobility(&b.slipping, i, normal, 1.0);
            let share = 1.0 / larger(share, least);
            let pressed = undone * share;
            // What lies on a collider that holds it goes as that does, whatever has dragged it in this substep.
            let slides = relative - (a.undone.at(i) - b.undone.at(i));
            // Back to the anchor as well: what other pairs have dragged it by since friction stopped it.
            let before = apart - relative;
            let off = (before - anchor.at(i)) * set.0[i];
            let slides = slides + off;
            let sliding = slides - normal * slides.dot(normal);
            let way = larger(sliding.dot(sliding), f32::MIN_POSITIVE);
            let yields =
                a.mobility(&a.loose, i, sliding, way) + b.mobility(&b.loose, i, sliding, way);
            let yields = larger(yields, least);
            let held = friction * pressed * yields / way.sqrt();
            let braked = smaller(held, 1.0) / yields;
            self.depth.0[i] = reach - distance;
            self.momentum.set(i, normal * pressed - sliding * braked);
            self.pushed.set(i, normal * (smaller(depth - undone, most_push) * share));
            let touches = self.touches[i] != 0;
            let held_at = before - off * smaller(held, 1.0);
            anchor.set(i, if touches { held_at } else { anchor.at(i) });
            set.0[i] = if touches { 1.0 } else { set.0[i] };
        }
        *anchors = Anchors { set, apart: anchor };
    }
}
