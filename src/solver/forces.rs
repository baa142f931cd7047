//! Forces of springs and hinges.

use bevy::math::Vec3;

use super::bands::{Band, Rooms, cut_between_rows};
use super::bending::{Bend, Moments};
use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, PartMut, Soa, larger};
use super::lattice::{Family, Lattice, Layout};
use super::rows::{SpringForce, SpringRows, Springs};

/// Least length of a spring \[m\]: a collapsed one has no direction and pulls nowhere.
pub(super) const LEAST_LENGTH: f32 = 1e-12;

/// Constants of the explicit springs, for a spring of shape factor one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SpringConstants {
    /// Structural springs \[N/m\].
    pub thread: f32,
    /// Shear springs \[N/m\].
    pub shear: f32,
    /// Flexion springs, between every second particle \[N m4\]: over the fourth power of their cells.
    pub flexion: f32,
}

impl SpringConstants {
    pub fn is_zero(&self) -> bool {
        *self == Self::default()
    }
}

/// Sets every acceleration to gravity plus what springs and hinges pull: on particle i, a spring's
/// `F_i = k (|d| - L) d / |d|` with `d = x_j - x_i`.
pub(super) struct AccumulateForces<'a> {
    pub band: Band,
    pub lattice: &'a Lattice,
    pub constants: SpringConstants,
    /// The hinges of both families, where they have any rigidity.
    pub bend: Option<Bend<'a>>,
    pub gravity: Vec3,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub a: PartMut<'a>,
    pub rows: &'a Rooms<SpringRows>,
    pub moments: &'a Rooms<Moments>,
}

impl Kernel for AccumulateForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let pulls = !self.constants.is_zero();
        let (mut springs, mut moments) = (self.rows.take(), self.moments.take());
        if pulls {
            springs.begin(&self.springs(), rows.start, &Elastic { x: self.x });
        }
        if let Some(bend) = &self.bend {
            bend.begin(&mut moments, rows.start);
        }
        for row in rows {
            if let Some(bend) = &self.bend {
                bend.begin_row(&mut moments, row);
            }
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let mut force = Block3::ZERO;
                if pulls {
                    force = self.force(&mut springs, row, column);
                }
                if let Some(bend) = &self.bend {
                    let bending = bend.forces(&moments, row, column);
                    for i in 0..LANES {
                        force.set(i, force.at(i) + bending.at(i));
                    }
                }
                let w = Block::load(self.inverse_mass, slot);
                let mut a = Block3::ZERO;
                for i in 0..LANES {
                    let g = if w.0[i] > 0.0 { self.gravity } else { Vec3::ZERO };
                    a.set(i, force.at(i) * w.0[i] + g);
                }
                a.store(&mut self.a, slot);
            }
        }
    }
}

cut_between_rows!(AccumulateForces, a);

impl<'a> AccumulateForces<'a> {
    fn springs(&self) -> Springs<'a> {
        let SpringConstants { thread, shear, .. } = self.constants;
        Springs { lattice: self.lattice, thread, shear }
    }

    /// Springs of a block, and the halves that those before it have stored for it.
    #[inline(always)]
    fn force(&self, room: &mut SpringRows, row: usize, column: usize) -> Block3 {
        let flexion = self.constants.flexion;
        let springs = self.springs();
        let mut force = room.gather(&springs, row, column, &Elastic { x: self.x });
        if flexion > 0.0 {
            let Layout { stride, .. } = self.lattice.layout;
            let slot = self.lattice.layout.slot(row, column);
            let here = Block3::load(self.x, slot);
            let weft = self.flexion(slot, here, &self.lattice.weft, 1);
            let warp = self.flexion(slot, here, &self.lattice.warp, stride);
            for i in 0..LANES {
                force.set(i, force.at(i) + (weft.at(i) + warp.at(i)));
            }
        }
        force
    }

    /// Springs to the particles two steps away on both sides. Their constant is
    /// `flexion * shape / a^4` for cells of side a, and their rest length that of the two springs
    /// they span.
    #[inline(always)]
    fn flexion(&self, slot: usize, here: Block3, springs: &Family, step: usize) -> Block3 {
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
                    0.5 * (s1.0[i] + s2.0[i]) * self.constants.flexion / (cell * cell)
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

impl SpringForce for Elastic<'_> {
    #[inline(always)]
    fn force(&self, here: usize, there: usize, rest: Block, constant: Block) -> Block3 {
        let (a, b) = (Block3::load(self.x, here), Block3::load(self.x, there));
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            force.set(i, pull(b.at(i) - a.at(i), rest.0[i], constant.0[i]));
        }
        force
    }
}

#[inline(always)]
pub(super) fn pull(d: Vec3, rest: f32, constant: f32) -> Vec3 {
    let length = larger(d.dot(d).sqrt(), LEAST_LENGTH);
    d * (constant - constant * rest / length)
}
