//! Forces of springs and hinges, and damping. Each particle gathers those of its own springs.

use bevy::math::Vec3;

use super::bending::Bend;
use super::isa::Kernel;
use super::lanes::{Block, Block3, LANES, Soa, larger};
use super::lattice::{Family, Lattice};
use super::parameters::DampingForm;

/// Least length of a spring \[m\]: a collapsed one has no direction and pulls nowhere.
const LEAST_LENGTH: f32 = 1e-12;

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
    pub lattice: &'a Lattice,
    pub constants: SpringConstants,
    /// The hinges of both families, where they have any rigidity.
    pub bend: Option<Bend<'a>>,
    pub gravity: Vec3,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
    pub a: &'a mut Soa,
}

impl Kernel for AccumulateForces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let layout = self.lattice.layout;
        let pulls = !self.constants.is_zero();
        for row in 0..layout.rows {
            if let Some(bend) = &mut self.bend {
                bend.begin_row(row);
            }
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let mut force = Block3::ZERO;
                if pulls {
                    force = self.force(slot, Block3::load(self.x, slot));
                }
                if let Some(bend) = &self.bend {
                    let bending = bend.forces(row, column);
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
                a.store(self.a, slot);
            }
        }
    }
}

impl AccumulateForces<'_> {
    #[inline(always)]
    fn force(&self, slot: usize, here: Block3) -> Block3 {
        let mut pairs = [Block3::ZERO; 4];
        let (thread, shear) = (self.constants.thread, self.constants.shear);
        for (pair, springs) in pairs.iter_mut().zip(directions(self.lattice, thread, shear)) {
            for spring in springs.into_iter().flatten() {
                let rest = Block::load(spring.rest, slot - spring.back);
                let shape = Block::load(spring.shape, slot - spring.back);
                let there = Block3::load(self.x, spring.neighbour(slot));
                for i in 0..LANES {
                    let d = there.at(i) - here.at(i);
                    pair.set(i, pair.at(i) + pull(d, rest.0[i], shape.0[i] * spring.constant));
                }
            }
        }
        let mut force = sum_of_pairs(&pairs);
        if self.constants.flexion > 0.0 {
            let stride = self.lattice.layout.stride;
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

#[inline(always)]
pub(super) fn pull(d: Vec3, rest: f32, constant: f32) -> Vec3 {
    let length = larger(d.dot(d).sqrt(), LEAST_LENGTH);
    d * (constant - constant * rest / length)
}

/// Springs between a particle and its neighbour in one direction.
pub(super) struct Direction<'a> {
    rest: &'a [f32],
    shape: &'a [f32],
    constant: f32,
    /// From the particle back to the slot that holds its spring.
    back: usize,
    /// From that slot on to the neighbour; 0 where the neighbour's slot holds the spring.
    on: usize,
}

impl Direction<'_> {
    #[inline(always)]
    fn neighbour(&self, slot: usize) -> usize {
        slot - self.back + self.on
    }
}

/// The directions of a particle's structural and shear springs whose constants are not zero, in pairs
/// of opposite ones: weft, warp, both diagonals.
#[inline(always)]
fn directions(lattice: &Lattice, thread: f32, shear: f32) -> [[Option<Direction<'_>>; 2]; 4] {
    let s = lattice.layout.stride;
    let (weft, warp, diagonal) = (&lattice.weft, &lattice.warp, &lattice.diagonal);
    let antidiagonal = &lattice.antidiagonal_rest;
    let spring = |rest, shape, constant, back, on| {
        (constant > 0.0).then_some(Direction { rest, shape, constant, back, on })
    };
    [
        [
            spring(&weft.rest, &weft.shape, thread, 0, 1),
            spring(&weft.rest, &weft.shape, thread, 1, 0),
        ],
        [
            spring(&warp.rest, &warp.shape, thread, 0, s),
            spring(&warp.rest, &warp.shape, thread, s, 0),
        ],
        [
            spring(&diagonal.rest, &diagonal.shape, shear, 0, s + 1),
            spring(&diagonal.rest, &diagonal.shape, shear, s + 1, 0),
        ],
        // Stored at the cell: its ends are one column on, and one row on.
        [
            spring(antidiagonal, &diagonal.shape, shear, 1, s),
            spring(antidiagonal, &diagonal.shape, shear, s, 1),
        ],
    ]
}

/// Adds up in an order that a mirrored sheet shares: a sum of two does not depend on their order, and
/// mirroring exchanges the two of a pair, or the two pairs of diagonals.
#[inline(always)]
fn sum_of_pairs(pairs: &[Block3; 4]) -> Block3 {
    let mut sum = Block3::ZERO;
    for i in 0..LANES {
        let threads = pairs[0].at(i) + pairs[1].at(i);
        let diagonals = pairs[2].at(i) + pairs[3].at(i);
        sum.set(i, threads + diagonals);
    }
    sum
}

/// Works out the damping force `D`, `F_i = C (v_j - v_i)` for each spring or its part along the spring,
/// of velocities given as displacements.
pub(super) struct AddDamping<'a> {
    pub springs: DampedSprings<'a>,
    pub d: &'a Soa,
    pub target: DampingTarget<'a>,
}

