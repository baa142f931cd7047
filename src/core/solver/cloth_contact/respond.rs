//! Pairs of particles that touch are moved apart, with friction.

use bevy_math::Vec3;

use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::normals::{Normals, direction};
use crate::solver::cloth_contact::tangles::DEEP;
use crate::solver::contact::LEAST_MOBILITY;
use crate::solver::simd::block::{larger, smaller};
use crate::solver::simd::soa::Soa;

/// Least distance between two particles that has a direction, in distances at which they touch.
const LEAST_DISTANCE: f32 = 1e-6;

/// Moves apart what touches, one pair after the other.
///
/// The approach that a push undoes is taken from the displacements, and with it friction brakes what slides. The rest of the depth
/// is a displacement without velocity, as at colliders: moving out of each other gives no speed.
///
/// Its change of the displacements is a correction like those of the threads: a particle that lies on a collider follows it along the
/// surface and no further, and half of it is expected again in the next substep (`integrate::houbolt`). The threads then find layers apart that they press together, and do not stretch for it.
pub(super) struct Respond<'a, S> {
    pub pairs: &'a [Pair],
    pub sides: S,
    /// How far particles have moved relative to each other since the pairs were found, at most \[m\].
    pub travelled: f32,
    pub friction: f32,
    /// How far a pair is moved apart without speed, at most \[m\].
    pub most_push: f32,
}

/// Where the particles of a cloth lie on colliders, which bear a part of what pushes them (`contact::active_set`).
pub(in crate::solver) struct Lying<'a> {
    /// By slot, of length one; zero where a particle lies on none.
    pub normal: &'a Soa,
    /// By slot, the part of its inverse mass that moves a particle along the surface.
    pub slip: &'a [f32],
    /// By slot, what the collider bears \[kg m\].
    pub load: &'a mut [f32],
}

impl Lying<'_> {
    /// The same, for a while.
    pub fn reborrow(&mut self) -> Lying<'_> {
        Lying { normal: self.normal, slip: self.slip, load: self.load }
    }
}

/// A cloth whose particles are moved.
pub(super) struct Side<'a> {
    pub normals: &'a Normals,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Where its particles lie on colliders, if any do.
    pub lying: Option<Lying<'a>>,
    /// Particles that stand down, where any do.
    pub is_down: Option<&'a [bool]>,
}

/// The cloths that the first and the second particles of pairs are of.
pub(super) trait Sides {
    /// The cloth of the first particles, or of the second.
    fn side(&self, second: bool) -> &Side<'_>;
    /// Gives a particle momentum \[kg m\], and moves it without speed \[kg m\].
    fn give(&mut self, second: bool, slot: usize, momentum: Vec3, pushed: Vec3);
    /// From the origin of the second cloth to that of the first \[m\].
    fn shift(&self) -> Vec3;
}

impl Sides for Side<'_> {
    #[inline(always)]
    fn side(&self, _: bool) -> &Side<'_> {
        self
    }

    #[inline(always)]
    fn give(&mut self, _: bool, slot: usize, momentum: Vec3, pushed: Vec3) {
        Side::give(self, slot, momentum, pushed);
    }

    #[inline(always)]
    fn shift(&self) -> Vec3 {
        Vec3::ZERO
    }
}

/// Two cloths.
pub(super) struct Two<'a> {
    pub first: Side<'a>,
    pub second: Side<'a>,
    /// From the origin of the second to that of the first \[m\].
    pub shift: Vec3,
}

impl Sides for Two<'_> {
    #[inline(always)]
    fn side(&self, second: bool) -> &Side<'_> {
        if second { &self.second } else { &self.first }
    }

    #[inline(always)]
    fn give(&mut self, second: bool, slot: usize, momentum: Vec3, pushed: Vec3) {
        let side = if second { &mut self.second } else { &mut self.first };
        side.give(slot, momentum, pushed);
    }

    #[inline(always)]
    fn shift(&self) -> Vec3 {
        self.shift
    }
}

