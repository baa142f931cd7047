//! Pairs of particles that touch are moved apart, with friction.

use bevy_math::Vec3;

use crate::solver::self_contact::find::Pair;
use crate::solver::self_contact::normals::Normals;
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
pub(super) struct Respond<'a> {
    pub pairs: &'a [Pair],
    pub normals: &'a Normals,
    /// How far particles have moved relative to each other since the pairs were found, at most \[m\].
    pub travelled: f32,
    pub friction: f32,
    /// How far a pair is moved apart without speed, at most \[m\].
    pub most_push: f32,
    pub inverse_mass: &'a [f32],
    pub x: &'a mut Soa,
    pub d: &'a mut Soa,
    pub unpulled: Option<&'a mut Soa>,
    /// Particles that stand down, where any do.
    pub is_down: Option<&'a [bool]>,
}

/// The pairs that touched in a substep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Touched {
    /// Pairs that touched.
    pub count: u32,
    /// Depth of the deepest of them, in distances at which it touches.
    pub deepest: f32,
}

impl Respond<'_> {
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
        let relative = self.d.get(a) - self.d.get(b);
        let apart = self.x.get(a) - self.x.get(b) + relative;
        let square = apart.dot(apart);
        if square >= pair.reach * pair.reach {
            return;
        }
        if self.is_down.is_some_and(|is_down| is_down[a] && is_down[b]) {
            return;
        }
        let (w_a, w_b) = (self.inverse_mass[a], self.inverse_mass[b]);
        if w_a + w_b == 0.0 {
            return;
        }
        let distance = square.sqrt();
        let is_somewhere = distance > LEAST_DISTANCE * pair.reach;
        let normal =
            if is_somewhere { self.normals.direction([a, b], apart, distance) } else { Vec3::Y };
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
        self.move_by(a, change * (w_a * share), pushed * (w_a * share));
        self.move_by(b, change * (-w_b * share), pushed * (-w_b * share));
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
