//! Vectors by slot, whoever holds them, and what can be cut between slots.

use core::ops::Range;

use bevy_math::Vec3;

use crate::solver::simd::lanes::LANES;

/// A vector for each of some neighbouring slots.
pub(crate) trait Slots {
    /// The first of them.
    fn first(&self) -> usize;
    /// Coordinates, from that of the first slot on.
    fn axes(&self) -> [&[f32]; 3];

    /// The vector of a slot.
    #[inline(always)]
    fn get(&self, slot: usize) -> Vec3 {
        let at = slot - self.first();
        let [x, y, z] = self.axes();
        Vec3::new(x[at], y[at], z[at])
    }
}

/// [`Slots`] that can be written.
pub(crate) trait SlotsMut: Slots {
    /// See [`Slots::axes`].
    fn axes_mut(&mut self) -> [&mut [f32]; 3];

    /// Sets the vector of a slot.
    #[inline(always)]
    fn set(&mut self, slot: usize, value: Vec3) {
        let at = slot - self.first();
        let [x, y, z] = self.axes_mut();
        (x[at], y[at], z[at]) = value.into();
    }
}

/// Data by slot that a kernel writes, and that can be cut in two.
pub(crate) trait CutAt: Sized {
    /// The data before a slot, and the rest.
    fn cut(self, slot: usize) -> (Self, Self);
}

impl<T: CutAt> CutAt for Option<T> {
    fn cut(self, slot: usize) -> (Self, Self) {
        self.map(|part| part.cut(slot)).unzip()
    }
}

/// Values of neighbouring slots, written while others write those of the rest.
#[derive(Debug)]
pub(crate) struct SlotsOf<'a, T> {
    first: usize,
    pub values: &'a mut [T],
}

impl<'a, T> SlotsOf<'a, T> {
    /// The values of all slots.
    pub fn all(values: &'a mut [T]) -> Self {
        Self { first: 0, values }
    }

    /// The values of some slots.
    #[inline(always)]
    pub fn within(&mut self, slots: &Range<usize>) -> SlotsOf<'_, T> {
        let values = &mut self.values[slots.start - self.first..slots.end - self.first];
        SlotsOf { first: slots.start, values }
    }

    /// The values from a slot on.
    #[inline(always)]
    pub fn from(&mut self, slot: usize) -> &mut [T] {
        &mut self.values[slot - self.first..]
    }
}

impl<T> CutAt for SlotsOf<'_, T> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (values, below) = self.values.split_at_mut(slot - self.first);
        (Self { first: self.first, values }, Self { first: slot, values: below })
    }
}

/// Values of the blocks of a band.
pub(crate) struct ByBlock<'a, T> {
    first: usize,
    values: &'a mut [T],
}

impl<'a, T> ByBlock<'a, T> {
    /// The values of all blocks, from the first slot on.
    pub fn all(values: &'a mut [T]) -> Self {
        Self { first: 0, values }
    }

    /// The values of so many blocks from a slot on.
    #[inline(always)]
    pub fn row(&mut self, slot: usize, blocks: usize) -> &mut [T] {
        &mut self.values[slot / LANES - self.first..][..blocks]
    }
}

impl<T> CutAt for ByBlock<'_, T> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let block = slot / LANES;
        let (values, below) = self.values.split_at_mut(block - self.first);
        (Self { first: self.first, values }, Self { first: block, values: below })
    }
}