/// The pairs that touched in a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Touched {
    /// Pairs that touched.
    pub count: u32,
    /// Whether any of them was so deep that there may be a tangle.
    pub is_deep: bool,
}

impl<S: Sides> Respond<'_, S> {
    /// Meets all pairs that may touch.
    pub fn run(mut self) -> Touched {
        let mut touched = Touched::default();
        let travelled = larger(self.travelled, f32::MIN_POSITIVE);
        for pair in self.pairs {
            if pair.gap < travelled {
                self.meet(pair, &mut touched);
            }
        }
        touched
    }

    #[inline(always)]
    fn meet(&mut self, pair: &Pair, touched: &mut Touched) {
        let [a, b] = pair.slots.map(|slot| slot as usize);
        let (first, second) = (self.sides.side(false), self.sides.side(true));
        let relative = first.d.get(a) - second.d.get(b);
        let apart = first.x.get(a) - second.x.get(b) + self.sides.shift() + relative;
        let square = apart.dot(apart);
        // What is no number touches nothing.
        let touches = square < pair.reach * pair.reach;
        if !touches {
            return;
        }
        if first.is_down(a) && second.is_down(b) {
            return;
        }
        let (w_a, w_b) = (first.inverse_mass[a], second.inverse_mass[b]);
        if w_a + w_b == 0.0 {
            return;
        }
        let distance = square.sqrt();
        let is_somewhere = distance > LEAST_DISTANCE * pair.reach;
        let normals = [first.normals.at(a), second.normals.at(b)];
        let normal = if is_somewhere { direction(normals, apart, distance) } else { Vec3::Y };
        touched.count += 1;
        touched.is_deep |= distance < (1.0 - DEEP) * pair.reach;
        // As far along the normal as they are to be apart.
        let above = apart.dot(normal);
        let depth = (above * above + (pair.reach * pair.reach - square)).sqrt() - above;
        let along = relative.dot(normal);
        let undone = smaller(larger(-along, 0.0), depth);
        let masses = [w_a, w_b].map(|w| w * LEAST_MOBILITY);
        let least = masses[0] + masses[1];
        let share = 1.0 / larger(first.mobility(a, normal) + second.mobility(b, normal), least);
        let pressed = undone * share;
        let mut momentum = normal * pressed;
        let sliding = relative - normal * along;
        let way = sliding.dot(sliding);
        if way > 0.0 {
            let way = way.sqrt();
            let slid = sliding * (1.0 / way);
            let yields = larger(first.mobility(a, slid) + second.mobility(b, slid), least);
            momentum -= slid * smaller(self.friction * pressed, way / yields);
        }
        let pushed = normal * (smaller(depth - undone, self.most_push) * share);
        self.sides.give(false, a, momentum, pushed);
        self.sides.give(true, b, -momentum, -pushed);
    }
}

impl Side<'_> {
    #[inline(always)]
    fn is_down(&self, slot: usize) -> bool {
        self.is_down.is_some_and(|is_down| is_down[slot])
    }

    /// How far momentum of one along a direction moves a particle \[1/kg\].
    #[inline(always)]
    fn mobility(&self, slot: usize, direction: Vec3) -> f32 {
        let w = self.inverse_mass[slot];
        let Some(lying) = &self.lying else { return w };
        let onto = lying.normal.get(slot).dot(direction);
        w * lying.slip[slot] * (1.0 - onto * onto)
    }

    #[inline(always)]
    fn give(&mut self, slot: usize, momentum: Vec3, pushed: Vec3) {
        let (mut w, mut momentum, mut pushed) = (self.inverse_mass[slot], momentum, pushed);
        if let Some(Lying { normal, slip, load }) = &mut self.lying {
            let n = normal.get(slot);
            let onto = n.dot(momentum);
            load[slot] += onto;
            momentum -= n * onto;
            pushed -= n * n.dot(pushed);
            w *= slip[slot];
        }
        self.d.set(slot, self.d.get(slot) + momentum * w);
        self.x.set(slot, self.x.get(slot) + pushed * w);
    }
}
