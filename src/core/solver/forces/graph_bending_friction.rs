//! Friction of bending on the wide hinges of a triangle mesh.

use bevy_math::Vec3;

use crate::solver::simd::soa::{Array, Soa};
use crate::solver::topology::graph::wide_hinges::{WideHinge, WideHinges, weights};

/// Least bend that has a direction \[m\].
const LEAST_BEND: f32 = 1e-10;

impl WideHinges {
    /// Brakes the bending of all, one after the other, by no more than `part` of what stops it. `most` is what friction moves a
    /// particle of mass one by \[m\], for a force of one.
    pub fn brake(&self, part: f32, most: f32, inverse_mass: &Array, x: &Soa, d: &mut Soa) {
        for span in &self.0 {
            span.brake(part, most, inverse_mass, x, d);
        }
    }
}

impl WideHinge {
    fn brake(&self, part: f32, most: f32, inverse_mass: &Array, x: &Soa, d: &mut Soa) {
        // Not by `map`s of the arrays, which would be calls.
        let [middle, a, b, c] = self.slots;
        let (middle, around) = (middle as usize, [a as usize, b as usize, c as usize]);
        let (here, moved) = (x.get(middle), d.get(middle));
        let [a, b, c] = around;
        let ways = [x.get(a) - here, x.get(b) - here, x.get(c) - here];
        let Some(weights) = weights(ways) else { return };
        let (mut bend, mut rate, mut w) = (Vec3::ZERO, Vec3::ZERO, inverse_mass[middle]);
        for (i, &slot) in around.iter().enumerate() {
            bend += ways[i] * weights[i];
            rate += (d.get(slot) - moved) * weights[i];
            w += inverse_mass[slot] * (weights[i] * weights[i]);
        }
        let length = bend.dot(bend).sqrt();
        if length < LEAST_BEND || w == 0.0 {
            return;
        }
        let most = most * self.most;
        let impulse = (part * bend.dot(rate) / (length * w)).clamp(-most, most);
        let impulse = bend * (impulse / length);
        d.set(middle, moved + impulse * inverse_mass[middle]);
        for (slot, weight) in around.into_iter().zip(weights) {
            d.set(slot, d.get(slot) - impulse * (weight * inverse_mass[slot]));
        }
    }
}
