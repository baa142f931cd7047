//! Fixed-width blocks of particles: what the kernels compute with.
//!
//! A kernel loads blocks from the rows, runs one loop over their lanes with the arithmetic of a single
//! particle in its body, and stores blocks. The compiler turns that loop into vector instructions; it
//! does not do so for loops over slices that are fields of a struct, nor where the body calls anything
//! that is not inlined (`Vec3::length` is such a call, `f32::sqrt` is not, a closure or a `map` over an array may be).
//!
//! The kernels that take the time have their blocks from [`Blocks`], a row at a time; others load them one by one.

use bevy_math::Vec3;

use crate::solver::simd::lanes::LANES;
use crate::solver::simd::slots::{Slots, SlotsMut};

/// One coordinate of [`LANES`] neighbouring particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block(pub [f32; LANES]);

/// A vector for each of [`LANES`] neighbouring particles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block3 {
    pub x: Block,
    pub y: Block,
    pub z: Block,
}

/// The number of which only bit i is set, for each lane.
const BITS: [f32; LANES] = {
    let mut bits = [1.0; LANES];
    let mut i = 1;
    while i < LANES {
        bits[i] = 2.0 * bits[i - 1];
        i += 1;
    }
    bits
};

impl Block {
    pub const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    pub fn load(slice: &[f32], at: usize) -> Self {
        let mut out = [0.0; LANES];
        out.copy_from_slice(&slice[at..at + LANES]);
        Self(out)
    }

    #[inline(always)]
    pub fn store(self, slice: &mut [f32], at: usize) {
        slice[at..at + LANES].copy_from_slice(&self.0);
    }

    /// The sums of each lane.
    #[inline(always)]
    pub fn plus(mut self, other: &Self) -> Self {
        for i in 0..LANES {
            self.0[i] += other.0[i];
        }
        self
    }

    /// Each lane, multiplied.
    #[inline(always)]
    pub fn times(mut self, factor: f32) -> Self {
        for lane in &mut self.0 {
            *lane *= factor;
        }
        self
    }

    /// Each lane with its sign changed.
    #[inline(always)]
    pub fn negated(mut self) -> Self {
        for lane in &mut self.0 {
            *lane = -*lane;
        }
        self
    }

    /// The largest lane. The order of comparing does not change its value.
    #[inline(always)]
    pub fn largest(&self) -> f32 {
        let mut lanes = self.0;
        let mut width = LANES;
        while width > 1 {
            width /= 2;
            for i in 0..width {
                lanes[i] = larger(lanes[i], lanes[i + width]);
            }
        }
        lanes[0]
    }

    /// Whether any lane is above a number.
    #[inline(always)]
    pub fn is_any_above(&self, bound: f32) -> bool {
        let mut any = false;
        for lane in self.0 {
            any |= lane > bound;
        }
        any
    }

    /// The lanes that are above a number, a bit each.
    // The bits are added up as numbers, half by half: the compiler would take them one by one.
    #[inline(always)]
    pub fn bits_above(&self, bound: f32) -> u32 {
        let mut lanes = [0.0; LANES];
        for i in 0..LANES {
            lanes[i] = if self.0[i] > bound { BITS[i] } else { 0.0 };
        }
        let mut width = LANES;
        while width > 1 {
            width /= 2;
            for i in 0..width {
                lanes[i] += lanes[i + width];
            }
        }
        lanes[0] as u32
    }

    /// Whether any lane is another number than zero.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        let mut any = false;
        for lane in self.0 {
            any |= lane != 0.0;
        }
        any
    }

    /// The smallest lane.
    #[inline(always)]
    pub fn smallest(&self) -> f32 {
        -self.negated().largest()
    }
}

impl Block3 {
    pub const ZERO: Self = Self { x: Block::ZERO, y: Block::ZERO, z: Block::ZERO };

    #[inline(always)]
    pub fn splat(value: Vec3) -> Self {
        Self { x: Block::splat(value.x), y: Block::splat(value.y), z: Block::splat(value.z) }
    }

    #[inline(always)]
    pub fn load(from: &impl Slots, at: usize) -> Self {
        let [x, y, z] = from.axes();
        let at = at - from.first();
        Self { x: Block::load(x, at), y: Block::load(y, at), z: Block::load(z, at) }
    }

    #[inline(always)]
    pub fn store(self, to: &mut impl SlotsMut, at: usize) {
        let at = at - to.first();
        let [x, y, z] = to.axes_mut();
        self.x.store(x, at);
        self.y.store(y, at);
        self.z.store(z, at);
    }

    /// The sums of two arrays: positions and what they are displaced by.
    #[inline(always)]
    pub fn load_sum(a: &impl Slots, b: &impl Slots, at: usize) -> Self {
        Self::load(a, at).plus(&Self::load(b, at))
    }

    /// The sums of each lane's vectors.
    #[inline(always)]
    pub fn plus(mut self, other: &Self) -> Self {
        for i in 0..LANES {
            self.set(i, self.at(i) + other.at(i));
        }
        self
    }

