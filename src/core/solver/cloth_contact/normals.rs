//! Normals of the surface at particles, by which layers that lie on each other slide.
//!
//! Balls make a layer as rough as a tray of eggs: two of them would lock into each other, and slide under no friction at all. So
//! particles of layers that face each other are pushed apart along the normal of both, and only what meets otherwise, as rims and
//! tips do, along the line between them.

use bevy_math::Vec3;

use crate::solver::cloth_contact::beads::Beads;
use crate::solver::simd::block::{Block3, larger, smaller};
use crate::solver::simd::lanes::{LANES, is_any};
use crate::solver::simd::transpose::{Four, Transpose};

/// Cosines of the angle between two normals from which on layers face each other a little, and wholly.
const FACING: [f32; 2] = [0.7, 0.9];
/// Cosines of the angle between normal and the line from particle to particle, in the same way.
const ABOVE: [f32; 2] = [0.3, 0.5];

/// Normals of length one of the particles at some slots that touch. They are worked out where they are not known.
#[inline(always)]
pub(super) fn gather(
    t: impl Transpose,
    beads: &mut Beads,
    slots: &[u32; LANES],
    touches: &[u32; LANES],
    normal: impl Fn(usize) -> Vec3,
) -> Block3 {
    let normals = &mut *beads.normals;
    let [mut x, mut y, mut z, known] = t.apart(|i| normals[slots[i] as usize]);
    let mut unknown = [0; LANES];
    for i in 0..LANES {
        unknown[i] = if known.0[i] == 0.0 { touches[i] } else { 0 };
    }
    if is_any(&unknown) {
        for i in (0..LANES).filter(|&i| unknown[i] != 0) {
            let slot = slots[i] as usize;
            let Vec3 { x, y, z } = normal(slot);
            normals[slot] = Four([x, y, z, 1.0]);
        }
        [x, y, z, _] = t.apart(|i| normals[slots[i] as usize]);
    }
    Block3 { x, y, z }
}

/// The direction to push two particles of these normals apart, of which one is at some vector of that length from the other.
#[inline(always)]
pub(super) fn direction([n_a, n_b]: [Vec3; 2], apart: Vec3, distance: f32) -> Vec3 {
    let cosine = n_a.dot(n_b);
    let both = if cosine < 0.0 { n_a - n_b } else { n_a + n_b };
    let length = both.dot(both).sqrt();
    let line = apart * (1.0 / distance);
    let normal = both * (1.0 / larger(length, f32::MIN_POSITIVE));
    let above = line.dot(normal);
    let part = ramp(cosine.abs(), FACING) * ramp(above.abs(), ABOVE);
    let normal = if above < 0.0 { -normal } else { normal };
    let between = line * (1.0 - part) + normal * part;
    between * (1.0 / between.dot(between).sqrt())
}

/// From 0 at the first of two numbers to 1 at the second.
#[inline(always)]
fn ramp(value: f32, [from, to]: [f32; 2]) -> f32 {
    smaller(larger((value - from) * (1.0 / (to - from)), 0.0), 1.0)
}
