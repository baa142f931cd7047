//! Bending by second differences: linear in the positions, no square root where the rest shape is
//! flat, and convergent to the elastica (quadratic bending on a lattice; Bergou et al. 2006).
//!
//! A hinge is a particle and its two neighbours along a thread. Its turn is
//! `D = (x2 - x1) / L2 - (x1 - x0) / L1` and its energy `K |D|^2 / 2`, with K the flexural rigidity
//! times the width of cloth over the mean length of the two springs: on a uniform chain
//! `k_b (x0 - 2 x1 + x2)` with `k_b = B / a^3` per unit of width. A rest curvature of magnitude `D0`
//! makes it `K (|D| - D0)^2 / 2`. The forces have no resultant and no moment.

use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;
use crate::solver::topology::lattice::{Family, Lattice};

/// Turns below this count as flat at rest: some 0.06 degrees.
const FLAT: f32 = 1e-3;
/// Relative difference of rest lengths below which they count as the same.
const EVEN: f32 = 1e-5;
/// Least turn that has a direction.
const LEAST_TURN: f32 = 1e-9;

/// The hinges along one family of threads, an entry a hinge at the slot of its middle particle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hinges {
    /// From a particle to the next of its thread in memory.
    step: usize,
    /// 1 / rest length \[1/m\] of the spring to the next particle; 0 where there is none.
    inverse_rest: Vec<f32>,
    /// Width of cloth over mean spring length; 0 where there is no hinge.
    pub shape: Vec<f32>,
    /// Turn at rest; empty where all are flat.
    turn: Vec<f32>,
    /// 1 / rest length \[1/m\] where it is the same for all springs, and all is flat.
    even: Option<f32>,
}

impl Hinges {
    /// The hinges of both families, weft and warp. A hinge whose centre and one end are held while
    /// the other end is free is a clamp, and counts double (it stands for half a cell more).
    pub fn build(lattice: &Lattice, held: &[bool]) -> [Self; 2] {
        [
            Self::along(lattice, &lattice.weft, 1, held),
            Self::along(lattice, &lattice.warp, lattice.layout.stride, held),
        ]
    }

    fn along(lattice: &Lattice, springs: &Family, step: usize, held: &[bool]) -> Self {
        let len = lattice.layout.len();
        let mut hinges = Self {
            step,
            inverse_rest: springs
                .rest
                .iter()
                .map(|&l| if l > 0.0 { 1.0 / l } else { 0.0 })
                .collect(),
            shape: vec![0.0; len],
            turn: vec![0.0; len],
            even: None,
        };
        for slot in lattice.layout.slots() {
            let (l1, l2) = (springs.rest[slot - step], springs.rest[slot]);
            if l1 == 0.0 || l2 == 0.0 {
                continue;
            }
            let width = 0.5 * (springs.shape[slot - step] * l1 + springs.shape[slot] * l2);
            let clamp = held[slot] && (held[slot - step] != held[slot + step]);
            let factor = if clamp { 2.0 } else { 1.0 };
            hinges.shape[slot] = factor * width / (0.5 * (l1 + l2));
            hinges.turn[slot] = rest_turn(lattice, slot, step, l1, l2);
        }
        if hinges.turn.iter().all(|&turn| turn == 0.0) {
            hinges.turn = Vec::new();
            hinges.even = common(&hinges.inverse_rest);
        }
        hinges
    }

    /// Largest row sum of the stiffness matrix at a slot, for a flexural rigidity of one \[N/m\].
    pub fn row_sum(&self, slot: usize) -> f32 {
        let (l, r) = (slot - self.step, slot + self.step);
        let at = |hinge: usize, weight: f32| {
            let a = self.inverse_rest[hinge - self.step] + self.inverse_rest[hinge];
            self.shape[hinge] * weight * 2.0 * a
        };
        let before = self.inverse_rest[l];
        let after = self.inverse_rest[slot];
        at(l, before) + at(slot, before + after) + at(r, after)
    }
}