/// The springs that are damped.
#[derive(Clone, Copy)]
pub(super) struct DampedSprings<'a> {
    pub lattice: &'a Lattice,
    /// Force of a spring of shape factor one for a displacement of one \[N/m\].
    pub damping: f32,
    pub form: DampingForm,
    /// Whether shear springs are damped.
    pub shear: bool,
    pub inverse_mass: &'a [f32],
    pub x: &'a Soa,
}

/// Where the damping goes.
pub(super) enum DampingTarget<'a> {
    /// Displacements half a substep on: `keep d + gain (a + D w)`.
    Predict {
        /// Part of them that still air leaves.
        keep: f32,
        /// Half a substep, times the time that makes velocities of displacements \[s2\].
        gain: f32,
        /// Accelerations without damping.
        a: &'a Soa,
        /// The predicted displacements.
        predicted: &'a mut Soa,
    },
    /// Accelerations: `a + D w`.
    Accelerations(&'a mut Soa),
}

impl Kernel for AddDamping<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let layout = self.springs.lattice.layout;
        for row in 0..layout.rows {
            for column in (0..layout.columns).step_by(LANES) {
                let slot = layout.slot(row, column);
                let w = Block::load(self.springs.inverse_mass, slot);
                let d = Block3::load(self.d, slot);
                let force = self.springs.force(slot, self.d, d);
                let mut out = Block3::ZERO;
                match &mut self.target {
                    DampingTarget::Predict { keep, gain, a, predicted } => {
                        let a = Block3::load(a, slot);
                        for i in 0..LANES {
                            let damped = a.at(i) + force.at(i) * w.0[i];
                            out.set(i, d.at(i) * *keep + damped * *gain);
                        }
                        out.store(predicted, slot);
                    }
                    DampingTarget::Accelerations(to) => {
                        let a = Block3::load(to, slot);
                        for i in 0..LANES {
                            out.set(i, a.at(i) + force.at(i) * w.0[i]);
                        }
                        out.store(to, slot);
                    }
                }
            }
        }
    }
}

impl DampedSprings<'_> {
    #[inline(always)]
    fn force(&self, slot: usize, displacements: &Soa, here_d: Block3) -> Block3 {
        let shear = if self.shear { self.damping } else { 0.0 };
        let here = Block3::load(self.x, slot);
        let mut pairs = [Block3::ZERO; 4];
        for (pair, springs) in pairs.iter_mut().zip(directions(self.lattice, self.damping, shear)) {
            for spring in springs.into_iter().flatten() {
                self.add(&spring, slot, displacements, here, here_d, pair);
            }
        }
        sum_of_pairs(&pairs)
    }

    #[inline(always)]
    fn add(
        &self,
        spring: &Direction<'_>,
        slot: usize,
        displacements: &Soa,
        here: Block3,
        here_d: Block3,
        force: &mut Block3,
    ) {
        let shape = Block::load(spring.shape, slot - spring.back);
        let neighbour = spring.neighbour(slot);
        let there_d = Block3::load(displacements, neighbour);
        match self.form {
            DampingForm::Relative => {
                for i in 0..LANES {
                    let relative = there_d.at(i) - here_d.at(i);
                    let constant = shape.0[i] * spring.constant;
                    force.set(i, force.at(i) + relative * constant);
                }
            }
            DampingForm::Axial => {
                let there = Block3::load(self.x, neighbour);
                for i in 0..LANES {
                    let relative = there_d.at(i) - here_d.at(i);
                    let span = there.at(i) - here.at(i);
                    let square = larger(span.dot(span), LEAST_LENGTH * LEAST_LENGTH);
                    let constant = shape.0[i] * spring.constant;
                    let pull = constant * relative.dot(span) / square;
                    force.set(i, force.at(i) + span * pull);
                }
            }
        }
    }
}
