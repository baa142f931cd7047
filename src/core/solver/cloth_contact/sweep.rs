//! Boxes that are near each other, found in the order in which they begin along x.

use bevy_math::Vec3;

use crate::solver::cloth_contact::grid::{NOWHERE, room_for};
use crate::solver::cloth_contact::regions::Extent;
use crate::solver::simd::block::{Block3, larger};
use crate::solver::simd::isa::{Isa, Kernel};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::soa::Soa;

/// Boxes in order.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    /// Their keys.
    order: Vec<u64>,
    low: Soa,
    high: Soa,
    /// Pairs of numbers of boxes that are near each other.
    near: Vec<[u32; 2]>,
}

impl Sweep {
    /// With room for so many boxes, and pairs of them that are near each other.
    pub fn with_room(count: usize, pairs: usize) -> Self {
        let [low, high] = [(); 2].map(|()| Soa::zeros(room_for(count)));
        Self { order: Vec::with_capacity(count), low, high, near: Vec::with_capacity(pairs) }
    }

    /// The pairs of boxes that are nearer to each other than `reach` along every axis.
    pub fn near<'a>(
        &mut self,
        isa: Isa,
        count: usize,
        extent: impl Fn(u32) -> &'a Extent,
        reach: f32,
    ) -> &[[u32; 2]] {
        let Self { order, low, high, near } = self;
        order.clear();
        order.extend((0..count as u32).map(|number| key(extent(number).low.x, number)));
        order.sort_unstable();
        for (place, &key) in order.iter().enumerate() {
            let Extent { low: begin, high: end } = extent(number(key));
            low.set(place, *begin);
            high.set(place, *end);
        }
        for place in count..count + LANES {
            low.set(place, Vec3::splat(NOWHERE));
            high.set(place, Vec3::splat(NOWHERE));
        }
        near.clear();
        isa.run(FindNear { order, low, high, reach, near });
        near
    }
}

/// A number of which the upper half says where a box begins, in ascending order, and the lower one is the box's own number.
fn key(begin: f32, number: u32) -> u64 {
    let bits = begin.to_bits();
    // As whole numbers, negative ones have the opposite order, and come after the others.
    let ascending = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    u64::from(ascending) << 32 | u64::from(number)
}

/// The number of the box of a key.
#[inline(always)]
fn number(key: u64) -> u32 {
    key as u32
}

struct FindNear<'a> {
    order: &'a [u64],
    low: &'a Soa,
    high: &'a Soa,
    reach: f32,
    near: &'a mut Vec<[u32; 2]>,
}

impl Kernel for FindNear<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { order, low, high, reach, near } = self;
        for (place, &key) in order.iter().enumerate() {
            let (a_low, a_high) = (low.get(place), high.get(place));
            let end = a_high.x + reach;
            let mut at = place + 1;
            while at < order.len() && low.x[at] < end {
                let (b_low, b_high) = (Block3::load(low, at), Block3::load(high, at));
                let mut bits = [0_u32; LANES];
                for (i, bit) in bits.iter_mut().enumerate() {
                    let (after, before) = (b_low.at(i) - a_high, a_low - b_high.at(i));
                    let x = larger(after.x, before.x);
                    let y = larger(after.y, before.y);
                    let z = larger(after.z, before.z);
                    *bit = if larger(larger(x, y), z) < reach { 1 << i } else { 0 };
                }
                let mut lanes = bits.into_iter().fold(0, |all, bit| all | bit);
                while lanes != 0 {
                    let other = order[at + lanes.trailing_zeros() as usize];
                    near.push([number(key), number(other)]);
                    lanes &= lanes - 1;
                }
                at += LANES;
            }
        }
    }
}