/// The value that all numbers above zero share, to within rounding of the lengths that they come from; `None` if they
/// differ.
fn common(inverse_rest: &[f32]) -> Option<f32> {
    let there = || inverse_rest.iter().copied().filter(|&inverse| inverse > 0.0);
    let (low, high) = there().fold((f32::MAX, 0.0_f32), |(l, h), i| (l.min(i), h.max(i)));
    (high > 0.0 && high - low <= EVEN * high).then_some(0.5 * (low + high))
}

fn rest_turn(lattice: &Lattice, slot: usize, step: usize, l1: f32, l2: f32) -> f32 {
    let layout = lattice.layout;
    let from_first = slot - layout.slot(0, 0);
    let (row, column) = (from_first / layout.stride, from_first % layout.stride);
    let at = row * layout.columns + column;
    let hop = if step == 1 { 1 } else { layout.columns };
    let p = &lattice.rest_positions;
    let turn = ((p[at + hop] - p[at]) / l2 - (p[at] - p[at - hop]) / l1).length();
    if turn > FLAT { turn } else { 0.0 }
}

/// Moments of the hinges that the present row of particles takes part in. They are worked out a row
/// at a time, so that they stay in the nearest cache and none is worked out twice.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    /// Slots of a row, with a block of zeros on both sides.
    width: usize,
    /// Hinges along weft threads: of this row.
    weft: Soa,
    /// Hinges along warp threads: of this row, the one before and the one after, in turn.
    warp: Soa,
}

impl Moments {
    pub fn new(layout: Layout) -> Self {
        let width = layout.stride + 2 * LANES;
        Self { width, weft: Soa::zeros(width), warp: Soa::zeros(3 * width) }
    }

    fn warp_row(&self, row: usize) -> usize {
        row % 3 * self.width + LANES
    }
}

/// The hinges of both families, for the forces of a row of particles.
#[derive(Clone, Copy)]
pub(crate) struct Bend<'a> {
    pub hinges: &'a [Hinges; 2],
    /// Flexural rigidity \[N m\].
    pub rigidity: f32,
    pub layout: Layout,
    pub x: &'a Soa,
}