    /// Each lane's vector, multiplied.
    #[inline(always)]
    pub fn times(mut self, factor: f32) -> Self {
        for i in 0..LANES {
            self.set(i, self.at(i) * factor);
        }
        self
    }

    /// The cross products with another.
    #[inline(always)]
    pub fn cross(&self, other: &Self) -> Self {
        let mut cross = Self::ZERO;
        for i in 0..LANES {
            cross.set(i, self.at(i).cross(other.at(i)));
        }
        cross
    }

    /// The sum over the lanes: of halves, and of halves of these.
    // Inlined behind a loop that adds up, it has the compiler split what is added up there, lane by lane.
    #[inline(never)]
    pub fn sum(&self) -> Vec3 {
        let mut lanes = *self;
        let mut width = LANES;
        while width > 1 {
            width /= 2;
            for i in 0..width {
                lanes.set(i, lanes.at(i) + lanes.at(i + width));
            }
        }
        lanes.at(0)
    }

    /// The vector of one lane.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x.0[lane], self.y.0[lane], self.z.0[lane])
    }

    /// Sets the vector of one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: Vec3) {
        self.x.0[lane] = value.x;
        self.y.0[lane] = value.y;
        self.z.0[lane] = value.z;
    }
}

/// Blocks side by side, from any slot on. Whether they are in memory is checked once for all of them, not
/// for each: checks were half of a kernel's instructions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks<'a>(&'a [[f32; LANES]]);

impl<'a> Blocks<'a> {
    /// So many blocks of a slice.
    #[inline(always)]
    pub fn new(slice: &'a [f32], at: usize, count: usize) -> Self {
        let (blocks, _) = slice[at..].as_chunks();
        Self(&blocks[..count])
    }

    #[inline(always)]
    pub fn at(&self, block: usize) -> Block {
        Block(self.0[block])
    }
}

/// [`Blocks`] that can be written.
#[derive(Debug)]
pub(crate) struct BlocksMut<'a>(&'a mut [[f32; LANES]]);

impl<'a> BlocksMut<'a> {
    /// So many blocks of a slice.
    #[inline(always)]
    pub fn new(slice: &'a mut [f32], at: usize, count: usize) -> Self {
        let (blocks, _) = slice[at..].as_chunks_mut();
        Self(&mut blocks[..count])
    }

    #[inline(always)]
    pub fn at(&self, block: usize) -> Block {
        Block(self.0[block])
    }

    #[inline(always)]
    pub fn set(&mut self, block: usize, value: Block) {
        self.0[block] = value.0;
    }

    /// Adds to a block.
    #[inline(always)]
    pub fn add(&mut self, block: usize, value: &Block) {
        self.set(block, self.at(block).plus(value));
    }
}

/// [`Blocks`] of vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks3<'a>([Blocks<'a>; 3]);

impl<'a> Blocks3<'a> {
    /// So many blocks from a slot on.
    #[inline(always)]
    pub fn new(from: &'a impl Slots, slot: usize, count: usize) -> Self {
        let at = slot - from.first();
        let [x, y, z] = from.axes();
        Self([Blocks::new(x, at, count), Blocks::new(y, at, count), Blocks::new(z, at, count)])
    }

    #[inline(always)]
    pub fn at(&self, block: usize) -> Block3 {
        let [x, y, z] = &self.0;
        Block3 { x: x.at(block), y: y.at(block), z: z.at(block) }
    }
}

/// [`Blocks3`] that can be written.
#[derive(Debug)]
pub(crate) struct Blocks3Mut<'a>([BlocksMut<'a>; 3]);

impl<'a> Blocks3Mut<'a> {
    /// So many blocks from a slot on.
    #[inline(always)]
    pub fn new(of: &'a mut impl SlotsMut, slot: usize, count: usize) -> Self {
        let at = slot - of.first();
        let [x, y, z] = of.axes_mut();
        let blocks = |axis| BlocksMut::new(axis, at, count);
        Self([blocks(x), blocks(y), blocks(z)])
    }

    #[inline(always)]
    pub fn at(&self, block: usize) -> Block3 {
        let [x, y, z] = &self.0;
        Block3 { x: x.at(block), y: y.at(block), z: z.at(block) }
    }

    #[inline(always)]
    pub fn set(&mut self, block: usize, value: Block3) {
        let [x, y, z] = &mut self.0;
        x.set(block, value.x);
        y.set(block, value.y);
        z.set(block, value.z);
    }

    /// Adds to a block.
    #[inline(always)]
    pub fn add(&mut self, block: usize, value: &Block3) {
        self.set(block, self.at(block).plus(value));
    }
}

/// The places of the bits that are set, ascending.
#[inline(always)]
pub(crate) fn ones(mut bits: u32) -> impl Iterator<Item = usize> {
    core::iter::from_fn(
        #[inline(always)]
        move || {
            let at = bits.trailing_zeros() as usize;
            let is_any = bits != 0;
            bits &= bits.wrapping_sub(1);
            is_any.then_some(at)
        },
    )
}

/// The larger of two numbers; the second where either is NaN. One instruction, where `f32::max` is
/// several.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; the second where either is NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
