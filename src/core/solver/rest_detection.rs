//! How far a cloth has gone from where it was marked: what tells rest from slow motion. A speed does not,
//! as particles may tremble where they are, and a pendulum stops where it turns.

use bevy_math::Vec3;

use crate::solver::ClothSolver;
use crate::solver::simd::block::{Block, Block3, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::layout::Layout;
use crate::solver::simd::soa::Soa;

/// Where particles were.
#[derive(Clone, Debug)]
pub(crate) struct Mark {
    pub origin: Vec3,
    pub x: Soa,
}

impl Mark {
    pub fn new(layout: Layout) -> Self {
        Self { origin: Vec3::ZERO, x: Soa::zeros(layout.len()) }
    }
}

impl ClothSolver {
    /// Marks where all particles are.
    pub fn mark(&mut self) {
        self.mark.origin = self.state.origin;
        self.mark.x.copy_from(&self.state.x);
    }

    /// How far any particle is, along any axis, from where it was marked, at most \[m\].
    pub fn distance_from_mark(&self) -> f32 {
        self.isa.run(Farthest {
            layout: self.topology.layout(),
            x: &self.state.x,
            mark: &self.mark.x,
            shift: self.state.origin - self.mark.origin,
        })
    }
}

/// Finds the largest difference of a coordinate.
struct Farthest<'a> {
    layout: Layout,
    x: &'a Soa,
    mark: &'a Soa,
    shift: Vec3,
}

impl Kernel for Farthest<'_> {
    type Output = f32;

    #[inline(always)]
    fn run(self) -> f32 {
        let mut most = Block::ZERO;
        for row in 0..self.layout.rows {
            for column in (0..self.layout.columns).step_by(LANES) {
                let slot = self.layout.slot(row, column);
                let inside = self.layout.inside(row, column);
                let (x, mark) = (Block3::load(self.x, slot), Block3::load(self.mark, slot));
                for i in 0..LANES {
                    let way = x.at(i) - mark.at(i) + self.shift;
                    let way = larger(larger(way.x.abs(), way.y.abs()), way.z.abs());
                    most.0[i] = larger(if i < inside { way } else { 0.0 }, most.0[i]);
                }
            }
        }
        most.largest()
    }
}