impl Bend<'_> {
    /// Begins with a row: works out the moments that it and the row before have in common with it.
    #[inline(always)]
    pub fn begin(&self, moments: &mut Moments, row: usize) {
        if row == 0 {
            // Before the first row there are no hinges.
            moments.warp.clear();
        } else {
            self.bend_warp(moments, row - 1);
        }
        self.bend_warp(moments, row);
    }

    /// Works out the moments that a row needs. Rows are taken in their order.
    #[inline(always)]
    pub fn begin_row(&self, moments: &mut Moments, row: usize) {
        self.work_out(&self.hinges[0], row, &mut moments.weft, LANES);
        self.bend_warp(moments, row + 1);
    }

    #[inline(always)]
    fn bend_warp(&self, moments: &mut Moments, row: usize) {
        let at = moments.warp_row(row);
        self.work_out(&self.hinges[1], row, &mut moments.warp, at);
    }

    /// Works out the moments of the hinges in the middle of which the particles of a row are: `K D`, or `K D / L`
    /// where the springs are all of a length.
    #[inline(always)]
    fn work_out(&self, hinges: &Hinges, row: usize, to: &mut Soa, at: usize) {
        let (slot, blocks) = (self.layout.slot(row, 0), self.layout.blocks_across());
        let step = hinges.step;
        let x = |slot| Blocks3::new(self.x, slot, blocks);
        let (before, here, after) = (x(slot - step), x(slot), x(slot + step));
        let shape = Blocks::new(&hinges.shape, slot, blocks);
        let mut to = Blocks3Mut::new(to, at, blocks);
        if let Some(inverse) = hinges.even {
            let constant = self.rigidity * inverse * inverse;
            for block in 0..blocks {
                let (before, x, after) = (before.at(block), here.at(block), after.at(block));
                let shape = shape.at(block);
                let mut moment = Block3::ZERO;
                for i in 0..LANES {
                    let turn = (after.at(i) - x.at(i)) - (x.at(i) - before.at(i));
                    moment.set(i, turn * (shape.0[i] * constant));
                }
                to.set(block, moment);
            }
            return;
        }
        let inverse = |slot| Blocks::new(&hinges.inverse_rest, slot, blocks);
        let (in_before, in_after) = (inverse(slot - step), inverse(slot));
        for block in 0..blocks {
            let (before, x, after) = (before.at(block), here.at(block), after.at(block));
            let (in_before, in_after) = (in_before.at(block), in_after.at(block));
            let shape = shape.at(block);
            let mut moment = Block3::ZERO;
            for i in 0..LANES {
                let turn = (after.at(i) - x.at(i)) * in_after.0[i]
                    - (x.at(i) - before.at(i)) * in_before.0[i];
                moment.set(i, turn * (shape.0[i] * self.rigidity));
            }
            if !hinges.turn.is_empty() {
                self.take_off_rest_turn(hinges, slot + block * LANES, &mut moment);
            }
            to.set(block, moment);
        }
    }

    /// The hinges at the particles of a row: each is the middle of a hinge along both of its threads, and an end of
    /// those of its neighbours.
    #[inline(always)]
    pub fn at<'b>(&'b self, moments: &'b Moments, row: usize) -> [HingesAt<'b>; 2] {
        let (slot, blocks) = (self.layout.slot(row, 0), self.layout.blocks_across());
        let [weft, warp] = self.hinges;
        // One row before the first stands where the third does.
        let (before, own, after) =
            (moments.warp_row(row + 2), moments.warp_row(row), moments.warp_row(row + 1));
        [
            HingesAt::new(weft, slot, &moments.weft, [LANES - 1, LANES, LANES + 1], blocks),
            HingesAt::new(warp, slot, &moments.warp, [before, own, after], blocks),
        ]
    }

    /// `K D` becomes `K (D - D0 D / |D|)`.
    #[inline(always)]
    fn take_off_rest_turn(&self, hinges: &Hinges, slot: usize, moment: &mut Block3) {
        let turn = Block::load(&hinges.turn, slot);
        let shape = Block::load(&hinges.shape, slot);
        for i in 0..LANES {
            let m = moment.at(i);
            let at_rest = shape.0[i] * self.rigidity * turn.0[i];
            let length = larger(m.dot(m).sqrt(), LEAST_TURN * shape.0[i] * self.rigidity);
            let part = if length > 0.0 { at_rest / length } else { 0.0 };
            moment.set(i, m * (1.0 - part));
        }
    }
}

/// The hinges of a family at the particles of a row: the moments of those before, at and after each.
pub(crate) struct HingesAt<'a> {
    moments: [Blocks3<'a>; 3],
    /// 1 / rest length of the springs before and after each \[1/m\], where it is not the same for all.
    inverse_rest: Option<[Blocks<'a>; 2]>,
}

impl<'a> HingesAt<'a> {
    #[inline(always)]
    fn new(
        hinges: &'a Hinges,
        slot: usize,
        moments: &'a Soa,
        [before, own, after]: [usize; 3],
        blocks: usize,
    ) -> Self {
        let moments = |at| Blocks3::new(moments, at, blocks);
        let inverse = |slot| Blocks::new(&hinges.inverse_rest, slot, blocks);
        let inverse_rest = match hinges.even {
            Some(_) => None,
            None => Some([inverse(slot - hinges.step), inverse(slot)]),
        };
        Self { moments: [moments(before), moments(own), moments(after)], inverse_rest }
    }

    /// Forces on a block.
    #[inline(always)]
    pub fn forces(&self, block: usize) -> Block3 {
        let [before, own, after] = &self.moments;
        let (before, own, after) = (before.at(block), own.at(block), after.at(block));
        let mut force = Block3::ZERO;
        match &self.inverse_rest {
            None => {
                for i in 0..LANES {
                    force.set(i, (own.at(i) - before.at(i)) + (own.at(i) - after.at(i)));
                }
            }
            Some([in_before, in_after]) => {
                let (in_before, in_after) = (in_before.at(block), in_after.at(block));
                for i in 0..LANES {
                    let sum = (own.at(i) - before.at(i)) * in_before.0[i]
                        + (own.at(i) - after.at(i)) * in_after.0[i];
                    force.set(i, sum);
                }
            }
        }
        force
    }
}
