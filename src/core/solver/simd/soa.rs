//! Structure-of-arrays storage: one aligned array a coordinate, whole or in parts that are written side by side.

use core::ops::{Deref, DerefMut};

use bevy_math::Vec3;

use crate::solver::simd::block::{Block, BlocksMut};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::{CutAt, Slots, SlotsMut};

/// Floats that begin at a whole cache line, so that an aligned block lies in one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Array(Vec<Line>);

#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct Line([f32; LANES]);

impl Array {
    /// `len` zeros, a whole number of blocks.
    pub fn zeros(len: usize) -> Self {
        Self(vec![Line([0.0; LANES]); len.div_ceil(LANES)])
    }
}

impl Deref for Array {
    type Target = [f32];

    #[inline(always)]
    fn deref(&self) -> &[f32] {
        bytemuck::must_cast_slice(&self.0)
    }
}

impl DerefMut for Array {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f32] {
        bytemuck::must_cast_slice_mut(&mut self.0)
    }
}

/// A vector a particle, as structure of arrays.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Soa {
    pub x: Array,
    pub y: Array,
    pub z: Array,
}

impl Soa {
    pub fn zeros(len: usize) -> Self {
        let array = Array::zeros(len);
        Self { x: array.clone(), y: array.clone(), z: array }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        for axis in [&mut self.x, &mut self.y, &mut self.z] {
            axis.fill(0.0);
        }
    }

    /// All of it, to be cut into parts.
    pub fn part_mut(&mut self) -> PartMut<'_> {
        PartMut { first: 0, x: &mut self.x, y: &mut self.y, z: &mut self.z }
    }

    #[inline(always)]
    pub fn get(&self, at: usize) -> Vec3 {
        Slots::get(self, at)
    }

    #[inline(always)]
    pub fn set(&mut self, at: usize, value: Vec3) {
        SlotsMut::set(self, at, value);
    }

    /// Takes over the values of `other`, which has the same length.
    pub fn copy_from(&mut self, other: &Self) {
        self.x.copy_from_slice(&other.x);
        self.y.copy_from_slice(&other.y);
        self.z.copy_from_slice(&other.z);
    }
}

impl Slots for Soa {
    #[inline(always)]
    fn first(&self) -> usize {
        0
    }

    #[inline(always)]
    fn axes(&self) -> [&[f32]; 3] {
        [&self.x, &self.y, &self.z]
    }
}

impl SlotsMut for Soa {
    #[inline(always)]
    fn axes_mut(&mut self) -> [&mut [f32]; 3] {
        [&mut self.x, &mut self.y, &mut self.z]
    }
}

/// A part of a [`Soa`] that is written while others write the rest.
#[derive(Debug)]
pub(crate) struct PartMut<'a> {
    first: usize,
    x: &'a mut [f32],
    y: &'a mut [f32],
    z: &'a mut [f32],
}

/// A part of a [`Soa`], or a copy of one, under the slots that it has there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<'a> {
    pub first: usize,
    pub axes: [&'a [f32]; 3],
}

impl Slots for Part<'_> {
    #[inline(always)]
    fn first(&self) -> usize {
        self.first
    }

    #[inline(always)]
    fn axes(&self) -> [&[f32]; 3] {
        self.axes
    }
}

impl PartMut<'_> {
    /// Reborrows the part.
    #[inline(always)]
    pub fn reborrow(&mut self) -> PartMut<'_> {
        PartMut { first: self.first, x: self.x, y: self.y, z: self.z }
    }
}

impl CutAt for PartMut<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let at = slot - self.first;
        let (x, below_x) = self.x.split_at_mut(at);
        let (y, below_y) = self.y.split_at_mut(at);
        let (z, below_z) = self.z.split_at_mut(at);
        let below = Self { first: slot, x: below_x, y: below_y, z: below_z };
        (Self { first: self.first, x, y, z }, below)
    }
}

impl Slots for PartMut<'_> {
    #[inline(always)]
    fn first(&self) -> usize {
        self.first
    }

    #[inline(always)]
    fn axes(&self) -> [&[f32]; 3] {
        [self.x, self.y, self.z]
    }
}

impl SlotsMut for PartMut<'_> {
    #[inline(always)]
    fn axes_mut(&mut self) -> [&mut [f32]; 3] {
        [self.x, self.y, self.z]
    }
}

/// A number for each of some neighbouring slots, written while others write those of the rest.
#[derive(Debug)]
pub(crate) struct ValuesMut<'a> {
    first: usize,
    values: &'a mut [f32],
}

impl<'a> ValuesMut<'a> {
    /// The values of all slots.
    pub fn all(values: &'a mut [f32]) -> Self {
        Self { first: 0, values }
    }

    /// The same, for a while.
    #[inline(always)]
    pub fn reborrow(&mut self) -> ValuesMut<'_> {
        ValuesMut { first: self.first, values: self.values }
    }

    /// So many blocks from a slot on.
    #[inline(always)]
    pub fn blocks(&mut self, slot: usize, count: usize) -> BlocksMut<'_> {
        BlocksMut::new(self.values, slot - self.first, count)
    }

    /// Sets the block of a slot.
    #[inline(always)]
    pub fn set(&mut self, slot: usize, values: &Block) {
        values.store(self.values, slot - self.first);
    }

    /// Adds to the block of a slot.
    #[inline(always)]
    pub fn add(&mut self, slot: usize, more: &Block) {
        let at = slot - self.first;
        Block::load(self.values, at).plus(more).store(self.values, at);
    }

    /// Sets the values of some slots.
    #[inline(always)]
    pub fn put(&mut self, slot: usize, values: &[f32]) {
        let at = slot - self.first;
        self.values[at..at + values.len()].copy_from_slice(values);
    }
}

impl CutAt for ValuesMut<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        let (values, below) = self.values.split_at_mut(slot - self.first);
        (Self { first: self.first, values }, Self { first: slot, values: below })
    }
}
