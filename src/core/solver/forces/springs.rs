//! Forces of springs and hinges.

use bevy_math::Vec3;

use crate::solver::forces::bending::{Bend, Moments};
use crate::solver::forces::families::Constants;
use crate::solver::forces::spring_rows::{SpringBlock, SpringForce, SpringRows, Springs};
use crate::solver::simd::block::{Block, Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Workspaces, cut_between_rows};
use crate::solver::simd::soa::{PartMut, Soa};
use crate::solver::topology::lattice::{Family, Lattice};

/// Least length of a spring \[m\]: a collapsed one has no direction and pulls nowhere.
pub(crate) const LEAST_LENGTH: f32 = 1e-12;

/// Sets every acceleration to gravity plus what springs and hinges pull: on particle i, a spring's
/// `F_i = k (|d| - L) d / |d|` with `d = x_j - x_i`.
pub(crate) struct AccumulateForces<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    pub constants: Constants,
    /// The hinges of both families, where they have any rigidity.
    pub bend: Option<Bend<'a>>,
    pub gravity: Vec3,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub a: PartMut<'a>,
    pub rows: &'a Workspaces<SpringRows>,
    pub moments: &'a Workspaces<Moments>,
}

impl Kernel for AccumulateForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let pulls = self.constants.pull();
        let (mut springs, mut moments) = (self.rows.take(), self.moments.take());
        let Constants { flexion: constant, .. } = self.constants;
        let (flexed, flexion) =
            (constant > 0.0, Flexion { lattice: self.lattice, constant, x: self.x });
        if pulls {
            springs.begin(&self.springs(), rows.start, &Elastic { x: self.x });
        }
        if let Some(bend) = &self.bend {
            bend.begin(&mut moments, rows.start);
        }
        let blocks = layout.blocks_across();
        for row in rows {
            if pulls {
                springs.work_out(&self.springs(), row, &Elastic { x: self.x });
            }
            if let Some(bend) = &self.bend {
                bend.begin_row(&mut moments, row);
            }
            let slot = layout.slot(row, 0);
            let at_springs = springs.at(&self.springs(), row);
            #[expect(
                clippy::manual_map,
                reason = "a closure that is not inlined keeps the baseline's instructions"
            )]
            let at_hinges = match &self.bend {
                Some(bend) => Some(bend.at(&moments, row)),
                None => None,
            };
            let w = Blocks::new(self.inverse_mass, slot, blocks);
            let mut a = Blocks3Mut::new(&mut self.a, slot, blocks);
            for block in 0..blocks {
                let mut force = Block3::ZERO;
                if pulls {
                    force = at_springs.forces(block);
                }
                if flexed {
                    force = force.plus(&flexion.forces(slot + block * LANES));
                }
                if let Some([weft, warp]) = &at_hinges {
                    let (weft, warp) = (weft.forces(block), warp.forces(block));
                    // Not by `plus`, which here goes through memory: a tenth of the substep.
                    for i in 0..LANES {
                        force.set(i, force.at(i) + (weft.at(i) + warp.at(i)));
                    }
                }
                let w = w.at(block);
                for i in 0..LANES {
                    let g = if w.0[i] > 0.0 { self.gravity } else { Vec3::ZERO };
                    force.set(i, force.at(i) * w.0[i] + g);
                }
                a.set(block, force);
            }
        }
    }
}

cut_between_rows!(AccumulateForces, a);

impl<'a> AccumulateForces<'a> {
    fn springs(&self) -> Springs<'a> {
        let Constants { thread, shear, .. } = self.constants;
        Springs { lattice: self.lattice, thread, shear }
    }
}

/// Springs between every second particle.
struct Flexion<'a> {
    lattice: &'a Lattice,
    constant: f32,
    x: &'a Soa,
}

impl Flexion<'_> {
    /// Forces on a block, along both of its threads.
    #[inline(always)]
    fn forces(&self, slot: usize) -> Block3 {
        let Lattice { layout, weft, warp, .. } = self.lattice;
        let here = Block3::load(self.x, slot);
        let along_warp = self.along(slot, &here, warp, layout.stride);
        self.along(slot, &here, weft, 1).plus(&along_warp)
    }

    /// Springs to the particles two steps away on both sides. Their constant is
    /// `flexion * shape / a^4` for cells of side a, and their rest length that of the two springs
    /// they span.
    #[inline(always)]
    fn along(&self, slot: usize, here: &Block3, springs: &Family, step: usize) -> Block3 {
        let mut force = Block3::ZERO;
        for (first, neighbour) in [(slot, slot + 2 * step), (slot - 2 * step, slot - 2 * step)] {
            let l1 = Block::load(&springs.rest, first);
            let l2 = Block::load(&springs.rest, first + step);
            let s1 = Block::load(&springs.shape, first);
            let s2 = Block::load(&springs.shape, first + step);
            let there = Block3::load(self.x, neighbour);
            for i in 0..LANES {
                let cell = l1.0[i] * l2.0[i];
                // Zero where one of the two springs does not exist.
                let constant = if cell > 0.0 {
                    0.5 * (s1.0[i] + s2.0[i]) * self.constant / (cell * cell)
                } else {
                    0.0
                };
                let d = there.at(i) - here.at(i);
                force.set(i, force.at(i) + pull(d, l1.0[i] + l2.0[i], constant));
            }
        }
        force
    }
}

/// Hooke's law.
struct Elastic<'a> {
    x: &'a Soa,
}

impl<'a> SpringForce for Elastic<'a> {
    type Ends = Blocks3<'a>;

    #[inline(always)]
    fn ends(&self, slot: usize, blocks: usize) -> Self::Ends {
        Blocks3::new(self.x, slot, blocks)
    }

    #[inline(always)]
    fn force([first, second]: [&Self::Ends; 2], block: usize, springs: &SpringBlock) -> Block3 {
        let (a, b) = (first.at(block), second.at(block));
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            force.set(i, pull(b.at(i) - a.at(i), springs.rest.0[i], springs.constant.0[i]));
        }
        force
    }
}

#[inline(always)]
pub(crate) fn pull(d: Vec3, rest: f32, constant: f32) -> Vec3 {
    let length = larger(d.dot(d).sqrt(), LEAST_LENGTH);
    d * (constant - constant * rest / length)
}
