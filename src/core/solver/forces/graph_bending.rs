//! Moments and forces of a mesh's hinges: hinge by hinge where they are curved at rest, else by couplings of particles.

use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::gather::{Places, gather, store};
use crate::solver::simd::isa::TransposingKernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, cut_between_rows};
use crate::solver::simd::slots::SlotsOf;
use crate::solver::simd::soa::Array;
use crate::solver::simd::transpose::{Four, Transpose};
use crate::solver::topology::graph::couplings::Couplings;
use crate::solver::topology::graph::hinges::Curved;

/// Least turn that has a direction.
const LEAST_TURN: f32 = 1e-12;

/// Works out the moments `K (D - D0)` of all hinges.
pub(crate) struct Turn<'a> {
    /// Of pages of hinges.
    pub band: Band,
    pub hinges: &'a Curved,
    /// K of each hinge \[N/m\].
    pub constants: &'a [f32],
    pub places: &'a Places,
    pub moments: SlotsOf<'a, Four>,
}

cut_between_rows!(transposing Turn, moments);

impl TransposingKernel for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self, t: impl Transpose) {
        let hinges = self.hinges;
        let x = &self.places.x;
        for at in self.band.slots().step_by(LANES) {
            let from = gather(t, x, &hinges.slots[0], at);
            let mut turn = Block3::ZERO;
            for corner in 0..3 {
                let x = gather(t, x, &hinges.slots[corner + 1], at);
                let weight = Block::load(&hinges.weights[corner], at);
                for i in 0..LANES {
                    turn.set(i, turn.at(i) + (x.at(i) - from.at(i)) * weight.0[i]);
                }
            }
            let constant = Block::load(self.constants, at);
            let rest = Block::load(&hinges.turn, at);
            for i in 0..LANES {
                let d = turn.at(i);
                let length = larger(d.dot(d).sqrt(), LEAST_TURN);
                turn.set(i, d * (constant.0[i] * (1.0 - rest.0[i] / length)));
            }
            store(t, self.moments.from(at), 0, turn, Block::ZERO);
        }
    }
}

/// The hinges' moments, for the forces of a block of particles.
#[derive(Clone, Copy)]
pub(crate) struct Turned<'a> {
    pub hinges: &'a Curved,
    pub moments: &'a [Four],
}

impl Turned<'_> {
    /// Takes the forces of a block's hinges off.
    #[inline(always)]
    pub fn add(&self, t: impl Transpose, block: usize, force: &mut Block3) {
        let table = &self.hinges.table;
        let (from, to) = table.rows(block);
        for at in (from..to).step_by(LANES) {
            let weight = Block::load(&self.hinges.own_weight, at);
            let moment = gather(t, self.moments, &table.to, at);
            for i in 0..LANES {
                force.set(i, force.at(i) - moment.at(i) * weight.0[i]);
            }
        }
    }
}

/// Couplings with their constants in use.
#[derive(Clone, Copy)]
pub(crate) struct Coupled<'a> {
    pub couplings: &'a Couplings,
    /// By entry \[N/m\].
    pub constants: &'a Array,
}

impl Coupled<'_> {
    /// Adds the forces on a block of particles, which are `here`.
    #[inline(always)]
    pub fn add(
        &self,
        t: impl Transpose,
        block: usize,
        here: &Block3,
        all: &[Four],
        force: &mut Block3,
    ) {
        let table = &self.couplings.table;
        let (from, to) = table.rows(block);
        for at in (from..to).step_by(LANES) {
            let constant = Block::load(self.constants, at);
            let there = gather(t, all, &table.to, at);
            for i in 0..LANES {
                force.set(i, force.at(i) + (there.at(i) - here.at(i)) * constant.0[i]);
            }
        }
    }
}
