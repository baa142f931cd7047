//! Pairs of particles that touch are moved apart, with friction.

use bevy_math::Vec3;

use crate::solver::cloth_contact::find::Pair;
use crate::solver::cloth_contact::normals::{Normals, direction};
use crate::solver::simd::block::{larger, smaller};
use crate::solver::simd::soa::Soa;

/// Least distance between two particles that has a direction, in distances at which they touch.
const LEAST_DISTANCE: f32 = 1e-6;

/// Moves apart what touches, one pair after the other.
///
/// The approach that a push undoes is taken from the displacements, and with it friction brakes what slides. The rest of the depth
/// is a displacement without velocity, as at colliders: moving out of each other gives no speed.
///
/// Its change of the displacements is a correction like those of the threads, and half of it is expected again in the next
/// substep (`integrate::houbolt`). The threads then find layers apart that they press together, and do not stretch for it.
pub(super) struct Respond<'a, S> {
    pub pairs: &'a [Pair],
    pub sides: S,
    /// How far particles have moved relative to each other since the pairs were found, at most \[m\].
    pub travelled: f32,
    pub friction: f32,
    /// How far a pair is moved apart without speed, at most \[m\].
    pub most_push: f32,
}

/// A cloth whose particles are moved.
pub(super) struct Side<'a> {
    pub normals: &'a Normals,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    /// Displacements of particles that lie on colliders, before corrections pulled at them.
    pub unpulled: Option<&'a mut Soa>,
    /// Particles that stand down, where any do.
    pub is_down: Option<&'a [bool]>,
}

/// The cloths that the first and the second particles of pairs are of.
pub(super) trait Sides {
    /// The cloth of the first particles, or of the second.
    fn side(&self, second: bool) -> &Side<'_>;
    /// The same, to move its particles.
    fn move_by(&mut self, second: bool, slot: usize, change: Vec3, pushed: Vec3);
    /// From the origin of the second cloth to that of the first \[m\].
    fn shift(&self) -> Vec3;
}

impl Sides for Side<'_> {
    #[inline(always)]
    fn side(&self, _: bool) -> &Side<'_> {
        self
    }

    #[inline(always)]
    fn move_by(&mut self, _: bool, slot: usize, change: Vec3, pushed: Vec3) {
        Side::move_by(self, slot, change, pushed);
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
    fn move_by(&mut self, second: bool, slot: usize, change: Vec3, pushed: Vec3) {
        let side = if second { &mut self.second } else { &mut self.first };
        side.move_by(slot, change, pushed);
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
    /// Depth of the deepest of them, in distances at which it touches.
    pub deepest: f32,
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
        touched.deepest = larger(touched.deepest, 1.0 - distance / pair.reach);
        // As far along the normal as they are to be apart.
        let above = apart.dot(normal);
        let depth = (above * above + (pair.reach * pair.reach - square)).sqrt() - above;
        let along = relative.dot(normal);
        let undone = smaller(larger(-along, 0.0), depth);
        let sliding = relative - normal * along;
        let way = sliding.dot(sliding).sqrt();
        let held = self.friction * undone;
        let braked = if way > held { held / way } else { 1.0 };
        let change = normal * undone - sliding * braked;
        let pushed = normal * smaller(depth - undone, self.most_push);
        let share = 1.0 / (w_a + w_b);
        self.sides.move_by(false, a, change * (w_a * share), pushed * (w_a * share));
        self.sides.move_by(true, b, change * (-w_b * share), pushed * (-w_b * share));
    }
}

impl Side<'_> {
    #[inline(always)]
    fn is_down(&self, slot: usize) -> bool {
        self.is_down.is_some_and(|is_down| is_down[slot])
    }

    #[inline(always)]
    fn move_by(&mut self, slot: usize, change: Vec3, pushed: Vec3) {
        self.d.set(slot, self.d.get(slot) + change);
        self.x.set(slot, self.x.get(slot) + pushed);
        // What lies on a collider is not pulled by it.
        if let Some(unpulled) = &mut self.unpulled {
            unpulled.set(slot, unpulled.get(slot) + change);
        }
    }
}
