//! Damping of a lattice's springs.

use crate::solver::forces::spring_rows::{SpringBlock, SpringForce, SpringRows, Springs};
use crate::solver::forces::springs::LEAST_LENGTH;
use crate::solver::settings::DampingForm;
use crate::solver::simd::block::{Block3, Blocks, Blocks3, Blocks3Mut, larger};
use crate::solver::simd::isa::Kernel;
use crate::solver::simd::lanes::LANES;
use crate::solver::simd::parallel::{Band, Workspaces, cut_between_rows};
use crate::solver::simd::slots::CutAt;
use crate::solver::simd::soa::{PartMut, Soa};
use crate::solver::topology::lattice::Lattice;

/// Works out the damping force `D`, `F_i = C (v_j - v_i)` for each spring or its part along the spring,
/// of velocities given as displacements.
pub(crate) struct AddDamping<'a> {
    pub band: Band,
    pub springs: DampedSprings<'a>,
    pub d: &'a Soa,
    pub rows: &'a Workspaces<SpringRows>,
    pub target: DampingTarget<'a>,
}

/// The springs that are damped.
#[derive(Clone, Copy)]
pub(crate) struct DampedSprings<'a> {
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
pub(crate) enum DampingTarget<'a> {
    /// Displacements half a substep on: `keep d + gain (a + D w)`.
    Predict {
        /// Part of them that still air leaves.
        keep: f32,
        /// Half a substep, times the time that makes velocities of displacements \[s2\].
        gain: f32,
        /// Accelerations without damping.
        a: &'a Soa,
        /// The predicted displacements.
        predicted: PartMut<'a>,
    },
    /// Accelerations: `a + D w`.
    Accelerations(PartMut<'a>),
}

impl Kernel for AddDamping<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let Band { layout, rows, .. } = self.band.clone();
        let springs = self.springs;
        let mut room = self.rows.take();
        springs.begin(&mut room, rows.start, self.d);
        let blocks = layout.blocks_across();
        for row in rows {
            springs.work_out(&mut room, row, self.d);
            let forces = room.at(&springs.springs(), row);
            let slot = layout.slot(row, 0);
            let w = Blocks::new(self.springs.inverse_mass, slot, blocks);
            match &mut self.target {
                DampingTarget::Predict { keep, gain, a, predicted } => {
                    let (d, a) =
                        (Blocks3::new(self.d, slot, blocks), Blocks3::new(*a, slot, blocks));
                    let mut predicted = Blocks3Mut::new(predicted, slot, blocks);
                    for block in 0..blocks {
                        let (force, w) = (forces.forces(block), w.at(block));
                        let (mut out, a) = (d.at(block), a.at(block));
                        for i in 0..LANES {
                            let damped = a.at(i) + force.at(i) * w.0[i];
                            out.set(i, out.at(i) * *keep + damped * *gain);
                        }
                        predicted.set(block, out);
                    }
                }
                DampingTarget::Accelerations(to) => {
                    let mut to = Blocks3Mut::new(to, slot, blocks);
                    for block in 0..blocks {
                        let (mut force, w) = (forces.forces(block), w.at(block));
                        for i in 0..LANES {
                            force.set(i, force.at(i) * w.0[i]);
                        }
                        to.add(block, &force);
                    }
                }
            }
        }
    }
}

cut_between_rows!(AddDamping, target);

impl CutAt for DampingTarget<'_> {
    fn cut(self, slot: usize) -> (Self, Self) {
        match self {
            Self::Predict { keep, gain, a, predicted } => {
                let (predicted, below) = predicted.cut(slot);
                let below = Self::Predict { keep, gain, a, predicted: below };
                (Self::Predict { keep, gain, a, predicted }, below)
            }
            Self::Accelerations(a) => {
                let (a, below) = a.cut(slot);
                (Self::Accelerations(a), Self::Accelerations(below))
            }
        }
    }
}

impl DampedSprings<'_> {
    /// Works out the damping of a row's springs, of displacements `d`.
    #[inline(always)]
    fn work_out(&self, rows: &mut SpringRows, row: usize, d: &Soa) {
        match self.form {
            DampingForm::Relative => rows.work_out(&self.springs(), row, &Relative { d }),
            DampingForm::Axial => rows.work_out(&self.springs(), row, &Axial { x: self.x, d }),
        }
    }

    /// Begins with a row.
    #[inline(always)]
    fn begin(&self, rows: &mut SpringRows, row: usize, d: &Soa) {
        match self.form {
            DampingForm::Relative => rows.begin(&self.springs(), row, &Relative { d }),
            DampingForm::Axial => rows.begin(&self.springs(), row, &Axial { x: self.x, d }),
        }
    }

    #[inline(always)]
    fn springs(&self) -> Springs<'_> {
        let shear = if self.shear { self.damping } else { 0.0 };
        Springs { lattice: self.lattice, thread: self.damping, shear }
    }
}

/// All of the relative velocity of a spring's ends.
struct Relative<'a> {
    d: &'a Soa,
}

impl<'a> SpringForce for Relative<'a> {
    type Ends = Blocks3<'a>;

    #[inline(always)]
    fn ends(&self, slot: usize, blocks: usize) -> Self::Ends {
        Blocks3::new(self.d, slot, blocks)
    }

    #[inline(always)]
    fn force([first, second]: [&Self::Ends; 2], block: usize, springs: &SpringBlock) -> Block3 {
        let (a, b) = (first.at(block), second.at(block));
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            force.set(i, (b.at(i) - a.at(i)) * springs.constant.0[i]);
        }
        force
    }
}

/// The part of it along the spring.
struct Axial<'a> {
    x: &'a Soa,
    d: &'a Soa,
}

impl<'a> SpringForce for Axial<'a> {
    /// Positions and displacements.
    type Ends = [Blocks3<'a>; 2];

    #[inline(always)]
    fn ends(&self, slot: usize, blocks: usize) -> Self::Ends {
        [Blocks3::new(self.x, slot, blocks), Blocks3::new(self.d, slot, blocks)]
    }

    #[inline(always)]
    fn force([first, second]: [&Self::Ends; 2], block: usize, springs: &SpringBlock) -> Block3 {
        let (a, b) = (first[0].at(block), second[0].at(block));
        let (from, to) = (first[1].at(block), second[1].at(block));
        let mut force = Block3::ZERO;
        for i in 0..LANES {
            let span = b.at(i) - a.at(i);
            let relative = to.at(i) - from.at(i);
            let square = larger(span.dot(span), LEAST_LENGTH * LEAST_LENGTH);
            force.set(i, span * (springs.constant.0[i] * relative.dot(span) / square));
        }
        force
    }
}
